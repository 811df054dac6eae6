//! Cuts of triangles by a half plane. In goes a [`HalfPlane`], out comes a segment for each triangle that
//! crosses it. Invariant: triangles that share an edge have the same end there, to the last bit, so a closed
//! mesh has a closed outline.

use super::{
    block::Block,
    box_region::{BoxLimit, BoxRegion, LaneFunctional, may_vanish},
    hit::PrimitiveId,
    instance::{Instance, Instances},
    light_plane::Functional,
    simd::{Kernel, Mask, Simd, each_lane},
    triangle_cut::Crossing,
    wide_tree::Stack,
};
use glam::{DAffine3, DVec2, DVec3};

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
        let stack = &mut Stack::new();
        limits.visit_expected_leaves(
            simd,
            tree,
            stack,
            #[inline(always)]
            |leaf| simd.prefetch(&instances[leaf as usize]),
            #[inline(always)]
            |leaf, stack| add_of_instance(simd, &instances[leaf as usize], &region, stack, cuts),
        );
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

    /// Functions for positions in the space that `to_here` maps from, of which one is known.
    #[inline(always)]
    fn pulled_back_with(&self, out_of_plane: Functional, to_here: &DAffine3) -> Self {
        let [reach, height, above] =
            [&self.reach, &self.height, &self.above].map(|functional| functional.pulled_back(to_here));
        Self { out_of_plane, reach, height, above }
    }

    /// Ends of a triangle's cut with the plane.
    fn cut(&self, vertices: [DVec3; 3]) -> Option<[DVec2; 2]> {
        let corners = |functional: &Functional| vertices.map(|vertex| functional.at(vertex));
        let crossing = Crossing::new(0.0, corners(&self.out_of_plane));
        crossing.exists.then(|| {
            let reach = crossing.at_ends(corners(&self.reach));
            let height = crossing.at_ends(corners(&self.height));
            [0, 1].map(|end| DVec2::new(reach[end], height[end]))
        })
    }
}

#[inline(always)]
fn add_of_instance<S: Simd>(
    simd: S,
    instance: &Instance,
    region: &Region,
    stack: &mut Stack<u32>,
    cuts: &mut Vec<Cut>,
) {
    let mesh = &*instance.mesh;
    // The plane misses a third of them: a leaf is flat, and the box of a rotated flat mesh is not.
    let out_of_plane = region.out_of_plane.pulled_back(&instance.relative_from_mesh);
    if !may_vanish(&out_of_plane, mesh.tree.bounds) {
        return;
    }
    let region = region.pulled_back_with(out_of_plane, &instance.relative_from_mesh);
    let limits = region.limits(simd);
    let mut add = |block: &Block, lane: usize, ends: [DVec2; 2], rounding: f64| {
        let primitive = PrimitiveId { instance: instance.index, triangle: block.triangles[lane] };
        cuts.push(Cut { primitive, ends, rounding });
    };
    if instance.needs_doubles {
        limits.visit_leaves(simd, &mesh.tree, stack, |leaf, _| {
            let block = &mesh.blocks[leaf as usize];
            for lane in block.lanes() {
                if let Some(ends) = region.cut(block.corners(lane)) {
                    add(block, lane, ends, Cut::DOUBLE);
                }
            }
        });
        return;
    }
    // Coordinates are relative to the mesh's centre: single precision has to resolve a leaf.
    let centre = DVec2::new(region.reach.at(mesh.centre), region.height.at(mesh.centre));
    let from_centre = |functional: &Functional, at_centre: f64| {
        LaneFunctional::new(simd, &Functional { offset: functional.offset - at_centre, ..*functional })
    };
    let zero = simd.splat(0.0);
    let out_of_plane = LaneFunctional::new(simd, &region.out_of_plane);
    let reach = from_centre(&region.reach, centre.x);
    let height = from_centre(&region.height, centre.y);
    limits.visit_leaves(
        simd,
        &mesh.tree,
        stack,
        #[inline(always)]
        |leaf, _| {
            let block = &mesh.blocks[leaf as usize];
            let crossing = Crossing::new(zero, out_of_plane.at_corners(simd, block));
            let lanes = crossing.exists.bits();
            if lanes == 0 {
                return;
            }
            let [reach_a, reach_b] = crossing.at_ends(reach.at_corners(simd, block));
            let [height_a, height_b] = crossing.at_ends(height.at_corners(simd, block));
            let reach = [simd.store(reach_a), simd.store(reach_b)];
            let height = [simd.store(height_a), simd.store(height_b)];
            each_lane(lanes, |lane| {
                let end = |end: usize| centre + DVec2::new(reach[end][lane].into(), height[end][lane].into());
                add(block, lane, [end(0), end(1)], Cut::SINGLE);
            });
        },
    );
}
