//! The shadow of each triangle by itself, for triangles that transmit light. In goes a [`LightPlane`], out
//! comes an interval for each triangle. Invariant: all is in double precision, and a triangle across the ray
//! shadows only the part of the ray on its far side from the light.

use super::{
    block::Block,
    box_region::{LeafVisitor, visit_leaves},
    hit::PrimitiveId,
    instance::{Instance, Instances},
    light_plane::{LightPlane, PlaneFunctions},
    shadow_query::shadowing,
    simd::{Kernel, Simd},
    triangle_cut::Crossing,
    wide_tree::STACK,
};

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

pub(super) struct AddEachShadow<'a> {
    pub(super) instances: Instances<'a>,
    pub(super) plane: &'a LightPlane,
    pub(super) shadows: &'a mut Vec<TriangleShadow>,
}

impl Kernel for AddEachShadow<'_> {
    type Output = ();
    fn run<S: Simd>(self, simd: S) {
        let Self { instances: Instances { tree, list: instances }, plane, shadows } = self;
        let region = shadowing(simd, &plane.functions, plane.t_range);
        let mut query = InstanceQuery { plane, instances, shadows };
        visit_leaves(simd, tree, &region, &mut Vec::with_capacity(STACK), &mut query);
    }
}

struct InstanceQuery<'a> {
    plane: &'a LightPlane,
    instances: &'a [Instance],
    shadows: &'a mut Vec<TriangleShadow>,
}

impl<S: Simd> LeafVisitor<S> for InstanceQuery<'_> {
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Vec<u32>) {
        let instance = &self.instances[leaf as usize];
        let functions = self.plane.functions.pulled_back(&instance.relative_from_mesh);
        let region = shadowing(simd, &functions, self.plane.t_range);
        let mut query = TriangleQuery {
            blocks: &instance.mesh.blocks,
            functions,
            t_range: self.plane.t_range,
            instance: instance.index,
            shadows: self.shadows,
        };
        visit_leaves(simd, &instance.mesh.tree, &region, stack, &mut query);
    }
}

struct TriangleQuery<'a> {
    blocks: &'a [Block],
    functions: PlaneFunctions,
    t_range: (f64, f64),
    instance: u32,
    shadows: &'a mut Vec<TriangleShadow>,
}

impl<S: Simd> LeafVisitor<S> for TriangleQuery<'_> {
    fn visit(&mut self, _: S, leaf: u32, _: &mut Vec<u32>) {
        let block = &self.blocks[leaf as usize];
        for lane in block.lanes() {
            let vertices = block.corners(lane);
            let PlaneFunctions { out_of_plane, along, depth, towards_light } = &self.functions;
            let crossing = Crossing::new(0.0, vertices.map(|vertex| out_of_plane.at(vertex)));
            if !crossing.exists {
                continue;
            }
            let ends = |values: [f64; 3]| crossing.at_ends(values);
            let shadow = shadow_of(
                ends(vertices.map(|vertex| along.at(vertex))),
                ends(vertices.map(|vertex| depth.at(vertex))),
                ends(vertices.map(|vertex| towards_light.at(vertex))),
                self.t_range,
            );
            if let Some((start, end)) = shadow {
                let primitive = PrimitiveId { instance: self.instance, triangle: block.triangles[lane] };
                self.shadows.push(TriangleShadow { primitive, start, end });
            }
        }
    }
}

/// Shadow of a segment, given the functions' values at its ends: that of its part above the ray and before
/// the light.
fn shadow_of(along: [f64; 2], depth: [f64; 2], height: [f64; 2], (t0, t1): (f64, f64)) -> Option<(f64, f64)> {
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
