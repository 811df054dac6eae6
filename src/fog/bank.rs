//! One bank of fog: its place, its density, its optics. In go lines, out come lengths and densities.
//! Invariant: lengths are exact also for lines in a face of the bank's box, and finite also for infinite
//! lines.

use super::beer_lambert::NOTHING_LEFT;
use super::falloff::{Climb, Falloff};
use super::voxel_fog::VoxelFog;
use crate::color::Rgb;
use crate::light::LightPlace;
use crate::math::{LitVoxels, Ray, corners};
use glam::{DAffine3, DMat3, DVec3};
use std::sync::Arc;

/// Tolerance of edges: a superfluous cut costs one exponential, a missing cut is an error, so rounding must
/// lose none.
pub(super) const EDGE_SLACK: f64 = 1e-9;

/// Maximum length of rays through unbounded fog, in metres: the range of coordinates.
const FARTHEST_M: f64 = 1e15;

/// Maximum optical depth over which voxels may be averaged.
const DEEPEST: f64 = 0.125;

/// Optical depth beyond which fog is opaque.
pub(super) const OPAQUE: f64 = 60.0;

/// Density of fog relative to its maximum. A new kind is a variant: see docs/decisions/fog.md.
#[derive(Clone, Debug)]
pub(super) enum Density {
    /// Uniform.
    Even,
    /// Decreasing with height.
    Thinning(Falloff),
    /// A grid of voxels, whose box is the bank's.
    Voxels(VoxelFog),
}

/// Fog in a parallelepiped, or everywhere. Frozen at one time.
#[derive(Clone, Debug)]
pub struct FogBank {
    /// Map into the cube of the box. For unbounded fog it maps everything to the centre of the cube, so no
    /// line leaves the cube.
    pub(super) cube_from_relative: DAffine3,
    pub(super) density: Density,
    /// Extinction at maximum density, 1/m.
    pub sigma_t: Rgb,
    /// Scattering coefficient at maximum density, 1/m.
    pub sigma_s: Rgb,
    /// Henyey-Greenstein g.
    pub g: f64,
    /// Density where keys make it densest, relative to its own. What this decides does not change while keys
    /// change the fog.
    pub densest: f64,
    /// Whether no key moves it.
    pub stays: bool,
}

impl FogBank {
    /// Fog in the image of `[-1, 1]^3`; `None` if the box is flat or the fog has no effect.
    pub fn in_box(relative_from_cube: DAffine3, sigma_t: Rgb, albedo: Rgb, g: f64) -> Option<Self> {
        let cube_from_relative = relative_from_cube.inverse();
        let useful = cube_from_relative.is_finite() && sigma_t.max_element() > 0.0;
        let sigma_s = sigma_t * albedo;
        let density = Density::Even;
        useful.then_some(Self { cube_from_relative, density, sigma_t, sigma_s, g, densest: 1.0, stays: true })
    }

    /// Unbounded fog; `None` if it has no effect.
    pub fn everywhere(falloff: Falloff, sigma_t: Rgb, albedo: Rgb, g: f64) -> Option<Self> {
        let cube_from_relative = DAffine3 { matrix3: DMat3::ZERO, translation: DVec3::ZERO };
        let sigma_s = sigma_t * albedo;
        let density = Density::Thinning(falloff);
        let is_fog = sigma_t.max_element() > 0.0;
        is_fog.then_some(Self { cube_from_relative, density, sigma_t, sigma_s, g, densest: 1.0, stays: true })
    }

    /// Fog that also thins out with height. The falloff's base is a plane `y` of the box's cube.
    pub fn thinning(self, falloff: Falloff) -> Self {
        Self { density: Density::Thinning(falloff), ..self }
    }

    /// Fog with the density of voxels, whose value 1 has the extinction `sigma_t`; `None` if it has no
    /// effect.
    pub fn of_voxels(
        relative_from_voxel: DAffine3,
        grid: Arc<LitVoxels>,
        sigma_t: Rgb,
        albedo: Rgb,
        g: f64,
    ) -> Option<Self> {
        let (low, high) = grid.voxels.bounds();
        let voxel_from_cube =
            DAffine3 { matrix3: DMat3::from_diagonal(0.5 * (high - low)), translation: 0.5 * (low + high) };
        let sigma_t = grid.voxels.most() * sigma_t;
        let bank = Self::in_box(relative_from_voxel * voxel_from_cube, sigma_t, albedo, g)?;
        Some(Self { density: Density::Voxels(VoxelFog::new(relative_from_voxel, grid)), ..bank })
    }

