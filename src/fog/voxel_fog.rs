//! Fog with the density of a grid of voxels. In go rays in relative space, out come metres and densities.
//! Invariant: metres along a ray are exact; those towards lights are interpolated on lattices.

use crate::light::LightPlace;
use crate::math::{Cubic, LitVoxels, Ray, VoxelDepths, VoxelMeans};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// The grid of a bank.
#[derive(Clone, Debug)]
pub(super) struct VoxelFog {
    grid: Arc<LitVoxels>,
    voxel_from_relative: DAffine3,
    /// Length of a voxel along its longest axis, metres.
    widest_voxel_m: f64,
    /// Suns: their directions, and the factor from depths in voxels to metres.
    suns: Vec<Sun>,
    lamps: Vec<Lamp>,
}

#[derive(Clone, Debug)]
struct Sun {
    to_light: DVec3,
    metres_per_voxel: f64,
    depths: Arc<VoxelDepths>,
}

#[derive(Clone, Debug)]
struct Lamp {
    /// Position in voxel space.
    place: DVec3,
    means: Arc<VoxelMeans>,
}

/// Maximum number of lamps with a lattice; rays to others traverse the voxels.
const MOST_LAMPS: usize = 32;

/// Maximum distance in voxels between a point of a lamp and the centre, for which means are computed.
const BESIDE: f64 = 0.5;

/// Number of steps in a voxel to which lamps' positions are rounded for their lattices, so these do not
/// depend on the camera.
const STEPS: f64 = 4096.0;

/// Minimum cosine between a point of a sun's disc and its centre, for which depths are computed: a degree.
const NEAR: f64 = 0.999_85;

impl VoxelFog {
    pub(super) fn new(relative_from_voxel: DAffine3, grid: Arc<LitVoxels>) -> Self {
        let axes = relative_from_voxel.matrix3;
        let widest_voxel_m =
            [axes.x_axis, axes.y_axis, axes.z_axis].map(DVec3::length).into_iter().fold(0.0, f64::max);
        let voxel_from_relative = relative_from_voxel.inverse();
        Self { grid, voxel_from_relative, widest_voxel_m, suns: Vec::new(), lamps: Vec::new() }
    }

    /// Computes depths to lights; `densest_per_m` is the extinction at maximum density.
    pub(super) fn lit_by(self, lights: &[LightPlace], densest_per_m: f64) -> Self {
        let sun = |to_light: DVec3| {
            let direction = self.voxel_from_relative.transform_vector3(to_light);
            let metres_per_voxel = direction.length().recip();
            let depths = self.grid.depths_towards(direction, densest_per_m * metres_per_voxel)?;
            Some(Sun { to_light, metres_per_voxel, depths })
        };
        let lamp = |position: DVec3| {
            let place = (STEPS * self.voxel_from_relative.transform_point3(position)).round() / STEPS;
            Lamp { place, means: self.grid.means_to(place, densest_per_m * self.widest_voxel_m) }
        };
        let (mut suns, mut lamps) = (Vec::new(), Vec::new());
        for light in lights {
            match *light {
                LightPlace::Towards(to_light) => suns.extend(sun(to_light)),
                LightPlace::At(position) if lamps.len() < MOST_LAMPS => lamps.push(lamp(position)),
                LightPlace::At(_) => {}
            }
        }
        Self { suns, lamps, ..self }
    }

