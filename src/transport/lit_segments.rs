//! Which parts of a ray a light reaches, exactly. In go a ray, a light and the scene, out come its lit segments: visibility is a union of
//! intervals found from the triangles themselves. Invariant: nothing is sampled, nothing is stepped.

use super::veils;
use super::visibility::Way;
use crate::accel::LightPlane;
use crate::fog::LitSegments;
use crate::light::FrozenLight;
use crate::math::Ray;
use crate::snapshot::Snapshot;

/// Finds what `light` reaches of `ray` within `range`, which must not reach beyond the first surface.
pub fn lit_segments(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> LitSegments {
    let mut lit = LitSegments::default();
    lit.start(ray, light, range);
    shade(&mut lit, snapshot, ray, light, &Way::default());
    lit
}

/// Takes the shadows of a scene away from what is lit of a ray that passes what lies on its way.
pub(super) fn shade(lit: &mut LitSegments, snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, way: &Way) {
    let range = lit.range();
    let plane = match *light {
        FrozenLight::Sun { to_light, .. } => LightPlane::towards_direction(ray, to_light, range),
        FrozenLight::Point { position, .. } => LightPlane::towards_point(ray, position, range),
    };
    if snapshot.has_blended() {
        veils::add(lit, snapshot, (ray, light), plane.as_ref(), &way.blended);
    }
    match plane {
        Some(plane) if way.passes_hidden => {
            let mut shadows = Vec::new();
            snapshot.tree.add_each_shadow(&plane, &mut shadows);
            shadows.into_iter().for_each(|shadow| lit.shadows_mut().insert(shadow.start, shadow.end));
        }
        Some(plane) => snapshot.tree.add_shadows(&plane, lit.shadows_mut()),
        None if is_blocked_in_line(snapshot, ray, light, range) => {
            lit.shadows_mut().insert(range.0, range.1);
        }
        None => {}
    }
}

/// Ray and light in one line: the whole range is lit or dark.
fn is_blocked_in_line(snapshot: &Snapshot, ray: &Ray, light: &FrozenLight, range: (f64, f64)) -> bool {
    // The middle of the range sees the light along the ray itself, forwards or backwards. Between
    // the ray's origin and the end of the range there is nothing, so one ray from there will do.
    let origin = ray.at(0.5 * (range.0 + range.1));
    let (to_light, distance, _) = light.arriving_at(origin);
    snapshot.tree.any_hit(&Ray { origin, direction: to_light }, distance, None)
}