    /// Fog with precomputed optical depths to lights at these places.
    pub fn lit_by(self, lights: &[LightPlace]) -> Self {
        match self.density {
            Density::Voxels(voxels) => {
                let voxels = voxels.lit_by(lights, self.sigma_t.max_element());
                Self { density: Density::Voxels(voxels), ..self }
            }
            _ => self,
        }
    }

    /// Its voxels, if it has any.
    pub(super) fn voxels(&self) -> Option<&VoxelFog> {
        match &self.density {
            Density::Voxels(voxels) => Some(voxels),
            Density::Even | Density::Thinning(_) => None,
        }
    }

    /// Share of its scattering that harmonics below a degree cannot separate from unscattered light: delta-M,
    /// `f = g^degree` (Wiscombe 1977, "The delta-M method", eq. 14).
    pub(super) fn forward_peak(&self, degree: i32) -> f64 {
        self.g.max(0.0).powi(degree)
    }

    /// Delta-M scaled fog: light in the forward peak counts as unscattered.
    pub(super) fn without_peak(&self, degree: i32) -> Self {
        Self { sigma_t: self.sigma_t - self.forward_peak(degree) * self.sigma_s, ..self.clone() }
    }

    /// Whether it has bounds at its sides.
    pub(super) fn is_bounded(&self) -> bool {
        self.cube_from_relative.matrix3.x_axis != DVec3::ZERO
    }

