//! Voxels along a ray. In go the cells that it crosses, out come metres and densities. Invariant: each cell
//! is visited once, and metres are exact.

use super::voxel_fog::VoxelFog;
use crate::math::{Cubic, Ray};

/// Cells that are not empty, in order; densities are relative to the maximum.
#[derive(Clone, Debug, Default)]
pub(super) struct VoxelCells(Vec<Cell>);

#[derive(Clone, Copy, Debug)]
struct Cell {
    start: f64,
    end: f64,
    density: Cubic,
    /// Metres at maximum density in all cells before.
    metres_before: f64,
}

impl Cell {
    fn metres(&self, t: f64) -> f64 {
        self.metres_before + self.density.integral(t - self.start)
    }
}

impl VoxelCells {
    pub(super) fn new(voxels: &VoxelFog, ray: &Ray, span: (f64, f64)) -> Self {
        let (mut cells, mut metres_before) = (Vec::new(), 0.0);
        voxels.for_each_cell(ray, span, |(start, end), density| {
            let cell = Cell { start, end, density, metres_before };
            metres_before = cell.metres(end);
            cells.push(cell);
        });
        Self(cells)
    }

    /// Metres at maximum density up to a distance.
    pub(super) fn metres(&self, t: f64) -> f64 {
        self.at(self.cursor(t), t).0
    }

    /// Relative density at a distance.
    pub(super) fn density(&self, t: f64) -> f64 {
        self.at(self.cursor(t), t).1
    }

    /// Calls `border` with the borders of cells.
    pub(super) fn for_each_border(&self, mut border: impl FnMut(f64)) {
        for cell in &self.0 {
            border(cell.start);
            border(cell.end);
        }
    }

    /// Index of the first cell that ends beyond a distance.
    pub(super) fn cursor(&self, t: f64) -> usize {
        self.0.partition_point(|cell| cell.end <= t)
    }

    /// End of the cell or gap at a distance, and whether it is a cell; advances `cursor`.
    pub(super) fn next_border(&self, cursor: &mut usize, t: f64) -> (f64, bool) {
        while self.0.get(*cursor).is_some_and(|cell| cell.end <= t) {
            *cursor += 1;
        }
        match self.0.get(*cursor) {
            Some(cell) if cell.start <= t => (cell.end, true),
            Some(cell) => (cell.start, false),
            None => (f64::INFINITY, false),
        }
    }

    /// Metres up to a distance, and the density there, both relative to the maximum density.
    pub(super) fn at(&self, cursor: usize, t: f64) -> (f64, f64) {
        match self.0.get(cursor) {
            Some(cell) if cell.start <= t => (cell.metres(t), cell.density.at(t - cell.start)),
            Some(cell) => (cell.metres_before, 0.0),
            None => (self.0.last().map_or(0.0, |cell| cell.metres(cell.end)), 0.0),
        }
    }
}
