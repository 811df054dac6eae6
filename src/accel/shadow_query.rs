//! Parts of a ray in the shadow of a light. In goes a [`LightPlane`], out come intervals. Invariant: the
//! intervals include every part of the range that a triangle shadows.

use super::{
    block::Block,
    box_region::{BoxLimit, BoxRegion, LaneFunctional, LeafVisitor, may_vanish, visit_leaves},
    instance::{Instance, Instances},
    light_plane::{Functional, LightPlane, PlaneFunctions},
    simd::{Kernel, Mask, Simd, WIDTH},
    triangle_cut::{Crossing, Shadow},
    wide_tree::STACK,
};
use crate::math::IntervalSet;
use glam::DVec3;

/// Region of points that shadow a range of a ray: in the plane, between the light's rays to the range's ends,
/// and on the light's side.
#[inline(always)]
pub(super) fn shadowing<S: Simd>(
    simd: S,
    functions: &PlaneFunctions,
    (t0, t1): (f64, f64),
) -> BoxRegion<S::Lanes, 5> {
    BoxRegion([
        BoxLimit::new(simd, &functions.out_of_plane),
        BoxLimit::new(simd, &functions.out_of_plane.negated()),
        BoxLimit::new(simd, &functions.at_or_after(t0)),
        BoxLimit::new(simd, &functions.at_or_after(t1).negated()),
        BoxLimit::new(simd, &functions.towards_light),
    ])
}

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
        let box_region = shadowing(simd, &plane.functions, plane.t_range);
        let mut query = ShadowQuery { plane, instances, shadows };
        visit_leaves(simd, tree, &box_region, &mut Vec::with_capacity(STACK), &mut query);
    }
}

/// Query over the instances.
struct ShadowQuery<'a> {
    plane: &'a LightPlane,
    instances: &'a [Instance],
    shadows: &'a mut IntervalSet,
}

impl<S: Simd> LeafVisitor<S> for ShadowQuery<'_> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Vec<u32>) {
        let instance = &self.instances[leaf as usize];
        let mesh = &*instance.mesh;
        // As for slices: the plane misses many meshes whose boxes it crosses.
        let out_of_plane = self.plane.functions.out_of_plane.pulled_back(&instance.relative_from_mesh);
        if !may_vanish(&out_of_plane, mesh.tree.bounds) {
            return;
        }
        let here = self.plane.functions.pulled_back_with(out_of_plane, &instance.relative_from_mesh);
        let box_region = shadowing(simd, &here, self.plane.t_range);
        // Distances are relative to that of the mesh's centre, so the remainder has the mesh's magnitude.
        let (t0, t1) = self.plane.t_range;
        let at_centre = here.along.at(mesh.centre) / here.depth.at(mesh.centre);
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

/// Converts distances relative to that of an instance's centre into distances along the ray.
struct ShadowSink<'a> {
    t_range: (f64, f64),
    t_centre: f64,
    /// Ends of the range, relative to the same.
    limits: (f64, f64),
    /// Union of the last shadows, which touch each other, as those of neighbouring triangles mostly do.
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

    /// Adds the pending shadow. Clipped ends become the exact ends of the range.
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

/// Query over one instance's mesh in single precision.
struct LaneQuery<'a, L> {
    blocks: &'a [Block],
    zero: L,
    one: L,
    out_of_plane: LaneFunctional<L>,
    along: LaneFunctional<L>,
    /// Denominator; `None` where it is 1 everywhere.
    depth: Option<LaneFunctional<L>>,
    towards_light: LaneFunctional<L>,
    limits: (f32, f32),
    sink: ShadowSink<'a>,
}

impl<S: Simd> LeafVisitor<S> for LaneQuery<'_, S::Lanes> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, _: &mut Vec<u32>) {
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
                let ends = crossing.fan_ends(along, depth.at_corners(simd, block), towards_light);
                crossing.fan_shadow((self.zero, self.one), limits, ends)
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

/// Query in double precision, one triangle at a time.
struct DoubleQuery<'a> {
    blocks: &'a [Block],
    cut: PlaneFunctions,
    is_fan: bool,
    sink: ShadowSink<'a>,
}

impl<S: Simd> LeafVisitor<S> for DoubleQuery<'_> {
    fn visit(&mut self, _: S, leaf: u32, _: &mut Vec<u32>) {
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
                let ends = crossing.fan_ends(along, corners(&self.cut.depth), towards_light);
                let Some(ends) = ends.before_light() else { continue };
                crossing.fan_shadow((0.0, 1.0), limits, ends)
            } else {
                crossing.strip_shadow(0.0, limits, along, towards_light)
            };
            if exists {
                self.sink.add(start, end);
            }
        }
    }
}
