//! Cuts of triangles by a half plane. In goes a [`HalfPlane`], out comes a segment for each triangle that
//! crosses it. Invariant: triangles that share an edge have the same end there, to the last bit, so a closed
//! mesh has a closed outline.

use super::{
    block::Block,
    box_region::{BoxLimit, BoxRegion, LaneFunctional, LeafVisitor, may_vanish, visit_leaves},
    hit::PrimitiveId,
    instance::{Instance, Instances},
    light_plane::Functional,
    simd::{Kernel, Mask, Simd, WIDTH},
    triangle_cut::Crossing,
    wide_tree::STACK,
};
use glam::{DVec2, DVec3};

/// The half plane `reach >= 0` of the plane through `eye` that `axis` and `outward` span.
///
/// Its points have the coordinates `(reach, height) = (outward . (p - eye), axis . (p - eye))`.
#[derive(Clone, Copy, Debug)]
pub struct HalfPlane {
    /// A point of the edge, relative to the camera.
    pub eye: DVec3,
    /// Unit vector along the edge.
    pub axis: DVec3,
    /// Unit vector at right angles to it.
    pub outward: DVec3,
    /// Minimum slope of the relevant part: `height >= lowest_slope * reach`.
    pub lowest_slope: f64,
}

/// A triangle's cut with a half plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Triangle.
    pub primitive: PrimitiveId,
    /// The two ends, `(reach, height)` in metres; the reach may be negative where the triangle continues
    /// beyond the edge of the half plane.
    pub ends: [DVec2; 2],
    /// Error bound of the ends, as a share of their distance and of the cut's length.
    pub rounding: f64,
}

impl Cut {
    /// Bound in single precision, which most cuts have: sixteen roundings.
    pub const SINGLE: f64 = 1e-6;
    /// Bound in double precision, with a similar margin, as for a wide ground.
    pub const DOUBLE: f64 = 1e-12;
}

/// Appends the cuts of all instances, in the tree's order.
pub(super) struct AddCuts<'a> {
    pub(super) instances: Instances<'a>,
    pub(super) half_plane: &'a HalfPlane,
    pub(super) cuts: &'a mut Vec<Cut>,
}

impl Kernel for AddCuts<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { instances: Instances { tree, list: instances }, half_plane, cuts } = self;
        let linear = |gradient: DVec3| Functional::vanishing_at(half_plane.eye, gradient);
        let out_of_plane = linear(half_plane.axis.cross(half_plane.outward));
        let reach = linear(half_plane.outward);
        let height = linear(half_plane.axis);
        let above = height.plus(-half_plane.lowest_slope, &reach);
        let region = Region { out_of_plane, reach, height, above };
        let limits = region.limits(simd);
        let mut query = SliceQuery { region, instances, cuts };
        visit_leaves(simd, tree, &limits, &mut Vec::with_capacity(STACK), &mut query);
    }
}

/// Functions of the half plane: there `out_of_plane = 0`, and `reach` and `above` are not negative.
#[derive(Clone, Copy)]
struct Region {
    out_of_plane: Functional,
    reach: Functional,
    height: Functional,
    above: Functional,
}

impl Region {
    #[inline(always)]
    fn limits<S: Simd>(&self, simd: S) -> BoxRegion<S::Lanes, 4> {
        BoxRegion([
            BoxLimit::new(simd, &self.out_of_plane),
            BoxLimit::new(simd, &self.out_of_plane.negated()),
            BoxLimit::new(simd, &self.reach),
            BoxLimit::new(simd, &self.above),
        ])
    }
}

struct SliceQuery<'a> {
    region: Region,
    instances: &'a [Instance],
    cuts: &'a mut Vec<Cut>,
}

impl<S: Simd> LeafVisitor<S> for SliceQuery<'_> {
    #[inline(always)]
    fn expect(&self, simd: S, leaf: u32) {
        simd.prefetch(&self.instances[leaf as usize]);
    }

    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Vec<u32>) {
        let instance = &self.instances[leaf as usize];
        let mesh = &*instance.mesh;
        let here = |functional: &Functional| functional.pulled_back(&instance.relative_from_mesh);
        // The plane misses a third of them: a leaf is flat, and the box of a rotated flat mesh is not.
        let out_of_plane = here(&self.region.out_of_plane);
        if !may_vanish(&out_of_plane, mesh.tree.bounds) {
            return;
        }
        let region = Region {
            out_of_plane,
            reach: here(&self.region.reach),
            height: here(&self.region.height),
            above: here(&self.region.above),
        };
        let limits = region.limits(simd);
        if instance.needs_doubles {
            let (blocks, instance) = (&mesh.blocks[..], instance.index);
            let mut query = DoubleQuery { blocks, region, instance, cuts: self.cuts };
            visit_leaves(simd, &mesh.tree, &limits, stack, &mut query);
            return;
        }
        // Coordinates are relative to the mesh's centre: single precision has to resolve a leaf.
        let centre = DVec2::new(region.reach.at(mesh.centre), region.height.at(mesh.centre));
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

/// Query over one instance's mesh.
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
    fn visit(&mut self, simd: S, leaf: u32, _: &mut Vec<u32>) {
        let block = &self.blocks[leaf as usize];
        let crossing = Crossing::new(self.zero, self.out_of_plane.at_corners(simd, block));
        let mut lanes = crossing.exists.bits();
        if lanes == 0 {
            return;
        }
        let [reach_a, reach_b] = crossing.at_ends(self.reach.at_corners(simd, block));
        let [height_a, height_b] = crossing.at_ends(self.height.at_corners(simd, block));
        let reach = [simd.store(reach_a), simd.store(reach_b)];
        let height = [simd.store(height_a), simd.store(height_b)];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            let end = |end: usize| {
                self.centre + DVec2::new(f64::from(reach[end][lane]), f64::from(height[end][lane]))
            };
            let primitive = PrimitiveId { instance: self.instance, triangle: block.triangles[lane] };
            self.cuts.push(Cut { primitive, ends: [end(0), end(1)], rounding: Cut::SINGLE });
        }
    }
}

/// Query in double precision, one triangle at a time.
struct DoubleQuery<'a> {
    blocks: &'a [Block],
    region: Region,
    instance: u32,
    cuts: &'a mut Vec<Cut>,
}

impl<S: Simd> LeafVisitor<S> for DoubleQuery<'_> {
    fn visit(&mut self, _: S, leaf: u32, _: &mut Vec<u32>) {
        let block = &self.blocks[leaf as usize];
        for lane in block.lanes() {
            let vertices = block.corners(lane);
            let corners = |functional: &Functional| vertices.map(|vertex: DVec3| functional.at(vertex));
            let crossing = Crossing::new(0.0, corners(&self.region.out_of_plane));
            if crossing.exists {
                let reach = crossing.at_ends(corners(&self.region.reach));
                let height = crossing.at_ends(corners(&self.region.height));
                let ends = [0, 1].map(|end| DVec2::new(reach[end], height[end]));
                let primitive = PrimitiveId { instance: self.instance, triangle: block.triangles[lane] };
                self.cuts.push(Cut { primitive, ends, rounding: Cut::DOUBLE });
            }
        }
    }
}
