//! Everything that a half plane cuts. In: a [`HalfPlane`]; out: a segment for each triangle that
//! crosses it. Invariant: triangles that share an edge get the same end there, to the last bit, so a
//! closed mesh has a closed outline.

use super::{
    block::Block,
    instance_tree::Instance,
    light_plane::Functional,
    shadow_query::{BoxLimit, LaneFunctional, LeafVisitor, visit_leaves},
    simd::{Lanes, Mask, Simd, WIDTH},
    stack::Stack,
    triangle_cut::Crossing,
    wide_tree::WideTree,
    PrimitiveId,
};
use glam::{DVec2, DVec3};

/// The half plane `reach >= 0` of the plane through the origin that `axis` and `outward` span.
///
/// Its points have the coordinates `(reach, height) = (outward . p, axis . p)`.
#[derive(Clone, Copy, Debug)]
pub struct HalfPlane {
    /// Unit vector along the edge.
    pub axis: DVec3,
    /// Unit vector at right angles to it.
    pub outward: DVec3,
    /// Only what is above this line matters: `height >= lowest_slope * reach`.
    pub lowest_slope: f64,
}

/// A triangle's cut with a half plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Which triangle.
    pub primitive: PrimitiveId,
    /// The two ends, `(reach, height)` in metres; the reach may be negative, where the triangle goes on
    /// beyond the edge of the half plane.
    pub ends: [DVec2; 2],
}

/// Appends the cuts of all instances, in the order in which the tree meets them.
#[inline(always)]
pub(super) fn add_cuts<S: Simd>(
    simd: S,
    tree: &WideTree,
    instances: &[Instance],
    half_plane: &HalfPlane,
    cuts: &mut Vec<Cut>,
) {
    let linear = |gradient: DVec3| Functional { gradient, offset: 0.0 };
    let out_of_plane = linear(half_plane.axis.cross(half_plane.outward));
    let reach = linear(half_plane.outward);
    let height = linear(half_plane.axis);
    let region = Region { out_of_plane, reach, height, above: height.plus(-half_plane.lowest_slope, &reach) };
    let limits = region.limits(simd, tree.bounds);
    let mut query = SliceQuery { region, instances, cuts };
    visit_leaves(simd, tree, &limits, &mut Stack::new(), &mut query);
}

/// What belongs to the half plane has `out_of_plane = 0`, and `reach` and `above` not negative.
#[derive(Clone, Copy)]
struct Region {
    out_of_plane: Functional,
    reach: Functional,
    height: Functional,
    above: Functional,
}

impl Region {
    #[inline(always)]
    fn limits<S: Simd>(&self, simd: S, bounds: super::wide_tree::Bounds) -> [BoxLimit<S::Lanes>; 4] {
        let below = Functional { gradient: -self.out_of_plane.gradient, offset: -self.out_of_plane.offset };
        [self.out_of_plane, below, self.reach, self.above]
            .map(|functional| BoxLimit::new(simd, &functional, bounds))
    }
}

struct SliceQuery<'a> {
    region: Region,
    instances: &'a [Instance],
    cuts: &'a mut Vec<Cut>,
}

impl<S: Simd> LeafVisitor<S> for SliceQuery<'_> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Stack) {
        let instance = &self.instances[leaf as usize];
        let mesh = &*instance.mesh;
        let here = |functional: &Functional| functional.pulled_back(&instance.relative_from_mesh);
        let region = Region {
            out_of_plane: here(&self.region.out_of_plane),
            reach: here(&self.region.reach),
            height: here(&self.region.height),
            above: here(&self.region.above),
        };
        let limits = region.limits(simd, mesh.tree.bounds);
        // Coordinates are counted from the middle of the mesh: single precision has to resolve a leaf.
        let centre = DVec2::new(region.reach.at(instance.mesh_centre), region.height.at(instance.mesh_centre));
        let from_centre = |functional: &Functional, at_centre: f64| {
            LaneFunctional::new(simd, &Functional { offset: functional.offset - at_centre, ..*functional })
        };
        let mut query = BlockQuery {
            blocks: &mesh.blocks,
            zero: simd.splat(0.0),
            out_of_plane: LaneFunctional::new(simd, &region.out_of_plane),
            reach: from_centre(&region.reach, centre.x),
            height: from_centre(&region.height, centre.y),
            centre,
            instance: instance.index,
            cuts: self.cuts,
        };
        visit_leaves(simd, &mesh.tree, &limits, stack, &mut query);
    }
}

/// A query that goes through one instance's mesh.
struct BlockQuery<'a, L> {
    blocks: &'a [Block],
    zero: L,
    out_of_plane: LaneFunctional<L>,
    reach: LaneFunctional<L>,
    height: LaneFunctional<L>,
    centre: DVec2,
    instance: u32,
    cuts: &'a mut Vec<Cut>,
}

impl<S: Simd> LeafVisitor<S> for BlockQuery<'_, S::Lanes> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, _: &mut Stack) {
        let block = &self.blocks[leaf as usize];
        let corners = |functional: &LaneFunctional<S::Lanes>| {
            std::array::from_fn(|vertex| {
                functional.at(std::array::from_fn(|axis| simd.load(&block.vertices[vertex][axis])))
            })
        };
        let crossing = Crossing::new(self.zero, corners(&self.out_of_plane));
        let mut lanes = crossing.exists.bits();
        if lanes == 0 {
            return;
        }
        let reach = crossing.at_ends(corners(&self.reach)).map(|lanes| simd.store(lanes));
        let height = crossing.at_ends(corners(&self.height)).map(|lanes| simd.store(lanes));
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            let end = |end: usize| {
                self.centre + DVec2::new(f64::from(reach[end][lane]), f64::from(height[end][lane]))
            };
            let primitive = PrimitiveId { instance: self.instance, triangle: block.triangles[lane] };
            self.cuts.push(Cut { primitive, ends: [end(0), end(1)] });
        }
    }
}
