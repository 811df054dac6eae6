//! Light scattered by fog towards the start of a ray, by whichever method was chosen. Invariant:
//! all methods estimate the same integral; only `Segments` is exact.

use super::path::{Path, Scratch, VolumeMethod};
use super::visibility::Way;
use super::{equiangular, march};
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::FrozenLight;

/// Radiance of all lights of the path scattered into a ray on its way, W m^-2 sr^-1.
pub(super) fn in_scattered(path: &mut Path, ray: &Ray, way: &Way) -> Rgb {
    let lights = path.light.lights;
    lights
        .iter()
        .map(|light| match path.transport.volume {
            VolumeMethod::Segments => by_segments(path, ray, way, light),
            VolumeMethod::March(steps) => march::in_scattered(path, steps, ray, way, light),
            VolumeMethod::Equiangular { points } => equiangular::in_scattered(path, points, ray, way, light),
        })
        .sum()
}

fn by_segments(path: &mut Path, ray: &Ray, way: &Way, light: &FrozenLight) -> Rgb {
    let medium = &path.snapshot.medium;
    let Scratch { lit, cuts, stretches, .. } = &mut *path.scratch;
    let Some(range) = medium.range(ray, way.distance) else { return Rgb::ZERO };
    medium.stretches(ray, way.distance, light.place(), cuts, stretches);
    lit.find_along(path.snapshot, ray, light, range, way);
    lit.integrate(medium, stretches, ray, light)
}
