//! Light that fog scatters towards the origin of a ray, by the chosen method. In go rays, out come radiances.
//! Invariant: all methods estimate the same integral; only `Segments` is exact.

use super::lit_segments::shade;
use super::path::{Path, Start, VolumeMethod};
use super::visibility::Way;
use super::{equiangular, march};
use crate::color::Rgb;
use crate::fog::{LitSegments, Passage};
use crate::math::Ray;
use crate::snapshot::FrozenLight;

/// A ray with its end.
pub(super) struct RaySegment<'a> {
    pub(super) ray: &'a Ray,
    pub(super) from: Start,
    pub(super) distance: f64,
}

/// Radiance of all lights of the path scattered into a ray on its way, W m^-2 sr^-1.
pub(super) fn in_scattered(path: &mut Path, (ray, from): (&Ray, Start), way: &Way) -> Rgb {
    let lights = path.light.lights;
    lights
        .iter()
        .map(|light| match path.transport.volume {
            VolumeMethod::Segments | VolumeMethod::Paths(_) => {
                let snapshot = path.snapshot;
                let shadows = |lit: &mut LitSegments| shade(lit, snapshot, ray, light, way);
                let segment = RaySegment { ray, from, distance: way.distance };
                by_segments(path, segment, light, shadows).scattered
            }
            VolumeMethod::March(steps) => march::in_scattered(path, steps, ray, way, light),
            VolumeMethod::Equiangular { points } => equiangular::in_scattered(path, points, ray, way, light),
        })
        .sum()
}

/// In-scattered radiance by the exact method; `shadows` removes shadows from the lit parts.
pub(super) fn by_segments(
    path: &mut Path,
    RaySegment { ray, from, distance }: RaySegment,
    light: &FrozenLight,
    shadows: impl FnOnce(&mut LitSegments),
) -> Passage {
    let seen = path.seen_fog(ray, from);
    let (medium, lit) = (&path.snapshot.medium, &mut path.scratch.lit);
    let Some(range) = medium.range(ray, distance) else { return Passage::NOTHING };
    lit.start(ray, light, range);
    shadows(lit);
    let known = seen.and_then(|seen| seen.passage(distance, lit, light));
    known.unwrap_or_else(|| medium.passage(ray, distance, lit, light))
}
