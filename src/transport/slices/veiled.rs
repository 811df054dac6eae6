//! Rays of a slice that blended surfaces affect. In go the half plane's cuts of these surfaces, out comes,
//! ray by ray, whether one may lie on it or occlude the light. Invariant: no affected ray is missed.

use super::light_rays::LightRays;
use super::sweep::Sweep;
use crate::accel::Cut;
use crate::math::PlanarRay;

/// Sweep over blended surfaces alone: their shadows only mark rays.
#[derive(Default)]
pub(super) struct VeilSweep {
    pub(super) sweep: Sweep,
}

/// Tolerance for names, as cuts have single precision.
const SLACK: f64 = 1.0 + 1e-4;

impl VeilSweep {
    /// Starts anew, as [`Sweep::start`].
    pub(super) fn start(&mut self, cuts: &[Cut], light_rays: LightRays, lowest_slopes: &[f64]) {
        self.sweep.start(cuts, light_rays, lowest_slopes);
    }

    /// Moves on to the next part of the slice, as [`Sweep::enter`].
    pub(super) fn enter(&mut self, highest_slope: f64) {
        self.sweep.enter(highest_slope, |_, _| {});
    }

    /// Moves on to the next ray, which ends at a distance; whether blended surfaces may affect it.
    pub(super) fn touches(&mut self, ray: &PlanarRay, light_rays: LightRays, distance: f64) -> bool {
        self.sweep.advance(ray, light_rays, |_, _| {});
        let end = if distance.is_finite() {
            light_rays.through(distance * ray.direction) * SLACK
        } else {
            f64::INFINITY
        };
        let (above, own) = self.sweep.shadows(None);
        [above, own].iter().any(|shadows| shadows.as_slice().first().is_some_and(|(start, _)| *start <= end))
    }
}
