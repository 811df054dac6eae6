//! Transmittance of surfaces. In go a ray and a distance, out comes a transmittance or the blended surfaces
//! whose product it is. Invariant: a scene without blended surfaces costs one query of one tree.

use super::{Snapshot, SurfacePoint};
use crate::accel::{InstanceTree, PrimitiveId};
use crate::color::Rgb;
use crate::math::Ray;
use std::ops::Range;

/// Transmittance below which rays are not traced any further. All radiance behind is multiplied by less than
/// this: a hundred thousandth of the resolution of single precision.
pub const NEGLIGIBLE: f64 = 1e-12;

/// A blended surface on a ray.
#[derive(Clone, Copy, Debug)]
pub struct BlendedHit {
    /// Distance along the ray, metres.
    pub t: f64,
    /// Surface there.
    pub point: SurfacePoint,
}

impl Snapshot<'_> {
    /// Transmittance of surfaces within `0 < t < distance`; `skip` is the triangle on which the ray starts.
    pub fn visibility(&self, ray: &Ray, distance: f64, skip: Option<PrimitiveId>) -> Rgb {
        if self.casting().any_hit(ray, distance, skip) {
            return Rgb::ZERO;
        }
        let dimming = self.hits((self.casting_blended(), |_| true), ray, &(0.0..distance), skip);
        dimming.iter().fold(Rgb::ONE, |product, hit| product * hit.point.see_through)
    }

    /// All blended surfaces within a range of a ray, in order, until the transmittance is negligible.
    pub fn blended_hits(&self, ray: &Ray, shown: &Range<f64>, skip: Option<PrimitiveId>) -> Vec<BlendedHit> {
        self.hits((&self.blended, |_| true), ray, shown, skip)
    }

    /// Blended surfaces that the camera sees.
    pub fn blended_seen(&self, ray: &Ray, shown: &Range<f64>) -> Vec<BlendedHit> {
        self.hits((&self.blended, |primitive| self.is_seen(primitive)), ray, shown, None)
    }

    /// Blended surfaces that attenuate light.
    pub fn blended_casting(&self, ray: &Ray) -> Vec<BlendedHit> {
        self.hits((self.casting_blended(), |_| true), ray, &(0.0..f64::INFINITY), None)
    }

    /// Hits of a tree that `counts` accepts.
    fn hits(
        &self,
        (tree, counts): (&InstanceTree, impl Fn(PrimitiveId) -> bool),
        ray: &Ray,
        shown: &Range<f64>,
        skip: Option<PrimitiveId>,
    ) -> Vec<BlendedHit> {
        let mut blended = Vec::new();
        if tree.is_empty() {
            return blended;
        }
        let (mut from, mut leaving) = (0.0, skip);
        let mut through = Rgb::ONE;
        while through.max_element() > NEGLIGIBLE {
            let rest = Ray { origin: ray.at(from), direction: ray.direction };
            let Some(hit) = tree.nearest_hit(&rest, shown.end - from, leaving) else { break };
            let point = self.surface(&rest, &hit);
            from += hit.t;
            leaving = Some(hit.primitive);
            if shown.start <= from && counts(hit.primitive) {
                through *= point.see_through;
                blended.push(BlendedHit { t: from, point });
            }
        }
        blended
    }
}
