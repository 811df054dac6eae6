//! Emission of fog, by voxels. In go rays and transmittances along them, out comes radiance. Invariant: each
//! cell has its own Gauss rule, exact without absorption.

use crate::color::Rgb;
use crate::math::{Ray, Voxels, bounds, corners, gauss_legendre};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// Number of nodes of the rule.
const NODES: usize = 3;

/// Emission of one colour with the density of voxels, frozen at one time.
#[derive(Clone, Debug)]
pub struct Emitter {
    voxel_from_relative: DAffine3,
    voxels: Arc<Voxels>,
    /// Emission where voxels are 1, W m^-3 sr^-1.
    per_voxel: Rgb,
}

impl Emitter {
    /// `None` if it is dark, or flat.
    pub fn new(relative_from_voxel: DAffine3, voxels: Arc<Voxels>, per_voxel: Rgb) -> Option<Self> {
        let voxel_from_relative = relative_from_voxel.inverse();
        let shines = voxel_from_relative.is_finite() && per_voxel.max_element() > 0.0;
        shines.then_some(Self { voxel_from_relative, voxels, per_voxel })
    }

    /// Its bounds, in relative space.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let relative_from_voxel = self.voxel_from_relative.inverse();
        bounds(corners(self.voxels.bounds()).map(|corner| relative_from_voxel.transform_point3(corner)))
    }

    /// Emission at a point in every direction, W m^-3 sr^-1.
    pub(super) fn at(&self, point: DVec3) -> Rgb {
        self.per_voxel * self.voxels.at(self.voxel_from_relative.transform_point3(point))
    }

    /// Radiance at the ray's origin of its emission up to a distance, W m^-2 sr^-1; `through` is the
    /// transmittance from there.
    pub(super) fn along(&self, ray: &Ray, end: f64, through: impl Fn(f64) -> Rgb) -> Rgb {
        let line = Ray {
            origin: self.voxel_from_relative.transform_point3(ray.origin),
            direction: self.voxel_from_relative.transform_vector3(ray.direction),
        };
        let mut sum = Rgb::ZERO;
        self.voxels.for_each_cell(&line, (0.0, end), |cell| {
            let half = 0.5 * (cell.end - cell.start);
            for (node, weight) in gauss_legendre(NODES) {
                let from_start = half * (1.0 + node);
                sum += half * *weight * cell.values.at(from_start) * through(cell.start + from_start);
            }
        });
        self.per_voxel * sum
    }
}
