//! Primary visibility. In go a camera ray and its visible range, out comes its end. Invariant: surfaces that
//! clipping planes hide, or that the camera does not see, end no ray, and are reported.

use super::path::Start;
use crate::accel::Hit;
use crate::math::Ray;
use crate::snapshot::{BlendedHit, Snapshot};
use std::ops::Range;

/// Way of a ray to its first opaque surface.
#[derive(Default)]
pub(super) struct Way {
    /// Distance to its end, metres; infinite if nothing ends it.
    pub(super) distance: f64,
    /// Visible blended surfaces, in order.
    pub(super) blended: Vec<BlendedHit>,
    /// Whether the ray passes opaque surfaces that are not visible.
    pub(super) passes_hidden: bool,
}

#[derive(Clone, Copy, Default)]
pub(super) struct RayEnd {
    /// The nearest visible opaque surface.
    pub(super) hit: Option<Hit>,
    /// Whether the ray passes opaque surfaces that are not visible.
    pub(super) passes_hidden: bool,
}

/// End of a ray at opaque surfaces that are visible: within `shown`, and to rays from that start.
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
