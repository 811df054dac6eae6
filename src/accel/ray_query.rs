//! Rays against trees and triangles. In: a ray in double precision; out: the nearest hit, or whether
//! there is one. Invariant: no ray slips between triangles that share an edge or a vertex.
//!
//! Candidates are found in single precision and settled in double precision, so a hit's distance is
//! good to a few units in 1e16 and a ray that starts on a surface needs no offset.

use super::{
    block::Block,
    hit::{Hit, PrimitiveId},
    instance::{Instance, Instances},
    mesh_tree::MeshTree,
    rounding::{UNIT_ROUNDOFF, round_down, round_up},
    simd::{Eight, Kernel, Lanes, Mask, Simd, WIDTH, three},
    stack::{Entry, Stack},
    wide_tree::{Bounds, LEAF, WideTree, plane},
};
use crate::math::Ray;
use glam::DVec3;

/// How far, in roundings of the largest coordinate, boxes are padded against rays. Shearing a vertex
/// moves it by at most 6 (two differences, a product, a quotient), the slab test a plane by at most 4;
/// 16 covers both.
const BOX_PADDING_ROUNDOFFS: f64 = 16.0;

/// How far, in roundings of double precision, the ends of a ray may lie off a triangle's plane and still
/// count as lying in it: placing an end takes a dozen operations, measuring its height as many.
const PLANE_ROUNDOFFS: f64 = 32.0;

/// A ray in single precision, prepared for boxes that are padded by what single precision may lose: the
/// origin is moved against the planes the ray enters by and along with those it leaves by (Woop, Benthin
/// and Wald 2013, section 5, with one padding for a whole tree).
struct BoxRay<L> {
    origin_entering: [L; 3],
    origin_leaving: [L; 3],
    inverse_direction: [L; 3],
    entering: [usize; 3],
    t_min: L,
}

impl<L: Lanes> BoxRay<L> {
    #[inline(always)]
    fn new<S: Simd<Lanes = L>>(
        simd: S,
        origin: [f32; 3],
        direction: [f32; 3],
        padding: f32,
        t_min: f32,
    ) -> Self {
        let shift = direction.map(|d| if d < 0.0 { -padding } else { padding });
        Self {
            origin_entering: three(
                #[inline(always)]
                |axis| simd.splat(origin[axis] + shift[axis]),
            ),
            origin_leaving: three(
                #[inline(always)]
                |axis| simd.splat(origin[axis] - shift[axis]),
            ),
            // Adding 0 turns -0 into 0, whose inverse then has the sign that `entering` assumes.
            inverse_direction: three(
                #[inline(always)]
                |axis| simd.splat(1.0 / (direction[axis] + 0.0)),
            ),
            entering: three(|axis| plane(axis, direction[axis] < 0.0)),
            t_min: simd.splat(t_min),
        }
    }
}

/// What happens at the leaves of a tree.
trait LeafVisitor<S: Simd> {
    /// Visits a leaf, may shorten `t_far`, and says whether the query is over.
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Stack, t_far: &mut f32) -> bool;
}

