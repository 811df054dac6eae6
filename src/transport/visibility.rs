//! What a ray of the camera meets. In go a ray and the part of it that shows, out comes where it ends.
//! Invariant: what clipping planes hide ends no ray, and is told.

use crate::accel::{Hit, PrimitiveId};
use crate::math::Ray;
use crate::snapshot::{BlendedHit, Snapshot};
use std::ops::Range;

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
