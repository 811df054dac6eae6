//! Parts of a ray in the shadow of a light. In goes a [`LightPlane`], out come intervals. Invariant: the
//! intervals include every part of the range that a triangle shadows.

use super::{
    block::Block,
    box_region::{BoxLimit, BoxRegion, LaneFunctional, may_vanish},
    instance::{Instance, Instances},
    light_plane::{Functional, LightPlane, PlaneFunctions},
    simd::{Kernel, Lanes, Mask, Simd, each_lane},
    triangle_cut::{Crossing, Shadow},
    wide_tree::Stack,
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
        let stack = &mut Stack::new();
        box_region.visit_leaves(
            simd,
            tree,
            stack,
            #[inline(always)]
            |leaf, stack| add_of_instance(simd, &instances[leaf as usize], plane, stack, shadows),
        );
    }
}

#[inline(always)]
fn add_of_instance<S: Simd>(
    simd: S,
    instance: &Instance,
    plane: &LightPlane,
    stack: &mut Stack<u32>,
    shadows: &mut IntervalSet,
) {
    let mesh = &*instance.mesh;
    // As for slices: the plane misses many meshes whose boxes it crosses.
    let out_of_plane = plane.functions.out_of_plane.pulled_back(&instance.relative_from_mesh);
    if !may_vanish(&out_of_plane, mesh.tree.bounds) {
        return;
    }
    let here = plane.functions.pulled_back_with(out_of_plane, &instance.relative_from_mesh);
    let box_region = shadowing(simd, &here, plane.t_range);
    // Distances are relative to that of the mesh's centre, so the remainder has the mesh's magnitude.
    let (t0, t1) = plane.t_range;
    let at_centre = here.along.at(mesh.centre) / here.depth.at(mesh.centre);
    let t_centre = if at_centre > t0 && at_centre < t1 { at_centre } else { (t0 + t1) / 2.0 };
    let cut = PlaneFunctions { along: here.at_or_after(t_centre), ..here };
    let needs_doubles = plane.needs_doubles || instance.needs_doubles;
    let from_centre = |t: f64| if needs_doubles { t - t_centre } else { f64::from((t - t_centre) as f32) };
    let limits = (from_centre(t0), from_centre(t1));
    let mut sink = ShadowSink { t_range: (t0, t1), t_centre, limits, pending: NOTHING, shadows };
    if needs_doubles {
        box_region.visit_leaves(simd, &mesh.tree, stack, |leaf, _| {
            add_in_doubles(&mesh.blocks[leaf as usize], &cut, plane.is_fan, &mut sink);
        });
        sink.flush();
        return;
    }
    let functions = LanePlane::new(simd, &cut, plane.is_fan);
    box_region.visit_leaves(
        simd,
        &mesh.tree,
        stack,
        #[inline(always)]
        |leaf, _| {
            let block = &mesh.blocks[leaf as usize];
            let limits = (limits.0 as f32, limits.1 as f32);
            let Some(shadow) = functions.shadow(simd, block, limits) else { return };
            let lanes = shadow.bits();
            if lanes == 0 {
                return;
            }
            let (starts, ends) = (simd.store(shadow.start), simd.store(shadow.end));
            each_lane(lanes, |lane| sink.add(f64::from(starts[lane]), f64::from(ends[lane])));
        },
    );
    sink.flush();
}

/// [`PlaneFunctions`] in lanes.
struct LanePlane<L> {
    out_of_plane: LaneFunctional<L>,
    along: LaneFunctional<L>,
    /// Denominator; `None` where it is 1 everywhere.
    depth: Option<LaneFunctional<L>>,
    towards_light: LaneFunctional<L>,
}

impl<L: Lanes> LanePlane<L> {
    #[inline(always)]
    fn new<S: Simd<Lanes = L>>(simd: S, functions: &PlaneFunctions, is_fan: bool) -> Self {
        Self {
            out_of_plane: LaneFunctional::new(simd, &functions.out_of_plane),
            along: LaneFunctional::new(simd, &functions.along),
            depth: if is_fan { Some(LaneFunctional::new(simd, &functions.depth)) } else { None },
            towards_light: LaneFunctional::new(simd, &functions.towards_light),
        }
    }

    /// Shadows of a block's triangles; `None` if the plane misses all.
    #[inline(always)]
    fn shadow<S: Simd<Lanes = L>>(&self, simd: S, block: &Block, (t0, t1): (f32, f32)) -> Option<Shadow<L>> {
        let zero = simd.splat(0.0);
        let crossing = Crossing::new(zero, self.out_of_plane.at_corners(simd, block));
        if crossing.exists.bits() == 0 {
            return None;
        }
        let limits = (simd.splat(t0), simd.splat(t1));
        let along = self.along.at_corners(simd, block);
        let towards_light = self.towards_light.at_corners(simd, block);
        Some(match &self.depth {
            None => crossing.strip_shadow(zero, limits, along, towards_light),
            Some(depth) => {
                let ends = crossing.fan_ends(along, depth.at_corners(simd, block), towards_light);
                crossing.fan_shadow((zero, simd.splat(1.0)), limits, ends)
            }
        })
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

/// Adds the shadows of a block in double precision, one triangle at a time.
fn add_in_doubles(block: &Block, cut: &PlaneFunctions, is_fan: bool, sink: &mut ShadowSink) {
    for lane in block.lanes() {
        let vertices = block.corners(lane);
        let corners = |functional: &Functional| vertices.map(|vertex: DVec3| functional.at(vertex));
        let crossing = Crossing::new(0.0, corners(&cut.out_of_plane));
        if !crossing.exists {
            continue;
        }
        let (along, towards_light) = (corners(&cut.along), corners(&cut.towards_light));
        let Shadow { exists, start, end } = if is_fan {
            let ends = crossing.fan_ends(along, corners(&cut.depth), towards_light);
            let Some(ends) = ends.before_light() else { continue };
            crossing.fan_shadow((0.0, 1.0), sink.limits, ends)
        } else {
            crossing.strip_shadow(0.0, sink.limits, along, towards_light)
        };
        if exists {
            sink.add(start, end);
        }
    }
}