/// Visits the leaves whose boxes the ray meets before `t_far`, near ones first.
#[inline(always)]
fn visit_leaves<S: Simd>(
    simd: S,
    tree: &WideTree,
    ray: &BoxRay<S::Lanes>,
    mut t_far: f32,
    stack: &mut Stack,
    visitor: &mut impl LeafVisitor<S>,
) -> bool {
    let Some(root) = tree.root else { return false };
    let base = stack.len();
    let mut child = root;
    loop {
        if child & LEAF != 0 {
            if visitor.visit(simd, child & !LEAF, stack, &mut t_far) {
                stack.truncate(base);
                return true;
            }
        } else {
            let node = &tree.nodes[child as usize];
            let mut near = ray.t_min;
            let mut far = simd.splat(t_far);
            for axis in 0..3 {
                let entering = ray.entering[axis];
                let enter = (simd.load(&node.planes[entering]) - ray.origin_entering[axis])
                    * ray.inverse_direction[axis];
                let leave = (simd.load(&node.planes[entering ^ 1]) - ray.origin_leaving[axis])
                    * ray.inverse_direction[axis];
                // A NaN, from a ray that runs within a plane, must not cull: so it comes first.
                near = enter.max(near);
                far = leave.min(far);
            }
            let mut hits = near.le(far).bits();
            if hits != 0 {
                let first = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                if hits == 0 {
                    child = node.children[first];
                    continue;
                }
                let near = simd.store(near);
                let mut sorted = [Entry::default(); WIDTH];
                sorted[0] = Entry { child: node.children[first], t_near: near[first] };
                let mut count = 1;
                while hits != 0 {
                    let lane = hits.trailing_zeros() as usize;
                    hits &= hits - 1;
                    let entry = Entry { child: node.children[lane], t_near: near[lane] };
                    let mut slot = count;
                    while slot > 0 && sorted[slot - 1].t_near < entry.t_near {
                        sorted[slot] = sorted[slot - 1];
                        slot -= 1;
                    }
                    sorted[slot] = entry;
                    count += 1;
                }
                for entry in &sorted[..count - 1] {
                    stack.push(*entry);
                }
                child = sorted[count - 1].child;
                continue;
            }
        }
        loop {
            match stack.pop(base) {
                None => return false,
                Some(entry) if entry.t_near <= t_far => {
                    child = entry.child;
                    break;
                }
                Some(_) => {}
            }
        }
    }
}

fn padding(origin: DVec3, bounds: Bounds) -> f64 {
    let magnitude = bounds.magnitude().as_dvec3() + origin.abs();
    BOX_PADDING_ROUNDOFFS * UNIT_ROUNDOFF * magnitude.max_element()
}

/// A query that goes through the instances.
pub(super) struct RayQuery<'a> {
    ray: &'a Ray,
    instances: &'a [Instance],
    skip: Option<PrimitiveId>,
    any: bool,
    t_max: f64,
    nearest: Option<Hit>,
}

/// The nearest hit with `0 < t < t_max`; if `any`, the first that is found.
pub(super) struct Trace<'a> {
    pub(super) instances: Instances<'a>,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
    pub(super) skip: Option<PrimitiveId>,
    pub(super) any: bool,
}

impl Kernel for Trace<'_> {
    type Output = Option<Hit>;
    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<Hit> {
        let Self { instances: Instances { tree, list: instances }, ray, t_max, skip, any } = self;
        let mut stack = Stack::new();
        let padding = padding(ray.origin, tree.bounds) as f32;
        let (origin, direction) = (ray.origin.as_vec3().to_array(), ray.direction.as_vec3().to_array());
        let box_ray = BoxRay::new(simd, origin, direction, padding, 0.0);
        let mut query = RayQuery { ray, instances, skip, any, t_max, nearest: None };
        visit_leaves(simd, tree, &box_ray, round_up(t_max), &mut stack, &mut query);
        query.nearest
    }
}

impl<S: Simd> LeafVisitor<S> for RayQuery<'_> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Stack, t_far: &mut f32) -> bool {
        let instance = &self.instances[leaf as usize];
        let mesh = &*instance.mesh;
        let origin = instance.mesh_from_relative.transform_point3(self.ray.origin);
        let direction = instance.mesh_from_relative.transform_vector3(self.ray.direction);
        // Re-centre on the point next to the mesh's middle: what is left has the mesh's magnitude.
        let to_centre = instance.mesh_centre - origin;
        let t_centre = to_centre.dot(direction) / direction.length_squared();
        let centred = origin + t_centre * direction;
        let padding = padding(centred, mesh.tree.bounds);
        let box_ray = BoxRay::new(
            simd,
            centred.as_vec3().to_array(),
            direction.as_vec3().to_array(),
            padding as f32,
            round_down(-t_centre),
        );
        let slack = padding / direction.abs().max_element();
        let mesh_from_relative = &instance.mesh_from_relative;
        let t_end = if self.any { self.t_max } else { f64::INFINITY };
        let length = self.ray.origin.abs().max_element() + if t_end.is_finite() { t_end } else { 0.0 };
        let magnitude =
            mesh_from_relative.translation.abs().max_element() + length * direction.abs().max_element();
        let mut query = MeshQuery {
            mesh,
            instance,
            origin,
            direction,
            magnitude,
            t_end,
            t_centre,
            shear: Shear::new(simd, centred, direction),
            t_min: simd.splat(round_down(-t_centre - slack)),
            slack,
            skip: self.skip.filter(|skip| skip.instance == instance.index).map_or(u32::MAX, |s| s.triangle),
            query: self,
        };
        let local_t_far = round_up(query.query.t_max - t_centre);
        let over = visit_leaves(simd, &mesh.tree, &box_ray, local_t_far, stack, &mut query);
        *t_far = round_up(self.t_max);
        over
    }
}

