//! Which parts of a ray lie in the shadow of a light. In: a [`LightPlane`]; out: intervals. Invariant: a
//! box is passed over only if no triangle in it can, even after rounding, shadow the asked part.

use super::{
    block::Block,
    instance::{Instance, Instances},
    light_plane::{Functional, LightPlane, PlaneFunctions},
    rounding::UNIT_ROUNDOFF,
    simd::{Kernel, Lanes, Mask, Simd, WIDTH, three},
    stack::{Entry, Stack},
    triangle_cut::{Corners, Crossing, Shadow},
    wide_tree::{Bounds, LEAF, Node, WideTree, plane},
};
use crate::math::IntervalSet;
use glam::DVec3;

/// How far, in roundings of the sum of its terms' magnitudes, a function of position is padded for
/// boxes. Evaluating one rounds gradient, product and three sums, at the box and again at a vertex,
/// and a cut adds 4 more: 2 * 5 + 4 < 16.
const PADDING_ROUNDOFFS: f64 = 16.0;

/// An affine function in single precision.
#[derive(Clone, Copy)]
pub(super) struct LaneFunctional<L> {
    gradient: [L; 3],
    offset: L,
}

impl<L: Lanes> LaneFunctional<L> {
    #[inline(always)]
    pub(super) fn new<S: Simd<Lanes = L>>(simd: S, functional: &Functional) -> Self {
        Self {
            gradient: three(
                #[inline(always)]
                |axis| simd.splat(functional.gradient[axis] as f32),
            ),
            offset: simd.splat(functional.offset as f32),
        }
    }

    #[inline(always)]
    pub(super) fn at(&self, [x, y, z]: [L; 3]) -> L {
        self.gradient[0] * x + self.gradient[1] * y + self.gradient[2] * z + self.offset
    }

    /// At the vertices of each triangle.
    #[inline(always)]
    pub(super) fn at_corners<S: Simd<Lanes = L>>(&self, simd: S, block: &Block) -> Corners<L> {
        three(
            #[inline(always)]
            |vertex| {
                let [x, y, z] = &block.vertices[vertex];
                self.at([simd.load(x), simd.load(y), simd.load(z)])
            },
        )
    }
}

/// How far an affine function may be off where it is evaluated in a box in single precision.
#[inline(always)]
fn padding(functional: &Functional, bounds: Bounds) -> f64 {
    let terms = functional.gradient.abs().dot(bounds.magnitude().as_dvec3()) + functional.offset.abs();
    PADDING_ROUNDOFFS * UNIT_ROUNDOFF * terms
}

/// Whether an affine function may be 0 in a box.
#[inline(always)]
pub(super) fn may_vanish(functional: &Functional, bounds: Bounds) -> bool {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let spread = functional.gradient.abs().dot(0.5 * (max - min));
    functional.at(0.5 * (min + max)).abs() <= spread + padding(functional, bounds)
}

/// The upper limit of an affine function over a box.
pub(super) struct BoxLimit<L> {
    functional: LaneFunctional<L>,
    corner: [usize; 3],
}

impl<L: Lanes> BoxLimit<L> {
    #[inline(always)]
    pub(super) fn new<S: Simd<Lanes = L>>(simd: S, functional: &Functional, bounds: Bounds) -> Self {
        let padded = Functional { offset: functional.offset + padding(functional, bounds), ..*functional };
        let corner = three(|axis| plane(axis, functional.gradient[axis] >= 0.0));
        Self { functional: LaneFunctional::new(simd, &padded), corner }
    }

    #[inline(always)]
    fn at<S: Simd<Lanes = L>>(&self, simd: S, node: &Node) -> L {
        self.functional.at(three(
            #[inline(always)]
            |axis| simd.load(&node.planes[self.corner[axis]]),
        ))
    }
}

/// Whether boxes may hold something of a region: where the first two limits, a plane from both its
/// sides, and all the others are not negative.
pub(super) struct BoxRegion<L, const N: usize>(pub(super) [BoxLimit<L>; N]);

impl<L: Lanes, const N: usize> BoxRegion<L, N> {
    /// The children that may hold something of the region, as bits.
    #[inline(always)]
    fn meets<S: Simd<Lanes = L>>(&self, simd: S, node: &Node) -> u32 {
        let zero = simd.splat(0.0);
        let mut met = zero.le(self.0[0].at(simd, node)) & zero.le(self.0[1].at(simd, node));
        if met.bits() == 0 {
            return 0;
        }
        for limit in &self.0[2..] {
            met = met & zero.le(limit.at(simd, node));
        }
        met.bits()
    }
}

