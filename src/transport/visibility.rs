//! Primary visibility. In go a camera ray and the part of it that shows, out comes where it ends.
//! Invariant: what clipping planes hide, or is invisible to the camera, ends no ray, and is told.

use super::path::Start;
use crate::accel::Hit;
use crate::math::Ray;
use crate::snapshot::{BlendedHit, Snapshot};
use std::ops::Range;

/// Free way of a ray before it ends.
#[derive(Default)]
pub(super) struct Way {
    /// Distance to its end, metres; infinite if nothing ends it.
    pub(super) distance: f64,
    /// Blended surfaces that show, in order.
    pub(super) blended: Vec<BlendedHit>,
    /// Whether it goes through opaque surfaces that do not show.
    pub(super) passes_hidden: bool,
}

/// End of a ray, and whether it passes surfaces that do not show.
#[derive(Clone, Copy, Default)]
pub(super) struct RayEnd {
    /// The nearest opaque surface that shows.
    pub(super) hit: Option<Hit>,
    /// Whether the ray goes through opaque surfaces that do not show.
    pub(super) passes_hidden: bool,
}

/// End of a ray at opaque surfaces, of which those within `shown` show.
pub(super) fn ray_end(snapshot: &Snapshot, ray: &Ray, shown: &Range<f64>, from: Start) -> RayEnd {
    let shows = |hit: &Hit| shown.contains(&hit.t) && from.sees(snapshot, hit.primitive);
    let Some(mut hit) = snapshot.tree.nearest_hit(ray, f64::INFINITY, from.leaving()) else {
        return RayEnd::default();
    };
    let mut passes_hidden = false;
    while !shows(&hit) {
        passes_hidden = true;
        let (start, leaving) =
            if hit.t < shown.start { (shown.start, None) } else { (hit.t, Some(hit.primitive)) };
        let rest = Ray { origin: ray.at(start), direction: ray.direction };
        let Some(next) = snapshot.tree.nearest_hit(&rest, shown.end - start, leaving) else {
            return RayEnd { hit: None, passes_hidden };
        };
        hit = Hit { t: start + next.t, ..next };
    }
    RayEnd { hit: Some(hit), passes_hidden }
}
