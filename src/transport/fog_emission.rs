//! Emission of fog, as seen straight from the origin of a ray. In go rays, out come radiances. Invariant:
//! nothing is sampled; scattered light of the same emission is indirect light.

use super::path::Path;
use super::visibility::Way;
use crate::color::Rgb;
use crate::math::Ray;

/// Radiance that fog emits along a ray on its way, past blended surfaces, W m^-2 sr^-1.
pub(super) fn on_the_way(path: &Path, ray: &Ray, way: &Way) -> Rgb {
    let medium = &path.snapshot.medium;
    if !path.light.has_rest || !medium.emits() {
        return Rgb::ZERO;
    }
    let along = medium.along(ray, way.distance);
    way.past_blended(|distance| along.emitted(distance))
}