/// What shadows the asked part of a ray lies in the plane, between the light's rays to the part's
/// ends and on the light's side.
#[inline(always)]
pub(super) fn shadowing<S: Simd>(
    simd: S,
    functions: &PlaneFunctions,
    (t0, t1): (f64, f64),
    bounds: Bounds,
) -> BoxRegion<S::Lanes, 5> {
    BoxRegion([
        BoxLimit::new(simd, &functions.out_of_plane, bounds),
        BoxLimit::new(simd, &functions.out_of_plane.negated(), bounds),
        BoxLimit::new(simd, &functions.at_or_after(t0), bounds),
        BoxLimit::new(simd, &functions.at_or_after(t1).negated(), bounds),
        BoxLimit::new(simd, &functions.towards_light, bounds),
    ])
}

/// What happens at the leaves of a tree.
pub(super) trait LeafVisitor<S: Simd> {
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Stack);

    /// Hears of a leaf that is visited after some others.
    #[inline(always)]
    fn expect(&self, _simd: S, _leaf: u32) {}
}

/// Visits the leaves whose boxes may hold something of the region.
#[inline(always)]
pub(super) fn visit_leaves<S: Simd, const N: usize>(
    simd: S,
    tree: &WideTree,
    region: &BoxRegion<S::Lanes, N>,
    stack: &mut Stack,
    visitor: &mut impl LeafVisitor<S>,
) {
    let Some(root) = tree.root else { return };
    let base = stack.len();
    stack.push(Entry { child: root, t_near: 0.0 });
    while let Some(Entry { child, .. }) = stack.pop(base) {
        if child & LEAF != 0 {
            visitor.visit(simd, child & !LEAF, stack);
            continue;
        }
        let node = &tree.nodes[child as usize];
        let mut met = region.meets(simd, node);
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let child = node.children[lane];
            // In large scenes gathering waited for these two fifths of its time.
            if child & LEAF != 0 {
                visitor.expect(simd, child & !LEAF);
            } else if let Some(node) = tree.nodes.get(child as usize) {
                simd.prefetch(node);
            }
            stack.push(Entry { child, t_near: 0.0 });
        }
    }
}

/// Adds the shadows of all instances.
pub(super) struct AddShadows<'a> {
    pub(super) instances: Instances<'a>,
    pub(super) plane: &'a LightPlane,
    pub(super) shadows: &'a mut IntervalSet,
}

impl Kernel for AddShadows<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { instances: Instances { tree, list: instances }, plane, shadows } = self;
        if plane.t_range.0 >= plane.t_range.1 {
            return;
        }
        let box_region = shadowing(simd, &plane.functions, plane.t_range, tree.bounds);
        let mut query = ShadowQuery { plane, instances, shadows };
        visit_leaves(simd, tree, &box_region, &mut Stack::new(), &mut query);
    }
}

/// A query that goes through the instances.
struct ShadowQuery<'a> {
    plane: &'a LightPlane,
    instances: &'a [Instance],
    shadows: &'a mut IntervalSet,
}

impl<S: Simd> LeafVisitor<S> for ShadowQuery<'_> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Stack) {
        let instance = &self.instances[leaf as usize];
        let mesh = &*instance.mesh;
        // As in slices: the plane passes many by whose boxes it crosses.
        let out_of_plane = self.plane.functions.out_of_plane.pulled_back(&instance.relative_from_mesh);
        if !may_vanish(&out_of_plane, mesh.tree.bounds) {
            return;
        }
        let here = self.plane.functions.pulled_back_with(out_of_plane, &instance.relative_from_mesh);
        let box_region = shadowing(simd, &here, self.plane.t_range, mesh.tree.bounds);
        // Distances are counted from where the middle of the mesh throws its shadow: what is left has
        // the mesh's magnitude.
        let (t0, t1) = self.plane.t_range;
        let at_centre = here.along.at(instance.mesh_centre) / here.depth.at(instance.mesh_centre);
        let t_centre = if at_centre > t0 && at_centre < t1 { at_centre } else { (t0 + t1) / 2.0 };
        let cut = PlaneFunctions { along: here.at_or_after(t_centre), ..here };
        let limits = (t0 - t_centre, t1 - t_centre);
        let single_limits = (limits.0 as f32, limits.1 as f32);
        let sink =
            ShadowSink { t_range: (t0, t1), t_centre, limits, pending: NOTHING, shadows: self.shadows };
        if self.plane.needs_doubles || instance.needs_doubles {
            let is_fan = self.plane.is_fan;
            let mut query = DoubleQuery { blocks: &mesh.blocks, cut, is_fan, sink };
            visit_leaves(simd, &mesh.tree, &box_region, stack, &mut query);
            query.sink.flush();
        } else {
            let zero = simd.splat(0.0);
            let mut query = LaneQuery {
                blocks: &mesh.blocks,
                zero,
                one: simd.splat(1.0),
                out_of_plane: LaneFunctional::new(simd, &cut.out_of_plane),
                along: LaneFunctional::new(simd, &cut.along),
                depth: if self.plane.is_fan { Some(LaneFunctional::new(simd, &cut.depth)) } else { None },
                towards_light: LaneFunctional::new(simd, &cut.towards_light),
                limits: single_limits,
                sink: ShadowSink { limits: (f64::from(single_limits.0), f64::from(single_limits.1)), ..sink },
            };
            visit_leaves(simd, &mesh.tree, &box_region, stack, &mut query);
            query.sink.flush();
        }
    }
}

