//! One box of homogeneous fog and the lines through it. Invariant: lengths are exact in double
//! precision also for lines that run in a face of the box.

use crate::color::Rgb;
use crate::math::Ray;
use glam::{DAffine3, DVec3};

/// A cut too many costs one exponential, a cut too few an error: rounding must not lose one.
const EDGE_SLACK: f64 = 1e-9;

/// Homogeneous fog in a parallelepiped, frozen at one time.
#[derive(Clone, Copy, Debug)]
pub struct FogBox {
    cube_from_relative: DAffine3,
    /// Extinction, 1/m.
    pub sigma_t: Rgb,
    /// Scattering, 1/m.
    pub sigma_s: Rgb,
    /// Henyey-Greenstein g.
    pub g: f64,
}

impl FogBox {
    /// Fog in the image of `[-1, 1]^3`; `None` if the box is flat or its fog does nothing.
    pub fn new(relative_from_cube: DAffine3, sigma_t: Rgb, albedo: Rgb, g: f64) -> Option<Self> {
        let cube_from_relative = relative_from_cube.inverse();
        let useful = cube_from_relative.is_finite() && sigma_t.max_element() > 0.0;
        useful.then_some(Self { cube_from_relative, sigma_t, sigma_s: sigma_t * albedo, g })
    }

    /// The part of the line that lies inside, as a range of `t` that may be negative; `None` if it misses.
    pub fn span(&self, ray: &Ray) -> Option<(f64, f64)> {
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

    /// Length inside of `origin + t * direction`, `0 < t < t_max`, for a unit direction, metres.
    pub fn length(&self, origin: DVec3, direction: DVec3, t_max: f64) -> f64 {
        self.span(&Ray { origin, direction })
            .map_or(0.0, |(enter, leave)| (leave.min(t_max) - enter.max(0.0)).max(0.0))
    }

    /// Whether a point lies inside.
    pub fn contains(&self, point: DVec3) -> bool {
        self.cube_from_relative.transform_point3(point).abs().max_element() <= 1.0
    }

    /// Every `t` at which the way from `ray.at(t)` to the light may change the faces it crosses.
    ///
    /// The way is cut by the face `x_i = a` at the fraction `(a - x_i(t)) / w_i(t)` of itself, where
    /// `w` leads to the light; two faces swap where two such fractions are equal, and that
    /// equation is linear in `t` for distant and for near lights alike. It counts only where the
    /// way really crosses the edge between the two faces.
    pub fn for_each_kink(&self, ray: &Ray, light: LightPlace, mut kink: impl FnMut(f64)) {
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
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            for (face_i, face_j) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
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
    pub fn in_cube(&self, origin: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        (
            self.cube_from_relative.transform_point3(origin),
            self.cube_from_relative.transform_vector3(direction),
        )
    }
}

/// Where light comes from, in relative space.
#[derive(Clone, Copy, Debug)]
pub enum LightPlace {
    /// From infinitely far away; unit vector towards the light.
    Towards(DVec3),
    /// From a point.
    At(DVec3),
}
