//! A ray with all fog on it. In go a medium and a ray, out come optical depths. Invariant: voxels are
//! traversed once.

use super::beer_lambert::exp_minus;
use super::voxel_cells::VoxelCells;
use super::{FogBank, Medium};
use crate::color::Rgb;
use crate::math::Ray;

/// A ray with its end.
pub struct FoggyRay<'a> {
    pub(super) medium: &'a Medium,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
    /// Cells by bank; `None` for banks without voxels, and an empty list if no bank has any.
    cells: Vec<Option<VoxelCells>>,
}

impl Medium {
    /// Fog along a ray up to its end.
    pub fn along<'a>(&'a self, ray: &'a Ray, t_max: f64) -> FoggyRay<'a> {
        let cells_of = |fog: &FogBank| {
            let voxels = fog.voxels()?;
            let span = fog.visible_span(ray, t_max);
            Some(span.map_or_else(VoxelCells::default, |span| VoxelCells::new(voxels, ray, span)))
        };
        let cells = if self.has_voxels() { self.banks().iter().map(cells_of).collect() } else { Vec::new() };
        FoggyRay { medium: self, ray, t_max, cells }
    }
}

impl FoggyRay<'_> {
    pub(super) fn cells(&self, bank: usize) -> Option<&VoxelCells> {
        self.cells.get(bank)?.as_ref()
    }

    /// Optical depth from the origin to a distance.
    pub fn optical_depth(&self, t: f64) -> Rgb {
        let Ray { origin, direction } = *self.ray;
        let metres = |(number, fog): (usize, &FogBank)| {
            let metres = self.cells(number).map(|cells| cells.metres(t));
            fog.sigma_t * metres.unwrap_or_else(|| fog.length(origin, direction, t))
        };
        self.medium.banks().iter().enumerate().map(metres).sum()
    }

    /// Extinction at a distance, 1/m.
    pub fn extinction(&self, t: f64) -> Rgb {
        let point = self.ray.at(t);
        let density = |(number, fog): (usize, &FogBank)| {
            let density = self.cells(number).map(|cells| cells.density(t));
            fog.sigma_t * density.unwrap_or_else(|| fog.density(point))
        };
        self.medium.banks().iter().enumerate().map(density).sum()
    }

    /// Radiance at the origin of the fog's emission up to a distance, W m^-2 sr^-1.
    pub fn emitted(&self, end: f64) -> Rgb {
        let through = |t: f64| exp_minus(self.optical_depth(t));
        self.medium.emitters.iter().map(|emitter| emitter.along(self.ray, end, through)).sum()
    }
}