    /// Its bounds in relative space; `None` if it has none.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        self.is_bounded().then(|| {
            let relative_from_cube = self.cube_from_relative.inverse();
            let reach =
                |axis: usize| (0..3).map(|side| relative_from_cube.matrix3.col(side)[axis].abs()).sum();
            let reach = DVec3::new(reach(0), reach(1), reach(2));
            (relative_from_cube.translation - reach, relative_from_cube.translation + reach)
        })
    }

    /// Maximum extinction over all time, in the channel where it is largest, 1/m.
    pub fn most_ever_per_m(&self) -> f64 {
        self.densest * self.sigma_t.max_element()
    }

    /// Whether its density is uniform.
    pub(super) fn is_even(&self) -> bool {
        matches!(self.density, Density::Even)
    }

    /// Heights along a ray, if its density depends on height.
    pub(super) fn climb(&self, ray: &Ray) -> Option<Climb> {
        match &self.density {
            Density::Even | Density::Voxels(_) => None,
            Density::Thinning(falloff) => Some(falloff.along(ray)),
        }
    }

    /// Whether its density varies around a place on a ray.
    pub(super) fn changes_at(&self, ray: &Ray, t: f64) -> bool {
        match &self.density {
            Density::Even => false,
            Density::Thinning(falloff) => falloff.along(ray).height(t) > 0.0,
            Density::Voxels(_) => true,
        }
    }

    /// Metres of fog at maximum density between two places on a ray that are inside.
    pub(super) fn metres(&self, ray: &Ray, start: f64, end: f64) -> f64 {
        match &self.density {
            Density::Even => (end - start).max(0.0),
            Density::Thinning(falloff) => falloff.along(ray).metres_at_base_density(start, end),
            Density::Voxels(voxels) => voxels.metres(ray, start, end),
        }
    }

    /// Relative density at a place on a ray that is inside.
    pub(super) fn density_along(&self, ray: &Ray, t: f64) -> f64 {
        match &self.density {
            Density::Even => 1.0,
            Density::Thinning(falloff) => falloff.along(ray).density(t),
            Density::Voxels(voxels) => voxels.density(ray.at(t)),
        }
    }

    /// Range of the line inside, as `t` that may be negative; `None` if the line misses.
    pub(super) fn span(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (origin, direction) = self.in_cube(ray.origin, ray.direction);
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if origin[axis].abs() > 1.0 {
                    return None;
                }
                continue;
            }
            let low = (-1.0 - origin[axis]) / direction[axis];
            let high = (1.0 - origin[axis]) / direction[axis];
            enter = enter.max(low.min(high));
            leave = leave.min(low.max(high));
        }
        (enter < leave).then_some((enter, leave))
    }

    /// Range of the ray within `[0, t_max]` that has visible fog. It is finite, as distances and heights
    /// without visible fog are left out.
    pub(super) fn visible_span(&self, ray: &Ray, t_max: f64) -> Option<(f64, f64)> {
        let (enter, leave) = self.span(ray)?;
        let (mut enter, mut leave) = (enter.max(0.0), leave.min(t_max).min(FARTHEST_M));
        if let Some(climb) = self.climb(ray) {
            let lowest = climb.height(enter).min(climb.height(leave)).max(0.0);
            let at_ceiling = (lowest + NOTHING_LEFT - climb.start) / climb.per_m;
            if climb.per_m > 0.0 {
                leave = leave.min(at_ceiling);
            } else if climb.per_m < 0.0 {
                enter = enter.max(at_ceiling);
            }
            let thinnest = self.sigma_t.to_array().into_iter().filter(|sigma| *sigma > 0.0);
            let metres = NOTHING_LEFT / thinnest.fold(f64::INFINITY, f64::min);
            leave = leave.min(enter + climb.distance_to_gather(enter, metres));
        }
        (enter < leave).then_some((enter, leave))
    }

    /// Metres of fog at maximum density on `origin + t * direction`, `0 < t < t_max`, for a unit direction.
    pub(super) fn length(&self, origin: DVec3, direction: DVec3, t_max: f64) -> f64 {
        let ray = Ray { origin, direction };
        let Some((enter, leave)) = self.span(&ray) else { return 0.0 };
        self.metres(&ray, enter.max(0.0), leave.min(t_max))
    }

    /// Metres at maximum density between two points.
    pub(super) fn length_between(&self, from: DVec3, to: DVec3) -> f64 {
        let way = to - from;
        let distance = way.length();
        if !self.is_even() {
            return if distance > 0.0 { self.length(from, way / distance, distance) } else { 0.0 };
        }
        let (from, to) =
            (self.cube_from_relative.transform_point3(from), self.cube_from_relative.transform_point3(to));
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            let (from, to) = (from[axis], to[axis]);
            // A line between two points inside a pair of faces crosses neither; this is the usual case, and
            // needs no division.
            if from.abs().max(to.abs()) <= 1.0 {
                continue;
            }
            if from == to {
                return 0.0;
            }
            let (low, high) = ((-1.0 - from) / (to - from), (1.0 - from) / (to - from));
            enter = enter.max(low.min(high));
            leave = leave.min(low.max(high));
        }
        distance * (leave - enter).max(0.0)
    }

    /// Metres at maximum density from a point to a light; voxels are added up until they are opaque.
    pub(super) fn metres_to(&self, point: DVec3, light: LightPlace) -> f64 {
        match light {
            LightPlace::Towards(to_light) => {
                let Some(voxels) = self.voxels() else { return self.length(point, to_light, f64::INFINITY) };
                let ray = Ray { origin: point, direction: to_light };
                let most = OPAQUE / self.sigma_t.min_element();
                let metres =
                    |(enter, leave): (f64, f64)| voxels.metres_up_to(&ray, (enter.max(0.0), leave), most);
                self.span(&ray).map_or(0.0, metres)
            }
            LightPlace::At(position) => self.length_between(point, position),
        }
    }

    /// Metres as in [`FogBank::metres_to`]; for a lamp from a lattice of voxels where there is one.
    pub(super) fn known_metres_to(&self, point: DVec3, light: LightPlace) -> f64 {
        let known = match (self.voxels(), light) {
            (Some(voxels), LightPlace::At(position)) => voxels.metres_to_lamp(point, position),
            _ => None,
        };
        known.unwrap_or_else(|| self.metres_to(point, light))
    }

    /// Metres as in [`FogBank::length`], with voxels averaged over up to `DEEPEST` of optical depth.
    pub(super) fn rough_length(&self, ray: &Ray, end: f64) -> f64 {
        let Some(voxels) = self.voxels() else { return self.length(ray.origin, ray.direction, end) };
        voxels.rough_metres(ray, end, DEEPEST / self.sigma_t.max_element())
    }

    /// Approximate metres at maximum density up to the sky, for light from all directions.
    pub(super) fn length_to_sky(&self, ray: &Ray) -> f64 {
        let Some(voxels) = self.voxels() else {
            return self.length(ray.origin, ray.direction, f64::INFINITY);
        };
        voxels.metres_to_sky(ray, DEEPEST / self.sigma_t.max_element())
    }

    /// Metres at maximum density from a point to a sun; `None` unless its voxels have depths to that sun.
    pub(super) fn metres_to_sun(&self, point: DVec3, to_light: DVec3) -> Option<f64> {
        let ray = Ray { origin: point, direction: to_light };
        self.voxels()?.towards_sun(&ray, to_light).map(|metres| metres.at(0.0))
    }

    /// Whether both have the same voxels.
    pub(super) fn is_same_voxels(&self, other: &Self) -> bool {
        let optics = |fog: &Self| (fog.sigma_t, fog.sigma_s, fog.g);
        let voxels = self.voxels().zip(other.voxels());
        optics(self) == optics(other) && voxels.is_some_and(|(own, others)| own.is(others))
    }

    /// Corners of its box; `None` if it has no bounds.
    pub fn corners(&self) -> Option<[DVec3; 8]> {
        self.is_bounded().then(|| {
            let relative_from_cube = self.cube_from_relative.inverse();
            corners((DVec3::NEG_ONE, DVec3::ONE)).map(|corner| relative_from_cube.transform_point3(corner))
        })
    }

    /// Whether a ray enters its box or begins there.
    pub(super) fn lies_on(&self, ray: &Ray) -> bool {
        self.span(ray).is_some_and(|(_, leave)| leave > 0.0)
    }

    /// Relative density at a point; 0 outside.
    pub(super) fn density(&self, point: DVec3) -> f64 {
        if self.cube_from_relative.transform_point3(point).abs().max_element() > 1.0 {
            return 0.0;
        }
        self.density_along(&Ray { origin: point, direction: DVec3::ZERO }, 0.0)
    }

    /// Every `t` at which the way from `ray.at(t)` to the light may change the faces that it crosses, or the
    /// ray crosses the base, which counts as another face.
    ///
    /// The way crosses the face `x_i = a` at the fraction `(a - x_i(t)) / w_i(t)` of its length, where `w`
    /// leads to the light. Two faces swap where two such fractions are equal, and that equation is linear in
    /// `t` for distant and for near lights. It counts only where the way crosses the edge between the two
    /// faces.
    pub(super) fn for_each_kink(&self, ray: &Ray, light: LightPlace, mut kink: impl FnMut(f64)) {
        let (origin, direction) = self.in_cube(ray.origin, ray.direction);
        // w(t) = w0 + t * w1.
        let (w0, w1) = match light {
            LightPlace::Towards(to_light) => {
                (self.cube_from_relative.transform_vector3(to_light), DVec3::ZERO)
            }
            LightPlace::At(position) => {
                (self.cube_from_relative.transform_point3(position) - origin, -direction)
            }
        };
        let mut base = None;
        if let Density::Thinning(falloff) = &self.density {
            base = Some(falloff.base_y);
            kink(falloff.along(ray).at_base());
        }
        let faces = |axis: usize| [-1.0, 1.0].into_iter().chain(base.filter(|_| axis == 1));
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            for (face_i, face_j) in faces(i).flat_map(|face_i| faces(j).map(move |face_j| (face_i, face_j))) {
                // (face_i - x_i) w_j = (face_j - x_j) w_i; the terms in t^2 cancel.
                let (gap_i, gap_j) = (face_i - origin[i], face_j - origin[j]);
                let constant = gap_i * w0[j] - gap_j * w0[i];
                let slope = gap_i * w1[j] - direction[i] * w0[j] - gap_j * w1[i] + direction[j] * w0[i];
                let t = -constant / slope;
                let (x, w) = (origin + t * direction, w0 + t * w1);
                let fraction =
                    if w[i].abs() > w[j].abs() { (face_i - x[i]) / w[i] } else { (face_j - x[j]) / w[j] };
                let k = 3 - i - j;
                let on_edge = (x[k] + fraction * w[k]).abs() <= 1.0 + EDGE_SLACK;
                if t.is_finite() && fraction >= 0.0 && on_edge {
                    kink(t);
                }
            }
        }
    }

    /// A point and a direction in the space in which the box is `[-1, 1]^3`.
    pub(super) fn in_cube(&self, origin: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        (
            self.cube_from_relative.transform_point3(origin),
            self.cube_from_relative.transform_vector3(direction),
        )
    }
}

#[cfg(test)]
impl FogBank {
    /// Uniform fog between two corners, of albedo 0.5.
    pub(super) fn between(low: DVec3, high: DVec3, sigma_t: f64) -> Self {
        let relative_from_cube =
            DAffine3::from_translation(0.5 * (low + high)) * DAffine3::from_scale(0.5 * (high - low));
        Self::in_box(relative_from_cube, Rgb::splat(sigma_t), Rgb::splat(0.5), 0.3).expect("a real box")
    }
}
