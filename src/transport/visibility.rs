//! Primary visibility. In go a camera ray and its visible range, out comes its end. Invariant: surfaces that
//! clipping planes hide, or that the camera does not see, end no ray, and are reported.

use super::path::Start;
use crate::accel::Hit;
use crate::color::Rgb;
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

impl Way {
    /// Transmittance of the blended surfaces before a distance.
    pub(super) fn seen_through(&self, t: f64) -> Rgb {
        self.blended.iter().filter(|hit| hit.t < t).map(|hit| hit.point.see_through).product()
    }

    /// Radiance of all the way, from that of its start up to a distance without blended surfaces.
    pub(super) fn past_blended(&self, mut before: impl FnMut(f64) -> Rgb) -> Rgb {
        let (mut sum, mut so_far, mut seen_through) = (Rgb::ZERO, Rgb::ZERO, Rgb::ONE);
        for hit in &self.blended {
            let up_to = before(hit.t);
            sum += seen_through * (up_to - so_far);
            (so_far, seen_through) = (up_to, seen_through * hit.point.see_through);
        }
        sum + seen_through * (before(self.distance) - so_far)
    }
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
