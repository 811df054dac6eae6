//! Light scattered by fog towards the start of a ray, by whichever method was chosen. Invariant:
//! all methods estimate the same integral; only `Segments` is exact.

use super::equiangular;
use super::march::{self, MarchSteps};
use super::radiance::Scratch;
use super::visibility::Way;
use crate::color::Rgb;
use crate::math::{Ray, Sampler};
use crate::snapshot::{FrozenLight, Snapshot};

/// How the integral along the ray is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VolumeMethod {
    /// Exact visibility intervals from geometry, closed forms and quadrature on smooth pieces.
    Segments,
    /// A shadow ray at each step.
    March(MarchSteps),
    /// Shadow rays at points spread evenly over the angle seen from the light (Kulla & Fajardo 2012).
    Equiangular {
        /// Points a ray and light, at least 1.
        points: u32,
    },
}

/// Radiance scattered into the ray by all `lights` on its way, W m^-2 sr^-1.
#[allow(clippy::too_many_arguments, reason = "what a method may need, in one call")]
pub(super) fn in_scattered(
    snapshot: &Snapshot,
    method: VolumeMethod,
    lights: &[FrozenLight],
    ray: &Ray,
    way: &Way,
    sampler: &mut Sampler,
    scratch: &mut Scratch,
) -> Rgb {
    let (distance, blended) = (way.distance, way.blended.as_slice());
    let mut sum = Rgb::ZERO;
    for light in lights {
        sum += match method {
            VolumeMethod::Segments => {
                let Scratch { lit, cuts, stretches, .. } = scratch;
                let Some(range) = snapshot.medium.range(ray, distance) else { continue };
                snapshot.medium.stretches(ray, distance, light.place(), cuts, stretches);
                lit.find_along(snapshot, ray, light, range, way);
                lit.integrate(&snapshot.medium, stretches, ray, light)
            }
            VolumeMethod::March(steps) => {
                march::in_scattered(snapshot, steps, ray, distance, light, blended, sampler)
            }
            VolumeMethod::Equiangular { points } => {
                equiangular::in_scattered(snapshot, points, ray, distance, light, blended, sampler)
            }
        };
    }
    sum
}
