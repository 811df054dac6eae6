//! A stretch of a ray under a distant light. In go the fog on it, out comes the light scattered on any
//! part of it that is lit. Invariant: in closed form wherever there is one; elsewhere from one fit,
//! which a hundred lit parts share.

use crate::color::Rgb;
use crate::math::{Antiderivative, Ray};
use crate::scattering::{Climb, Course, Medium, Stretch, exp_minus, mean_transmittance};
use glam::DVec3;

/// What a fit may be wrong by, as a share of what the whole stretch would scatter without any shadow.
const TOLERANCE: f64 = 1e-11;

/// Light scattered on a stretch, per unit of irradiance.
pub(super) enum SunStretch {
    /// The optical depth changes in proportion to a measure along the ray.
    Closed {
        /// `sigma_s * phase`, per metre at base density and sr.
        scattering: Rgb,
        line: DepthLine,
    },
    /// An integral that has no closed form.
    Fitted(Antiderivative),
}

impl SunStretch {
    pub(super) fn new(medium: &Medium, stretch: &Stretch, ray: &Ray, to_light: DVec3) -> Self {
        let cos = to_light.dot(ray.direction);
        let line = match medium.course(stretch, ray, to_light) {
            Course::Even => DepthLine::even(medium, stretch, ray, to_light),
            Course::Thinning { climb, tau_per_m } => {
                let tau_at_start = tau(medium, stretch, ray, to_light, stretch.start);
                DepthLine { start: stretch.start, climb: Some(climb), tau_at_start, tau_per_m }
            }
            Course::Mixed => {
                let mut fitted = Antiderivative::default();
                let integrand = |t: f64| {
                    let tau = tau(medium, stretch, ray, to_light, t);
                    medium.scattering(stretch, ray, t, cos) * exp_minus(tau)
                };
                fitted.fit(integrand, stretch.start, stretch.end, TOLERANCE);
                return Self::Fitted(fitted);
            }
        };
        Self::Closed { scattering: medium.densest_scattering(stretch, cos), line }
    }

    /// Over a lit part, 1/sr.
    pub(super) fn integral(&self, start: f64, end: f64) -> Rgb {
        match self {
            Self::Closed { scattering, line } => *scattering * line.integral(start, end),
            Self::Fitted(fitted) => fitted.between(start, end),
        }
    }
}

/// Optical depth from the eye over a place on the ray to the light.
fn tau(medium: &Medium, stretch: &Stretch, ray: &Ray, to_light: DVec3, t: f64) -> Rgb {
    medium.tau_to_eye(stretch, ray, t) + medium.optical_depth(ray.at(t), to_light, f64::INFINITY)
}

/// The optical depth from the eye to `t` and on to a distant light: linear on a stretch in the metres
/// of fog on the way, counted at the density of the fog's base.
pub(super) struct DepthLine {
    start: f64,
    /// Heights along the ray, where the fog thins out.
    climb: Option<Climb>,
    tau_at_start: Rgb,
    tau_per_m: Rgb,
}

impl DepthLine {
    /// In fog that is as dense everywhere.
    fn even(medium: &Medium, stretch: &Stretch, ray: &Ray, to_light: DVec3) -> Self {
        let width = stretch.end - stretch.start;
        // Just inside, so that a way that starts in a face is measured on this stretch's side.
        let (a, b) = (stretch.start + 1e-3 * width, stretch.end - 1e-3 * width);
        let (tau_a, tau_b) = (tau(medium, stretch, ray, to_light, a), tau(medium, stretch, ray, to_light, b));
        let tau_per_m = (tau_b - tau_a) / (b - a);
        let tau_at_start = tau_a - tau_per_m * (a - stretch.start);
        Self { start: stretch.start, climb: None, tau_at_start, tau_per_m }
    }

    fn metres(&self, start: f64, end: f64) -> f64 {
        self.climb.map_or(end - start, |climb| climb.metres_at_base_density(start, end))
    }

    /// `integral of density * exp(-tau) dt` over `[start, end]`, metres at base density.
    ///
    /// Written as `metres * exp(-tau_min) * (1 - exp(-d)) / d` with `d` the difference of the ends'
    /// depths: nothing cancels, neither in thin fog nor as the ray turns towards the sun (`d -> 0`).
    fn integral(&self, start: f64, end: f64) -> Rgb {
        let (before, metres) = (self.metres(self.start, start), self.metres(start, end));
        let one = |at_start: f64, per_m: f64| {
            let (tau_start, change) = (at_start + per_m * before, per_m * metres);
            let nearest = tau_start + change.min(0.0);
            metres * (-nearest).exp() * mean_transmittance(change.abs())
        };
        let (tau, k) = (self.tau_at_start, self.tau_per_m);
        if tau.x == tau.y && tau.y == tau.z && k.x == k.y && k.y == k.z {
            return Rgb::splat(one(tau.x, k.x));
        }
        Rgb::new(one(tau.x, k.x), one(tau.y, k.y), one(tau.z, k.z))
    }
}
