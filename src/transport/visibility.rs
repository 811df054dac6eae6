//! What gets from one place to another past all surfaces. In go a ray and a distance, out comes a
//! transmittance or the blended surfaces that it is the product of. Invariant: scenes without blended
//! surfaces ask one question of one tree, as if there were no such thing.

use crate::accel::{Hit, PrimitiveId};
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{Snapshot, SurfacePoint};
use std::ops::Range;

/// A transmittance below which nothing is followed any further. All that lies behind counts for this share of
/// its radiance at most: a hundred thousandth of what single precision tells.
pub(super) const NEGLIGIBLE: f64 = 1e-12;

/// What lies on a ray before it ends.
#[derive(Default)]
pub(super) struct Way {
    /// Where it ends, metres; infinite if nothing ends it.
    pub(super) distance: f64,
    /// Blended surfaces that show, in order.
    pub(super) blended: Vec<BlendedHit>,
    /// Whether it goes through opaque surfaces that do not show.
    pub(super) passes_hidden: bool,
}

/// A blended surface on a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlendedHit {
    /// Where the ray meets it, metres.
    pub(super) t: f64,
    pub(super) point: SurfacePoint,
}

/// The share of light that surfaces let through within `0 < t < distance`; `skip` is where the ray starts.
pub(super) fn visibility(snapshot: &Snapshot, ray: &Ray, distance: f64, skip: Option<PrimitiveId>) -> Rgb {
    if snapshot.tree.any_hit(ray, distance, skip) {
        return Rgb::ZERO;
    }
    blended_hits(snapshot, ray, &(0.0..distance), skip)
        .iter()
        .fold(Rgb::ONE, |product, hit| product * hit.point.see_through)
}

/// What ends a ray, and what it passes that the camera's clipping planes hide.
#[derive(Clone, Copy, Default)]
pub(super) struct RayEnd {
    /// The nearest opaque surface that shows.
    pub(super) hit: Option<Hit>,
    /// Whether the ray goes through opaque surfaces that do not show.
    pub(super) passes_hidden: bool,
}

/// What a ray meets of opaque surfaces, of which those within a part of it show; `skip` is where it starts.
pub(super) fn ray_end(
    snapshot: &Snapshot,
    ray: &Ray,
    shown: &Range<f64>,
    skip: Option<PrimitiveId>,
) -> RayEnd {
    let Some(hit) = snapshot.tree.nearest_hit(ray, f64::INFINITY, skip) else { return RayEnd::default() };
    if shown.contains(&hit.t) {
        return RayEnd { hit: Some(hit), passes_hidden: false };
    }
    let mut next = None;
    if hit.t < shown.start {
        let rest = Ray { origin: ray.at(shown.start), direction: ray.direction };
        next = snapshot.tree.nearest_hit(&rest, shown.end - shown.start, None);
    }
    let from_start = |hit: Hit| Hit { t: shown.start + hit.t, ..hit };
    RayEnd { hit: next.map(from_start), passes_hidden: true }
}

/// All blended surfaces within a part of a ray, in order, up to where they let next to nothing through.
pub(super) fn blended_hits(
    snapshot: &Snapshot,
    ray: &Ray,
    shown: &Range<f64>,
    skip: Option<PrimitiveId>,
) -> Vec<BlendedHit> {
    let mut blended = Vec::new();
    if !snapshot.has_blended() {
        return blended;
    }
    let (mut from, mut leaving) = (0.0, skip);
    let mut through = Rgb::ONE;
    while through.max_element() > NEGLIGIBLE {
        let rest = Ray { origin: ray.at(from), direction: ray.direction };
        let Some(hit) = snapshot.blended.nearest_hit(&rest, shown.end - from, leaving) else { break };
        let point = snapshot.surface(&rest, &hit);
        from += hit.t;
        leaving = Some(hit.primitive);
        if shown.start <= from {
            through *= point.see_through;
            blended.push(BlendedHit { t: from, point });
        }
    }
    blended
}
