//! Direct light on a surface. In goes a surface point, out the radiance that it reflects.
//! Invariant: a light on the far side of a surface gives nothing (no transmission).

use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{Snapshot, SurfacePoint};
use std::f64::consts::FRAC_1_PI;

/// Lambert: `albedo / pi * sum(cos * irradiance * visibility * transmittance)`, W m^-2 sr^-1.
pub(super) fn reflected(snapshot: &Snapshot, point: &SurfacePoint) -> Rgb {
    if point.albedo == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let mut irradiance = Rgb::ZERO;
    for light in &snapshot.lights {
        let (to_light, distance, arriving) = light.arriving_at(point.position);
        let cos = point.shading_normal.dot(to_light);
        if cos <= 0.0 || point.geometric_normal.dot(to_light) <= 0.0 || arriving == Rgb::ZERO {
            continue;
        }
        let shadow_ray = Ray { origin: point.position, direction: to_light };
        if !snapshot.tree.any_hit(&shadow_ray, distance, Some(point.primitive)) {
            irradiance += cos * arriving * snapshot.medium.transmittance(point.position, to_light, distance);
        }
    }
    FRAC_1_PI * point.albedo * irradiance
}