/// A query that goes through one instance's mesh.
struct MeshQuery<'a, 'b, L> {
    mesh: &'a MeshTree,
    instance: &'a Instance,
    /// The ray in the mesh's space; its direction is not normalised, so that `t` stays comparable.
    origin: DVec3,
    direction: DVec3,
    /// What the ray's ends are computed from, in the mesh's space: their rounding is a fraction of it.
    magnitude: f64,
    /// Where the ray ends, if at a certain place.
    t_end: f64,
    t_centre: f64,
    shear: Shear<L>,
    t_min: L,
    /// What single precision may get wrong about a distance.
    slack: f64,
    skip: u32,
    query: &'b mut RayQuery<'a>,
}

impl<S: Simd> LeafVisitor<S> for MeshQuery<'_, '_, S::Lanes> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, _: &mut Stack, t_far: &mut f32) -> bool {
        let block = &self.mesh.blocks[leaf as usize];
        let t_limit = simd.splat(*t_far + self.slack as f32);
        let mut hits = self.shear.candidates(simd, block, self.t_min, t_limit);
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            let triangle = block.triangles[lane];
            if triangle == self.skip {
                continue;
            }
            let (t, barycentrics) = self.settle(block, lane);
            if t > 0.0 && t < self.query.t_max {
                let primitive = PrimitiveId { instance: self.instance.index, triangle };
                self.query.nearest = Some(Hit { t, primitive, barycentrics });
                if self.query.any {
                    return true;
                }
                self.query.t_max = t;
                *t_far = round_up(t - self.t_centre);
            }
        }
        false
    }
}

impl<L: Lanes> MeshQuery<'_, '_, L> {
    /// Distance and barycentrics in double precision of a hit that single precision has found
    /// (Moller and Trumbore 1997).
    #[inline(always)]
    fn settle(&self, block: &Block, lane: usize) -> (f64, [f64; 2]) {
        let [a, b, c] = block.corners(lane);
        let (ab, ac) = (b - a, c - a);
        let from_a = self.origin - a;
        let normal = ab.cross(ac);
        let moment = from_a.cross(self.direction);
        let (height, growth) = (from_a.dot(normal), self.direction.dot(normal));
        // What the ray starts on it does not meet, nor what a shadow ray's light lies in: two leaves in one
        // plane would shadow each other by accident of rounding.
        let blur = PLANE_ROUNDOFFS * f64::EPSILON * (self.magnitude + a.abs().max_element());
        let blur_squared = blur * blur * ab.length_squared() * ac.length_squared();
        let end = height + growth * self.t_end;
        if height * height <= blur_squared || end * end <= blur_squared {
            return (f64::NAN, [0.0; 2]);
        }
        let inverse = -1.0 / growth;
        let t = height * inverse;
        let u = ac.dot(moment) * inverse;
        let v = -ab.dot(moment) * inverse;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
            return (t, [u, v]);
        }
        // Rounding made single and double precision disagree, at an edge: take the nearest point.
        settle_at_edge(self.query.ray, self.instance, [a, b, c], u, v)
    }
}

