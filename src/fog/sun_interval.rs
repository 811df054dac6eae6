//! An interval of a ray under a distant light. In go the fog on it, out comes the light scattered on any lit
//! part of it. Invariant: in closed form wherever there is one; elsewhere from one fit, shared by all lit
//! parts.

use super::beer_lambert::{exp_minus, mean_transmittance};
use super::falloff::Climb;
use super::ray_interval::RayInterval;
use super::voxel_interval::VoxelInterval;
use crate::color::Rgb;
use crate::math::{Antiderivative, Ray};
use glam::DVec3;

/// Tolerance of a fit, relative to the light scattered on the whole interval without shadows.
const TOLERANCE: f64 = 1e-11;

/// Light scattered on an interval, per unit of irradiance.
pub(super) enum SunInterval<'a> {
    Closed(ClosedForm),
    /// A quadrature rule for each cell.
    Voxels(VoxelInterval<'a>),
    /// An integral that has no closed form.
    Fitted(Antiderivative),
}

impl<'a> SunInterval<'a> {
    pub(super) fn new(interval: &'a RayInterval, to_light: DVec3) -> Self {
        let cos = to_light.dot(interval.ray.direction);
        if let Some(voxels) = VoxelInterval::new(interval, to_light) {
            return Self::Voxels(voxels);
        }
        if let Some(closed) = ClosedForm::of(interval, to_light) {
            return Self::Closed(closed);
        }
        let mut fitted = Antiderivative::default();
        let integrand = |t: f64| interval.scattering(t, cos) * exp_minus(interval.tau(t));
        fitted.fit(integrand, interval.start, interval.end, TOLERANCE);
        Self::Fitted(fitted)
    }

    /// Integral over a lit part, 1/sr.
    pub(super) fn integral(&mut self, start: f64, end: f64) -> Rgb {
        match self {
            Self::Closed(closed) => closed.integral(start, end),
            Self::Fitted(fitted) => fitted.between(start, end),
            Self::Voxels(voxels) => voxels.integral(start, end),
        }
    }
}

/// Closed form for an optical depth, from the eye to `t` and on to a distant light, that is linear in the
/// metres of fog up to `t`, at the density of the fog's base.
pub(super) struct ClosedForm {
    /// `sigma_s * phase`, per metre at base density and sr.
    scattering: Rgb,
    start: f64,
    /// Heights along the ray, where the fog thins out.
    climb: Option<Climb>,
    tau_at_start: Rgb,
    tau_per_m: Rgb,
}

impl ClosedForm {
    /// `None` if the optical depth is not linear.
    fn of(interval: &RayInterval, to_light: DVec3) -> Option<Self> {
        let RayInterval { ray, start, .. } = *interval;
        let middle = interval.middle();
        let (mut thinning, mut count) = (None, 0);
        for (index, fog) in interval.medium.banks().iter().enumerate() {
            let is_inside = interval.is_inside(index);
            if !is_inside && fog.length(ray.at(middle), to_light, f64::INFINITY) == 0.0 {
                continue;
            }
            count += 1;
            if fog.is_even() {
                continue;
            }
            let climb = fog.climb(ray).filter(|_| !fog.is_bounded())?;
            // Below the base the density is uniform, and the column above has the same depth everywhere.
            if climb.height(middle) <= 0.0 {
                continue;
            }
            // At height u the way to a light at the elevation k' has a depth of exp(-u) / k', and per metre
            // at base density u grows by k exp(u): the two exponentials cancel.
            let towards_light = fog.climb(&Ray { origin: DVec3::ZERO, direction: to_light })?;
            if !is_inside || towards_light.per_m <= 0.0 {
                return None;
            }
            thinning = Some((climb, fog.sigma_t * (1.0 - climb.per_m / towards_light.per_m)));
        }
        let scattering = interval.densest_scattering(to_light.dot(ray.direction));
        if let Some((climb, tau_per_m)) = thinning {
            let tau_at_start = interval.tau(start);
            let line = Self { scattering, start, climb: Some(climb), tau_at_start, tau_per_m };
            return (count == 1).then_some(line);
        }
        let (tau_at_start, tau_per_m) = interval.line(|t| interval.tau(t));
        Some(Self { scattering, start, climb: None, tau_at_start, tau_per_m })
    }

    fn metres(&self, start: f64, end: f64) -> f64 {
        self.climb.map_or(end - start, |climb| climb.metres_at_base_density(start, end))
    }

    /// `integral of density * exp(-tau) dt` over `[start, end]`, times the scattering.
    ///
    /// The integral is written as `metres * exp(-tau_min) * (1 - exp(-d)) / d`, where `d` is the difference
    /// of the depths at the ends: nothing cancels, neither in thin fog nor as the ray turns towards the sun
    /// (`d -> 0`).
    fn integral(&self, start: f64, end: f64) -> Rgb {
        let (before, metres) = (self.metres(self.start, start), self.metres(start, end));
        let one = |at_start: f64, per_m: f64| {
            let (tau_start, change) = (at_start + per_m * before, per_m * metres);
            let nearest = tau_start + change.min(0.0);
            metres * (-nearest).exp() * mean_transmittance(change.abs())
        };
        let (tau, k) = (self.tau_at_start, self.tau_per_m);
        if tau.x == tau.y && tau.y == tau.z && k.x == k.y && k.y == k.z {
            return self.scattering * Rgb::splat(one(tau.x, k.x));
        }
        self.scattering * Rgb::new(one(tau.x, k.x), one(tau.y, k.y), one(tau.z, k.z))
    }
}
