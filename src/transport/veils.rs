//! Blended surfaces in the light's way or in the eye's. In go a ray and a light, out come the intervals of the ray that they dim.
//! Invariant: a surface dims the ray by what it lets through where the light, or the eye, looks through it.

use super::visibility::{BlendedHit, blended_hits};
use crate::accel::{LightPlane, PrimitiveId, TriangleShadow};
use crate::color::Rgb;
use crate::fog::LitSegments;
use crate::light::FrozenLight;
use crate::math::Ray;
use crate::snapshot::Snapshot;

/// Into so many equal parts the shadow of a textured triangle is cut; each takes the alpha that the light
/// to its middle meets.
const TEXTURED_PARTS: usize = 8;

/// Dims a ray by all that the camera looks through on it, and by what lies in the light's way.
pub(super) fn add(
    lit: &mut LitSegments,
    snapshot: &Snapshot,
    (ray, light): (&Ray, &FrozenLight),
    plane: Option<&LightPlane>,
    blended: &[BlendedHit],
) {
    for hit in blended {
        lit.dim(hit.t, f64::INFINITY, hit.point.see_through);
    }
    let Some(plane) = plane else {
        for (shadow, see_through) in shadows_in_line(snapshot, ray, light, lit.range().0) {
            lit.dim(shadow.start, shadow.end, see_through);
        }
        return lit.resolve();
    };
    let mut shadows = Vec::new();
    snapshot.blended.add_each_shadow(plane, &mut shadows);
    for shadow in shadows {
        let parts = if snapshot.is_textured(shadow.primitive) { TEXTURED_PARTS } else { 1 };
        let width = (shadow.end - shadow.start) / parts as f64;
        for part in 0..parts {
            let start = shadow.start + part as f64 * width;
            let end = if part + 1 == parts { shadow.end } else { start + width };
            let transmittance = met_at(snapshot, ray, light, shadow.primitive, 0.5 * (start + end));
            lit.dim(start, end, transmittance);
        }
    }
    lit.resolve();
}

/// Where ray and light are in one line, every blended surface on it hides the light from what lies beyond: its shadow and what it
/// lets through, as seen from a place on the ray.
pub(super) fn shadows_in_line(
    snapshot: &Snapshot,
    ray: &Ray,
    light: &FrozenLight,
    from: f64,
) -> impl Iterator<Item = (TriangleShadow, Rgb)> {
    let light_at = match *light {
        FrozenLight::Sun { to_light, .. } => f64::INFINITY.copysign(to_light.dot(ray.direction)),
        FrozenLight::Point { position, .. } => (position - ray.origin).dot(ray.direction),
    };
    [1.0, -1.0].into_iter().flat_map(move |sign| {
        let line = Ray { origin: ray.at(from), direction: sign * ray.direction };
        blended_hits(snapshot, &line, &(0.0..f64::INFINITY), None).into_iter().map(move |hit| {
            let t = from + sign * hit.t;
            let (start, end) = if t < light_at { (f64::NEG_INFINITY, t) } else { (t, f64::INFINITY) };
            (TriangleShadow { primitive: hit.point.primitive, start, end }, hit.point.see_through)
        })
    })
}

/// What gets through a triangle of the light that goes to a place on the ray.
pub(super) fn met_at(
    snapshot: &Snapshot,
    ray: &Ray,
    light: &FrozenLight,
    primitive: PrimitiveId,
    t: f64,
) -> Rgb {
    let origin = ray.at(t);
    let (to_light, ..) = light.arriving_at(origin);
    let way = Ray { origin, direction: to_light };
    let facet = snapshot.facet(primitive);
    let distance = facet.distance_along(&way);
    if distance.is_finite() { facet.seen_along(&way, distance).see_through } else { Rgb::ONE }
}
