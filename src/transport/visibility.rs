//! What gets from one place to another past all surfaces. In go a ray and a distance, out comes a
//! transmittance or the blended surfaces that it is the product of. Invariant: scenes without blended surfaces
//! ask one question of one tree, as if there were no such thing.

use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{Snapshot, SurfacePoint};

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
    blended_hits(snapshot, ray, distance, skip)
        .iter()
        .fold(Rgb::ONE, |product, hit| product * hit.point.see_through)
}

/// All blended surfaces within `0 < t < distance`, in order.
pub(super) fn blended_hits(
    snapshot: &Snapshot,
    ray: &Ray,
    distance: f64,
    skip: Option<PrimitiveId>,
) -> Vec<BlendedHit> {
    let mut blended = Vec::new();
    if !snapshot.has_blended() {
        return blended;
    }
    let (mut from, mut leaving) = (0.0, skip);
    loop {
        let rest = Ray { origin: ray.at(from), direction: ray.direction };
        let Some(hit) = snapshot.blended.nearest_hit(&rest, distance - from, leaving) else { break };
        let point = snapshot.surface(&rest, &hit);
        from += hit.t;
        leaving = Some(hit.primitive);
        blended.push(BlendedHit { t: from, point });
    }
    blended
}