    fn line(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.voxel_from_relative.transform_point3(ray.origin),
            direction: self.voxel_from_relative.transform_vector3(ray.direction),
        }
    }

    /// Metres at maximum density between two places on a ray.
    pub(super) fn metres(&self, ray: &Ray, start: f64, end: f64) -> f64 {
        self.grid.voxels.integral(&self.line(ray), (start, end)) / self.grid.voxels.most()
    }

    /// As [`Self::metres`], or any number above `most` once the sum exceeds that.
    pub(super) fn metres_up_to(&self, ray: &Ray, span: (f64, f64), most: f64) -> f64 {
        let densest = self.grid.voxels.most();
        self.grid.voxels.integral_up_to(&self.line(ray), span, most * densest) / densest
    }

    /// Metres at maximum density from the first of some places on a ray, in order, to each.
    pub(super) fn metres_before_each(&self, ray: &Ray, places: &[f64]) -> Vec<f64> {
        let mut integrals = self.grid.voxels.integrals(&self.line(ray), places);
        integrals.iter_mut().for_each(|integral| *integral /= self.grid.voxels.most());
        integrals
    }

    /// Metres at maximum density along a ray up to `end`; voxels may be averaged over `widest_m` metres.
    pub(super) fn rough_metres(&self, ray: &Ray, end: f64, widest_m: f64) -> f64 {
        let times = widest_m / self.widest_voxel_m;
        self.grid.rough_integral(&self.line(ray), (0.0, end), times) / self.grid.voxels.most()
    }

    /// Metres at maximum density along a ray towards the sky, in its direction or one near it.
    pub(super) fn metres_to_sky(&self, ray: &Ray, widest_m: f64) -> f64 {
        let times = widest_m / self.widest_voxel_m;
        self.grid.rough_integral_to_sky(&self.line(ray), times) / self.grid.voxels.most()
    }

    /// Whether both are the same fog, lit by the same suns.
    pub(super) fn is(&self, other: &Self) -> bool {
        let suns = |fog: &Self| fog.suns.iter().map(|sun| sun.to_light).collect::<Vec<_>>();
        Arc::ptr_eq(&self.grid, &other.grid)
            && self.voxel_from_relative == other.voxel_from_relative
            && suns(self) == suns(other)
    }

    pub(super) fn density(&self, point: DVec3) -> f64 {
        self.grid.voxels.at(self.voxel_from_relative.transform_point3(point)) / self.grid.voxels.most()
    }

    /// Metres towards a sun from places on a ray; `None` if no sun is in that direction.
    pub(super) fn towards_sun(&self, ray: &Ray, to_light: DVec3) -> Option<MetresToSun> {
        let sun = self.suns.iter().find(|sun| sun.to_light.dot(to_light) > NEAR)?;
        let line = sun.depths.line(&self.line(ray));
        Some(MetresToSun { depths: Arc::clone(&sun.depths), line, metres_per_voxel: sun.metres_per_voxel })
    }

    /// Metres between a place and a lamp; `None` if there is no lattice for it.
    pub(super) fn metres_to_lamp(&self, point: DVec3, position: DVec3) -> Option<f64> {
        if self.lamps.is_empty() {
            return None;
        }
        let [from, to] = [point, position].map(|place| self.voxel_from_relative.transform_point3(place));
        let lamp = self.lamps.iter().find(|lamp| lamp.place.distance(to) < BESIDE)?;
        Some(lamp.means.of(&self.grid.voxels, from) * point.distance(position))
    }

    /// Length of a voxel along a ray, metres.
    pub(super) fn voxel_m(&self, ray: &Ray) -> f64 {
        self.voxel_from_relative.transform_vector3(ray.direction).length().recip()
    }

    /// Calls back with the cells on a range of a ray that are not empty: the range of each, and its relative
    /// density.
    pub(super) fn for_each_cell(&self, ray: &Ray, span: (f64, f64), mut each: impl FnMut((f64, f64), Cubic)) {
        let per_most = self.grid.voxels.most().recip();
        self.grid.voxels.for_each_cell(&self.line(ray), span, |cell| {
            each((cell.start, cell.end), cell.values.times(per_most));
        });
    }
}

/// Metres of voxels at maximum density between a sun and places on a ray.
pub(super) struct MetresToSun {
    depths: Arc<VoxelDepths>,
    line: Ray,
    metres_per_voxel: f64,
}

impl MetresToSun {
    pub(super) fn at(&self, t: f64) -> f64 {
        self.metres_per_voxel * self.depths.of(self.line.at(t))
    }
}
