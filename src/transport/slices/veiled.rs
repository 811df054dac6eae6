//! Rays of a slice that blended surfaces affect. In go the half plane's cuts of these surfaces, out comes,
//! ray by ray, whether one may lie on it or occlude the light. Invariant: no affected ray is missed.

use super::light_rays::LightRays;
use super::sweep::Sweep;
use crate::math::PlanarRay;

/// Tolerance for names, as cuts have single precision.
const SLACK: f64 = 1.0 + 1e-4;

/// Moves a sweep over blended surfaces alone on to the next ray, which ends at a distance. Returns whether
/// they may affect it: their shadows only mark rays.
pub(super) fn touches(veils: &mut Sweep, ray: &PlanarRay, light_rays: LightRays, distance: f64) -> bool {
    veils.advance(ray, light_rays, |_, _| {});
    let end = if distance.is_finite() {
        light_rays.through(distance * ray.direction) * SLACK
    } else {
        f64::INFINITY
    };
    let (above, own) = veils.shadows(None);
    [above, own].iter().any(|shadows| shadows.as_slice().first().is_some_and(|(start, _)| *start <= end))
}
