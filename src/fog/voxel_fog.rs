//! Fog as dense as the voxels of a grid. In go rays of relative space, out come metres and densities.
//! Invariant: metres along a ray are exact; towards suns they are interpolated where fog gathers light.

use crate::math::{Ray, SunlitVoxels, VoxelDepths};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// The grid of a bank.
#[derive(Clone, Debug)]
pub(super) struct VoxelFog {
    grid: Arc<SunlitVoxels>,
    voxel_from_relative: DAffine3,
    /// Of suns: where they are, and depths in metres by those in voxels.
    suns: Vec<Sun>,
}

#[derive(Clone, Debug)]
struct Sun {
    to_light: DVec3,
    metres_per_voxel: f64,
    depths: Arc<VoxelDepths>,
}

/// Cosine of how far a point of a sun's disc may lie from the middle that depths are for: a degree.
const NEAR: f64 = 0.999_85;

impl VoxelFog {
    pub(super) fn new(relative_from_voxel: DAffine3, grid: Arc<SunlitVoxels>) -> Self {
        Self { grid, voxel_from_relative: relative_from_voxel.inverse(), suns: Vec::new() }
    }

    pub(super) fn lit_by(self, to_lights: &[DVec3]) -> Self {
        let sun = |&to_light: &DVec3| {
            let direction = self.voxel_from_relative.transform_vector3(to_light);
            let depths = self.grid.depths_towards(direction);
            Sun { to_light, metres_per_voxel: direction.length().recip(), depths }
        };
        let suns = to_lights.iter().map(sun).collect();
        Self { suns, ..self }
    }

    fn line(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.voxel_from_relative.transform_point3(ray.origin),
            direction: self.voxel_from_relative.transform_vector3(ray.direction),
        }
    }

    /// Between two places on a ray, as dense as the densest.
    pub(super) fn metres(&self, ray: &Ray, start: f64, end: f64) -> f64 {
        self.grid.voxels.integral(&self.line(ray), (start, end)) / self.grid.voxels.most()
    }

    /// As a share of the densest.
    pub(super) fn density(&self, point: DVec3) -> f64 {
        self.grid.voxels.at(self.voxel_from_relative.transform_point3(point)) / self.grid.voxels.most()
    }

    /// Metres towards a sun, as dense as the densest; `None` if none of the suns is there.
    pub(super) fn metres_to_sun(&self, point: DVec3, to_light: DVec3) -> Option<f64> {
        let sun = self.suns.iter().find(|sun| sun.to_light.dot(to_light) > NEAR)?;
        let place = self.voxel_from_relative.transform_point3(point);
        Some(sun.metres_per_voxel * sun.depths.of(place))
    }

    /// Where a ray passes from cell to cell, if they hold something.
    pub(super) fn for_each_cut(&self, ray: &Ray, span: (f64, f64), mut cut: impl FnMut(f64)) {
        self.grid.voxels.for_each_cell(&self.line(ray), span, |cell| {
            cut(cell.start);
            cut(cell.end);
        });
    }

    /// How many metres of a ray are as long as a voxel.
    pub(super) fn voxel_m(&self, ray: &Ray) -> f64 {
        self.voxel_from_relative.transform_vector3(ray.direction).length().recip()
    }
}
