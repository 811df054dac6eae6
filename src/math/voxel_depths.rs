//! Depths of voxels towards a sun. In go voxels and a direction, out come depths at any place, from a lattice
//! of lines along the direction. Invariant: at the lattice's nodes they are exact to a 65,535th of the line's
//! whole depth; between them they are linear.

use super::{Ray, Voxels, bounds, close_up, corners};
use glam::DVec3;
use rayon::prelude::*;
use std::fmt;

/// Maximum number of nodes; their distance grows to keep it.
const MOST_NODES: f64 = (1 << 23) as f64;

/// Maximum number of nodes with a distance below `FINE` voxels.
const MOST_FINE_NODES: f64 = (1 << 21) as f64;
const FINE: f64 = 0.5;

/// Number of parts of a line's whole depth: nodes of two bytes take half the memory of `f32`.
const PARTS: f64 = u16::MAX as f64;

/// Depths towards one direction, in voxels of maximum density.
pub struct VoxelDepths {
    /// Unit vectors: two at right angles to the sun, and one towards it.
    axes: [DVec3; 3],
    low: DVec3,
    spacing: f64,
    /// Number of lines along the second axis for each step along the first.
    columns: usize,
    lines: Vec<Line>,
    /// Depths at the nodes of one line after the other, in parts of the line's whole depth: from the last
    /// node before the fog to the first behind it. That one is stored twice, as depths stay the same on the
    /// rest of a line.
    parts: Vec<u16>,
}

/// Location of a line's depths.
#[derive(Clone, Copy, Default)]
struct Line {
    /// Index of its first depth.
    first: u32,
    /// Number of the lattice's nodes before it.
    skipped: u32,
    /// Number of steps from the first to the last.
    steps: u32,
    /// Depth that a part stands for.
    of_part: f32,
}

/// Prints the address alone: depths never change.
impl fmt::Debug for VoxelDepths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VoxelDepths({self:p})")
    }
}

impl VoxelDepths {
    /// Computes depths; `to_light` is a direction in voxel space, `spacing` the minimum distance of nodes, in
    /// voxels. Depths are cut off at `deepest`, in the same unit as they are.
    pub(super) fn new(voxels: &Voxels, to_light: DVec3, (spacing, deepest): (f64, f64)) -> Self {
        let up = to_light.normalize();
        let (right, across) = up.any_orthonormal_pair();
        let axes = [right, across, up];
        let along = |corner: DVec3| DVec3::from_array(axes.map(|axis| axis.dot(corner)));
        let (from, to) = bounds(corners(voxels.bounds()).map(along));
        let apart = |most: f64| ((to - from).element_product() / most).cbrt();
        let spacing = spacing.max(apart(MOST_FINE_NODES).min(FINE)).max(apart(MOST_NODES));
        let size = (to - from).to_array().map(|side| (side / spacing).ceil() as usize + 1);
        let places: Vec<f64> = (0..size[2]).map(|index| spacing * index as f64).collect();
        let of_row = size[1] * (size[2] + 1);
        // What no line comes to write takes no memory.
        let (mut parts, mut lines) = (vec![0; size[0] * of_row], vec![Line::default(); size[0] * size[1]]);
        let row = |(i, (parts, lines)): (usize, (&mut [u16], &mut [Line]))| {
            let mut end = 0;
            for (j, line) in lines.iter_mut().enumerate() {
                let [x, y] = [i, j].map(|index| spacing * index as f64);
                let origin = (from.x + x) * right + (from.y + y) * across + from.z * up;
                let before = voxels.integrals(&Ray { origin, direction: up }, &places);
                let all = before[size[2] - 1];
                let skipped = before.iter().take_while(|before| **before == 0.0).count().saturating_sub(1);
                let until = before.iter().take_while(|before| **before < all).count();
                let nodes = &before[skipped.min(until)..=until];
                let depth = |before: &f64| ((all - before) / voxels.most()).min(deepest);
                let of_part = depth(&0.0) / PARTS;
                let start = end;
                for before in nodes.iter().chain(nodes.last()) {
                    // On an empty line 0 / 0, which is cast to 0.
                    parts[end] = (depth(before) / of_part).round() as u16;
                    end += 1;
                }
                let [first, skipped, steps] =
                    [i * of_row + start, skipped, nodes.len() - 1].map(|count| count as u32);
                *line = Line { first, skipped, steps, of_part: of_part as f32 };
            }
        };
        parts.par_chunks_mut(of_row).zip(lines.par_chunks_mut(size[1])).enumerate().for_each(row);
        close_up(&mut parts, lines.iter_mut().map(|line| (&mut line.first, line.steps as usize + 2)));
        Self { axes, low: from, spacing, columns: size[1], lines, parts }
    }

    /// A line in voxel space, transformed to the lattice's.
    pub fn line(&self, line: &Ray) -> Ray {
        let along = |way: DVec3| DVec3::from_array(self.axes.map(|axis| axis.dot(way))) / self.spacing;
        Ray { origin: along(line.origin) - self.low / self.spacing, direction: along(line.direction) }
    }

    /// Depth at a place in the lattice's space. On the sun's side of the lattice it is 0, beyond it that of
    /// the whole line.
    pub fn of(&self, at: DVec3) -> f64 {
        let last = [self.lines.len() / self.columns - 1, self.columns - 1];
        if !(at.x >= 0.0 && at.y >= 0.0 && at.x <= last[0] as f64 && at.y <= last[1] as f64) {
            return 0.0;
        }
        let (i, j) = (at.x as usize, at.y as usize);
        let between = |i: usize| {
            let line = i * self.columns + j;
            let near = self.on_line(line, at.z);
            near + (at.y - j as f64) * (self.on_line(line + usize::from(j < last[1]), at.z) - near)
        };
        let near = between(i);
        near + (at.x - i as f64) * (between(i + usize::from(i < last[0])) - near)
    }

    /// Depth at a number of steps along a line.
    #[inline]
    fn on_line(&self, line: usize, steps: f64) -> f64 {
        let Line { first, skipped, steps: all, of_part } = self.lines[line];
        let steps = (steps - f64::from(skipped)).clamp(0.0, f64::from(all));
        let node = steps as u32;
        let at = (first + node) as usize;
        let [here, next] = [self.parts[at], self.parts[at + 1]].map(f64::from);
        f64::from(of_part) * (here + (steps - f64::from(node)) * (next - here))
    }
}