/// Turns distances from an instance's middle into distances along the ray.
struct ShadowSink<'a> {
    t_range: (f64, f64),
    t_centre: f64,
    /// Ends of the asked range as the cut knows them.
    limits: (f64, f64),
    /// Shadows seen so far that touch one another: neighbouring triangles mostly do.
    pending: (f64, f64),
    shadows: &'a mut IntervalSet,
}

impl ShadowSink<'_> {
    #[inline(always)]
    fn add(&mut self, start: f64, end: f64) {
        if start <= self.pending.1 && end >= self.pending.0 {
            self.pending = (self.pending.0.min(start), self.pending.1.max(end));
        } else {
            self.flush();
            self.pending = (start, end);
        }
    }

    /// Hands on what is pending. Ends that were clipped become the ends of the asked range, exactly.
    fn flush(&mut self) {
        let (start, end) = self.pending;
        let (t0, t1) = self.t_range;
        let start = if start <= self.limits.0 { t0 } else { (self.t_centre + start).max(t0) };
        let end = if end >= self.limits.1 { t1 } else { (self.t_centre + end).min(t1) };
        self.shadows.insert(start, end);
        self.pending = NOTHING;
    }
}

/// An interval that touches no other.
const NOTHING: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// A query that goes through one instance's mesh in single precision.
struct LaneQuery<'a, L> {
    blocks: &'a [Block],
    zero: L,
    one: L,
    out_of_plane: LaneFunctional<L>,
    along: LaneFunctional<L>,
    /// None where it is 1 everywhere.
    depth: Option<LaneFunctional<L>>,
    towards_light: LaneFunctional<L>,
    limits: (f32, f32),
    sink: ShadowSink<'a>,
}

impl<S: Simd> LeafVisitor<S> for LaneQuery<'_, S::Lanes> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, _: &mut Stack) {
        let block = &self.blocks[leaf as usize];
        let crossing = Crossing::new(self.zero, self.out_of_plane.at_corners(simd, block));
        if crossing.exists.bits() == 0 {
            return;
        }
        let limits = (simd.splat(self.limits.0), simd.splat(self.limits.1));
        let along = self.along.at_corners(simd, block);
        let towards_light = self.towards_light.at_corners(simd, block);
        let shadow = match &self.depth {
            None => crossing.strip_shadow(self.zero, limits, along, towards_light),
            Some(depth) => {
                let ones = (self.zero, self.one);
                crossing.fan_shadow(ones, limits, along, depth.at_corners(simd, block), towards_light)
            }
        };
        let mut lanes = shadow.bits();
        if lanes == 0 {
            return;
        }
        let (starts, ends) = (simd.store(shadow.start), simd.store(shadow.end));
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize % WIDTH;
            lanes &= lanes - 1;
            self.sink.add(f64::from(starts[lane]), f64::from(ends[lane]));
        }
    }
}

/// The same in double precision, a triangle at a time.
struct DoubleQuery<'a> {
    blocks: &'a [Block],
    cut: PlaneFunctions,
    is_fan: bool,
    sink: ShadowSink<'a>,
}

impl<S: Simd> LeafVisitor<S> for DoubleQuery<'_> {
    fn visit(&mut self, _: S, leaf: u32, _: &mut Stack) {
        let block = &self.blocks[leaf as usize];
        for lane in block.lanes() {
            let vertices = block.corners(lane);
            let corners = |functional: &Functional| vertices.map(|vertex: DVec3| functional.at(vertex));
            let crossing = Crossing::new(0.0, corners(&self.cut.out_of_plane));
            if !crossing.exists {
                continue;
            }
            let (along, towards_light) = (corners(&self.cut.along), corners(&self.cut.towards_light));
            let limits = self.sink.limits;
            let Shadow { exists, start, end } = if self.is_fan {
                crossing.fan_shadow((0.0, 1.0), limits, along, corners(&self.cut.depth), towards_light)
            } else {
                crossing.strip_shadow(0.0, limits, along, towards_light)
            };
            if exists {
                self.sink.add(start, end);
            }
        }
    }
}
