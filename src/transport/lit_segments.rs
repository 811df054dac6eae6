//! Lit segments of a ray, exactly. In go a ray, a light and the scene, out come the intervals that the light
//! reaches. An opaque triangle shadows an interval of the ray, a blended one dims it. Invariant: the ends of
//! shadows are computed, never sampled.

use super::visibility::Way;
use crate::accel::{LightPlane, PrimitiveId, TriangleShadow};
use crate::color::Rgb;
use crate::fog::LitSegments;
use crate::light::FrozenLight;
use crate::math::Ray;
use crate::snapshot::Snapshot;

/// Number of equal parts of the shadow of a textured triangle. Each has the alpha where light to its middle
/// meets the triangle.
const TEXTURED_PARTS: usize = 8;

/// Returns the parts of `ray` within `range` that `light` reaches. `range` ends at the first surface or
/// before.
pub fn lit_segments(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> LitSegments {
    let mut lit = LitSegments::default();
    lit.start(ray, light, range);
    shade(&mut lit, snapshot, ray, light, &Way::default());
    lit
}

/// Removes shadows of opaque surfaces from the lit parts of a ray. Dims parts behind blended surfaces, seen
/// from the eye and from the light.
pub(super) fn shade(lit: &mut LitSegments, snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, way: &Way) {
    let range = lit.range();
    let plane = match *light {
        FrozenLight::Sun { to_light, .. } => LightPlane::towards_direction(ray, to_light, range),
        FrozenLight::Point { position, .. } => LightPlane::towards_point(ray, position, range),
    };
    if snapshot.has_blended() {
        way.blended.iter().for_each(|hit| lit.dim(hit.t, f64::INFINITY, hit.point.see_through));
        dim(lit, snapshot, (ray, light), plane.as_ref());
    }
    match plane {
        Some(plane) if way.passes_hidden => {
            let mut shadows = Vec::new();
            snapshot.casting().add_each_shadow(&plane, &mut shadows);
            shadows.into_iter().for_each(|shadow| lit.shadows_mut().insert(shadow.start, shadow.end));
        }
        Some(plane) => snapshot.casting().add_shadows(&plane, lit.shadows_mut()),
        None if is_blocked_in_line(snapshot, ray, light, range) => {
            lit.shadows_mut().insert(range.0, range.1);
        }
        None => {}
    }
}

/// Dims the lit parts of a ray where blended surfaces occlude the light.
fn dim(
    lit: &mut LitSegments,
    snapshot: &Snapshot,
    (ray, light): (&Ray, &FrozenLight),
    plane: Option<&LightPlane>,
) {
    let Some(plane) = plane else {
        for (shadow, see_through) in shadows_in_line(snapshot, ray, light, lit.range().0) {
            lit.dim(shadow.start, shadow.end, see_through);
        }
        return lit.resolve();
    };
    let mut shadows = Vec::new();
    snapshot.casting_blended().add_each_shadow(plane, &mut shadows);
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

/// Whether a light on the line of the ray is occluded; if so, for the whole range.
fn is_blocked_in_line(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> bool {
    // The middle of the range sees the light along the ray itself, forwards or backwards. Nothing lies
    // between the ray's origin and the end of the range, so one ray from the middle is enough.
    let origin = ray.at(0.5 * (range.0 + range.1));
    let (to_light, distance, _) = light.arriving_at(origin);
    snapshot.casting().any_hit(&Ray { origin, direction: to_light }, distance, None)
}

/// Shadows of blended surfaces where ray and light are in one line: each hides the light from all points
/// beyond it. Returns each shadow with its transmittance. `from` is the point of the ray from which both
/// directions are searched.
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
        snapshot.blended_casting(&line).into_iter().map(move |hit| {
            let t = from + sign * hit.t;
            let (start, end) = if t < light_at { (f64::NEG_INFINITY, t) } else { (t, f64::INFINITY) };
            (TriangleShadow { primitive: hit.point.primitive, start, end }, hit.point.see_through)
        })
    })
}

/// Transmittance of a triangle for light towards the point of the ray at `t`.
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
