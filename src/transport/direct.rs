//! Direct light on a surface. In goes a surface point, out the radiance that it reflects.
//! Invariant: a light on the far side of a surface gives nothing (no transmission).

use super::visibility::visibility;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{FrozenLight, Snapshot, SurfacePoint};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Lambert: `albedo / pi * sum(cos * irradiance * visibility * transmittance)`, W m^-2 sr^-1.
pub(super) fn reflected(snapshot: &Snapshot, lights: &[FrozenLight], point: &SurfacePoint) -> Rgb {
    lights
        .iter()
        .map(|light| {
            let Some(unshadowed) = Unshadowed::new(light, point) else { return Rgb::ZERO };
            let Unshadowed { radiance, to_light, distance } = unshadowed;
            let shadow_ray = Ray { origin: point.position, direction: to_light };
            let visible = visibility(snapshot, &shadow_ray, distance, Some(point.primitive));
            if visible == Rgb::ZERO {
                return Rgb::ZERO;
            }
            radiance * visible * snapshot.medium.transmittance(point.position, to_light, distance)
        })
        .sum()
}

/// What a surface reflects of one light if nothing is in the way.
pub(super) struct Unshadowed {
    /// W m^-2 sr^-1.
    pub(super) radiance: Rgb,
    /// Unit vector.
    pub(super) to_light: DVec3,
    /// Metres.
    pub(super) distance: f64,
}

impl Unshadowed {
    /// `None` if it is nothing at all.
    #[inline]
    pub(super) fn new(light: &FrozenLight, point: &SurfacePoint) -> Option<Self> {
        let (to_light, distance, arriving) = light.arriving_at(point.position);
        let cos = point.shading_normal.dot(to_light);
        let faces_light = cos > 0.0 && point.geometric_normal.dot(to_light) > 0.0;
        let shines = faces_light && arriving != Rgb::ZERO && point.albedo != Rgb::ZERO;
        shines.then(|| Self { radiance: FRAC_1_PI * cos * point.albedo * arriving, to_light, distance })
    }
}
