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
            reflected_from(snapshot, light, point, |to_light, distance| {
                let shadow_ray = Ray { origin: point.position, direction: to_light };
                visibility(snapshot, &shadow_ray, distance, Some(point.primitive))
            })
        })
        .sum()
}

/// The same of one light; `visibility` is asked only where the answer matters, with direction and distance of the
/// light, for the share of it that gets past all surfaces.
pub(super) fn reflected_from(
    snapshot: &Snapshot,
    light: &FrozenLight,
    point: &SurfacePoint,
    visibility: impl FnOnce(DVec3, f64) -> Rgb,
) -> Rgb {
    let (to_light, distance, arriving) = light.arriving_at(point.position);
    let cos = point.shading_normal.dot(to_light);
    let faces_light = cos > 0.0 && point.geometric_normal.dot(to_light) > 0.0;
    if !faces_light || arriving == Rgb::ZERO || point.albedo == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let visible = visibility(to_light, distance);
    if visible == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let through = snapshot.medium.transmittance(point.position, to_light, distance);
    FRAC_1_PI * cos * point.albedo * arriving * through * visible
}
