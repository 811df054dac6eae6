//! Lit segments of a ray, exactly. In go a ray, a light and the scene, out come the parts that the light
//! reaches. Opaque triangles end the light on an interval of the ray, blended ones dim it there.
//! Invariant: where light begins and ends is never sampled.

use super::visibility::Way;
use crate::accel::{LightPlane, PrimitiveId, TriangleShadow};
use crate::color::Rgb;
use crate::fog::LitSegments;
use crate::light::FrozenLight;
use crate::math::Ray;
use crate::snapshot::Snapshot;

/// Into so many equal parts the shadow of a textured triangle is cut; each takes the alpha that the light
/// to its middle meets.
const TEXTURED_PARTS: usize = 8;

/// Finds what `light` reaches of `ray` within `range`, which must not reach beyond the first surface.
pub fn lit_segments(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> LitSegments {
    let mut lit = LitSegments::default();
    lit.start(ray, light, range);
    shade(&mut lit, snapshot, ray, light, &Way::default());
    lit
}

/// Takes shadows out of the lit parts of a ray that passes the surfaces on its way.
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

/// Dims the lit parts of a ray by blended surfaces in the light's way.
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

/// Ray and light in one line: the whole range is lit or dark.
fn is_blocked_in_line(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> bool {
    // The middle of the range sees the light along the ray itself, forwards or backwards. Between
    // the ray's origin and the end of the range there is nothing, so one ray from there will do.
    let origin = ray.at(0.5 * (range.0 + range.1));
    let (to_light, distance, _) = light.arriving_at(origin);
    snapshot.casting().any_hit(&Ray { origin, direction: to_light }, distance, None)
}

/// Where ray and light are in one line, every blended surface on it hides the light from what lies beyond:
/// its shadow and what it lets through, as seen from a place on the ray.
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

/// Transmittance of a triangle for light that goes to the ray's point at `t`.
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
