//! Connection of a vertex with a sampled point of a surface. In go both, out comes the radiance that the
//! vertex scatters towards the eye. Invariant: walks may reach the same point by chance, and the weights of
//! both techniques add up to 1.
//!
//! The weights are those of the balance heuristic (Veach & Guibas 1995, "Optimally combining sampling
//! techniques for Monte Carlo rendering", section 3.3).

use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::{Snapshot, SurfacePoint};
use glam::DVec3;

/// Vertex at which light is scattered towards the eye.
pub(super) struct Receiver<'a> {
    pub(super) place: DVec3,
    /// Triangle that the vertex lies on; `None` in fog.
    pub(super) leaving: Option<PrimitiveId>,
    /// Share of the radiance from a direction that is scattered, 1/sr, in fog 1/(m sr).
    pub(super) scattered: &'a dyn Fn(DVec3) -> Rgb,
    /// Probability density with which walks sample a direction, 1/sr.
    pub(super) pdf: &'a dyn Fn(DVec3) -> f64,
}

/// Sampled point of a triangle.
pub(super) struct Target {
    pub(super) primitive: PrimitiveId,
    pub(super) position: DVec3,
    /// Probability density of the point, 1/m^2.
    pub(super) per_m2: f64,
}

impl Receiver<'_> {
    /// Estimate of the radiance that the vertex scatters of light from points such as the target, each with
    /// the radiance `radiance`, W m^-2 sr^-1.
    pub(super) fn lit_by(
        &self,
        snapshot: &Snapshot,
        target: &Target,
        radiance: impl FnOnce(&SurfacePoint) -> Rgb,
    ) -> Rgb {
        let way = target.position - self.place;
        let Some(direction) = way.try_normalize().filter(|_| self.leaving != Some(target.primitive)) else {
            return Rgb::ZERO;
        };
        let scattered = (self.scattered)(direction);
        if scattered == Rgb::ZERO {
            return Rgb::ZERO;
        }
        let (ray, distance) = (Ray { origin: self.place, direction }, way.length());
        let visible = visibility(snapshot, &ray, distance, [self.leaving, Some(target.primitive)]);
        if visible == Rgb::ZERO {
            return Rgb::ZERO;
        }
        let point = snapshot.facet(target.primitive).seen_along(&ray, distance);
        let fog = snapshot.medium.transmittance(self.place, direction, distance);
        let density = per_sr(target.per_m2, &point, distance) + (self.pdf)(direction);
        let sum = scattered * visible * fog * radiance(&point) * point.alpha / density;
        if sum.is_finite() { sum } else { Rgb::ZERO }
    }
}

/// Probability density in solid angle of a density over area, seen from a distance, 1/sr.
pub(super) fn per_sr(per_m2: f64, point: &SurfacePoint, distance: f64) -> f64 {
    let cos = point.geometric_normal.dot(point.to_eye).abs();
    if per_m2 > 0.0 { per_m2 * distance * distance / cos } else { 0.0 }
}

/// Transmittance between two triangles, along the legs that a walk would take.
pub(super) fn visibility(
    snapshot: &Snapshot,
    ray: &Ray,
    distance: f64,
    [from, to]: [Option<PrimitiveId>; 2],
) -> Rgb {
    let hit = snapshot.tree.nearest_hit(ray, distance, from);
    if hit.is_some_and(|hit| Some(hit.primitive) != to) {
        return Rgb::ZERO;
    }
    let blended = snapshot.blended_hits(ray, &(0.0..distance), from);
    let others = blended.iter().filter(|hit| Some(hit.point.primitive) != to);
    others.fold(Rgb::ONE, |product, hit| product * hit.point.see_through)
}
