//! The shadow of each triangle by itself, for triangles that transmit light. In goes a [`LightPlane`], out
//! comes an interval for each triangle. Invariant: all is in double precision, and a triangle across the ray
//! shadows only the part of the ray on its far side from the light.

use super::{
    hit::PrimitiveId,
    instance::Instances,
    light_plane::{LightPlane, PlaneFunctions},
    shadow_query::shadowing,
    simd::Portable,
    triangle_cut::Crossing,
    wide_tree::Stack,
};
use glam::DVec3;

/// Part of a ray that a triangle shadows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleShadow {
    /// Triangle.
    pub primitive: PrimitiveId,
    /// Start of its shadow, metres.
    pub start: f64,
    /// End of its shadow, metres.
    pub end: f64,
}

/// Adds the shadow of each triangle by itself.
pub(super) fn add_each_shadow(instances: Instances, plane: &LightPlane, shadows: &mut Vec<TriangleShadow>) {
    let Instances { tree, list } = instances;
    let region = shadowing(Portable, &plane.functions, plane.t_range);
    let stack = &mut Stack::new();
    region.visit_leaves(Portable, tree, stack, |leaf, stack| {
        let instance = &list[leaf as usize];
        let functions = plane.functions.pulled_back(&instance.relative_from_mesh);
        let region = shadowing(Portable, &functions, plane.t_range);
        region.visit_leaves(Portable, &instance.mesh.tree, stack, |leaf, _| {
            let block = &instance.mesh.blocks[leaf as usize];
            for lane in block.lanes() {
                let primitive = PrimitiveId { instance: instance.index, triangle: block.triangles[lane] };
                let shadow = shadow_of(&functions, block.corners(lane), plane.t_range);
                shadows.extend(shadow.map(|(start, end)| TriangleShadow { primitive, start, end }));
            }
        });
    });
}

/// Shadow of a triangle's segment in the plane: that of its part above the ray and before the light.
fn shadow_of(functions: &PlaneFunctions, vertices: [DVec3; 3], (t0, t1): (f64, f64)) -> Option<(f64, f64)> {
    let PlaneFunctions { out_of_plane, along, depth, towards_light } = functions;
    let crossing = Crossing::new(0.0, vertices.map(|vertex| out_of_plane.at(vertex)));
    if !crossing.exists {
        return None;
    }
    let [along, depth, height] = [along, depth, towards_light]
        .map(|functional| crossing.at_ends(vertices.map(|vertex| functional.at(vertex))));
    // From 0 at one end to 1 at the other.
    let (mut from, mut to): (f64, f64) = (0.0, 1.0);
    for [a, b] in [height, depth] {
        let zero = a / (a - b);
        match (a > 0.0, b > 0.0) {
            (true, true) => {}
            (true, false) => to = to.min(zero),
            (false, true) => from = from.max(zero),
            (false, false) => return None,
        }
    }
    if from.partial_cmp(&to) != Some(std::cmp::Ordering::Less) {
        return None;
    }
    let at = |fraction: f64| {
        let mix = |[a, b]: [f64; 2]| (1.0 - fraction) * a + fraction * b;
        // Next to the light the shadow has no end.
        (mix(along) / mix(depth).max(f64::MIN_POSITIVE)).clamp(t0, t1)
    };
    let (a, b) = (at(from), at(to));
    (a != b).then(|| (a.min(b), a.max(b)))
}