#[cold]
fn settle_at_edge(ray: &Ray, instance: &Instance, [a, b, c]: [DVec3; 3], u: f64, v: f64) -> (f64, [f64; 2]) {
    let (mut u, mut v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    let sum = u + v;
    if sum.is_nan() {
        // The triangle is edge-on.
        (u, v) = (1.0 / 3.0, 1.0 / 3.0);
    } else if sum > 1.0 {
        (u, v) = (u / sum, 1.0 - u / sum);
    }
    let point = instance.relative_from_mesh.transform_point3(a + u * (b - a) + v * (c - a));
    ((point - ray.origin).dot(ray.direction), [u, v])
}

/// The shear that makes the ray the third axis (Woop, Benthin and Wald 2013, "Watertight ray/triangle
/// intersection", JCGT 2(1)).
struct Shear<L> {
    axes: [usize; 3],
    origin: [L; 3],
    /// x and y by z of the direction, and 1 by z.
    shear: [L; 3],
}

impl<L: Lanes> Shear<L> {
    #[inline(always)]
    fn new<S: Simd<Lanes = L>>(simd: S, origin: DVec3, direction: DVec3) -> Self {
        let direction = direction.as_vec3();
        let length = direction.abs();
        let z = if length.x > length.y {
            if length.x > length.z { 0 } else { 2 }
        } else if length.y > length.z {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let inverse = 1.0 / direction[z];
        let origin = origin.as_vec3();
        let axes = [x, y, z];
        Self {
            axes,
            origin: three(
                #[inline(always)]
                |i| simd.splat(origin[axes[i]]),
            ),
            shear: [
                simd.splat(direction[x] * inverse),
                simd.splat(direction[y] * inverse),
                simd.splat(inverse),
            ],
        }
    }

    /// A vertex of each triangle with the ray as third axis.
    #[inline(always)]
    fn sheared<S: Simd<Lanes = L>>(&self, simd: S, vertex: &[Eight; 3]) -> [L; 3] {
        let x = simd.load(&vertex[self.axes[0]]) - self.origin[0];
        let y = simd.load(&vertex[self.axes[1]]) - self.origin[1];
        let z = simd.load(&vertex[self.axes[2]]) - self.origin[2];
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }

    /// The triangles that the ray meets, as bits: surely inside their edges, and between the distances
    /// in single precision.
    #[inline(always)]
    fn candidates<S: Simd<Lanes = L>>(&self, simd: S, block: &Block, t_min: L, t_max: L) -> u32 {
        let zero = simd.splat(0.0);
        let [ax, ay, az] = self.sheared(simd, &block.vertices[0]);
        let [bx, by, bz] = self.sheared(simd, &block.vertices[1]);
        let [cx, cy, cz] = self.sheared(simd, &block.vertices[2]);
        // Edge functions: their signs are right or zero, because rounding is monotonic.
        let u = cx * by - cy * bx;
        let v = ax * cy - ay * cx;
        let w = bx * ay - by * ax;
        let inside = (zero.le(u) & zero.le(v) & zero.le(w)) | (u.le(zero) & v.le(zero) & w.le(zero));
        if inside.bits() == 0 {
            return 0;
        }
        let on_edge = inside & (u.eq(zero) | v.eq(zero) | w.eq(zero));
        let t = (u * az + v * bz + w * cz) * self.shear[2] / (u + v + w);
        let in_range = t_min.le(t) & t.le(t_max);
        let mut hits = (inside & in_range).bits();
        let mut undecided = on_edge.bits();
        if undecided != 0 {
            let (ax, ay) = (simd.store(ax), simd.store(ay));
            let (bx, by) = (simd.store(bx), simd.store(by));
            let (cx, cy) = (simd.store(cx), simd.store(cy));
            hits &= !undecided;
            while undecided != 0 {
                let lane = undecided.trailing_zeros() as usize;
                undecided &= undecided - 1;
                let corners = [ax[lane], ay[lane], bx[lane], by[lane], cx[lane], cy[lane]];
                hits |= u32::from(contains_origin(corners)) << lane;
            }
        }
        hits
    }
}

/// Whether the triangle contains the origin. Products of singles are exact in double precision.
#[cold]
fn contains_origin(corners: [f32; 6]) -> bool {
    let [ax, ay, bx, by, cx, cy] = corners.map(f64::from);
    let edges = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
    let same_side = edges.iter().all(|edge| *edge >= 0.0) || edges.iter().all(|edge| *edge <= 0.0);
    same_side && edges != [0.0; 3]
}
