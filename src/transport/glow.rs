//! Light of what glows, scattered once. In go a vertex of a random walk and uniform numbers, out comes an
//! estimate of what it scatters towards the eye. Invariant: a glowing point is found in two ways, picked by
//! its power here and met by the walk, and the shares by which they count make 1.
//!
//! The shares are those of the balance heuristic (Veach & Guibas 1995, "Optimally combining sampling
//! techniques for Monte Carlo rendering", section 3.3).

use super::path::Path;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{Glow, Snapshot, SurfacePoint};
use glam::DVec3;

/// Where a walk turned, and how densely it picked its new direction, 1/sr.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub(super) place: DVec3,
    pub(super) density: f64,
}

/// Radiance that a point of the glow, picked by chance, sends to a place, where `scattered`, 1/sr, scatters
/// it and walks pick directions by the density `picked`, 1/sr.
pub(super) fn scattered(
    path: &mut Path,
    place: DVec3,
    leaving: Option<PrimitiveId>,
    scattered: impl Fn(DVec3) -> Rgb,
    picked: impl Fn(DVec3) -> f64,
) -> Rgb {
    let snapshot = path.snapshot;
    let Some(glow) = snapshot.glow().filter(|_| path.light.self_luminous) else { return Rgb::ZERO };
    let (primitive, target) = glow.pick(snapshot, path.sampler.next_3d());
    let distance = target.distance(place);
    let Some(direction) = (target - place).try_normalize().filter(|_| leaving != Some(primitive)) else {
        return Rgb::ZERO;
    };
    let ray = Ray { origin: place, direction };
    let point = snapshot.facet(primitive).seen_along(&ray, distance);
    let radiance = scattered(direction) * path.light.emitted(&point) * point.alpha;
    if radiance == Rgb::ZERO || !radiance.is_finite() {
        return Rgb::ZERO;
    }
    let visible = visibility(snapshot, &ray, distance, [leaving, Some(primitive)]);
    if visible == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let fog = snapshot.medium.transmittance(place, direction, distance);
    radiance * visible * fog / (picked_per_sr(glow, snapshot, &point, distance) + picked(direction))
}

/// The share by which a glowing point counts that a walk meets; all where it cannot have been picked.
pub(super) fn share_of_met(snapshot: &Snapshot, turn: Option<Turn>, point: &SurfacePoint) -> f64 {
    let (Some(turn), Some(glow)) = (turn, snapshot.glow()) else { return 1.0 };
    let by_power = picked_per_sr(glow, snapshot, point, turn.place.distance(point.position));
    // Seen from its edge it is picked for certain.
    if by_power.is_finite() { turn.density / (turn.density + by_power) } else { 0.0 }
}

/// How densely directions to a point of the glow are picked from a distance, 1/sr.
fn picked_per_sr(glow: &Glow, snapshot: &Snapshot, point: &SurfacePoint, distance: f64) -> f64 {
    let cos = point.geometric_normal.dot(point.to_eye).abs();
    glow.picked_per_m2(snapshot, point.primitive) * distance * distance / cos
}

/// Share of light that comes through between two triangles, by what a walk meets on the way.
fn visibility(snapshot: &Snapshot, ray: &Ray, distance: f64, [from, to]: [Option<PrimitiveId>; 2]) -> Rgb {
    let hit = snapshot.tree.nearest_hit(ray, distance, from);
    if hit.is_some_and(|hit| Some(hit.primitive) != to) {
        return Rgb::ZERO;
    }
    let blended = snapshot.blended_hits(ray, &(0.0..distance), from);
    let others = blended.iter().filter(|hit| Some(hit.point.primitive) != to);
    others.fold(Rgb::ONE, |product, hit| product * hit.point.see_through)
}
