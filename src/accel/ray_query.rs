//! Rays against trees and triangles. In goes a ray in double precision, out comes the nearest hit, or whether
//! there is one. Invariant: no ray passes between triangles that share an edge or a vertex.
//!
//! Candidates are found in single precision and settled in double precision. So a hit's distance is accurate
//! to a few units in 1e16, and a ray that starts on a surface needs no offset.

use super::{
    block::Block,
    box_ray::{BoxRay, Entry, LeafVisitor},
    hit::{Hit, PrimitiveId},
    instance::{Instance, Instances},
    mesh_tree::MeshTree,
    rounding::{round_down, round_up},
    shear::Shear,
    simd::{Kernel, Lanes, Simd},
    wide_tree::{LEAF, Stack, padding},
};
use crate::math::Ray;
use glam::DVec3;

/// Distance from a triangle's plane, in roundings of double precision, below which an end of a ray counts as
/// in the plane: computing an end takes a dozen operations, and its height as many.
const PLANE_ROUNDOFFS: f64 = 32.0;

/// Distance in barycentrics at which a ray may miss a triangle and is still settled on its plane. So two
/// triangles of a plane have no step between them, at any size. Farther out the triangle is nearly edge-on,
/// and the hit on its plane may be anywhere.
const BESIDE_AN_EDGE: f64 = 1e-3;

/// Search for the nearest hit with `0 < t < t_max`; for the first that is found if `any`.
pub(super) struct Trace<'a> {
    pub(super) instances: Instances<'a>,
    pub(super) ray: &'a Ray,
    pub(super) t_max: f64,
    pub(super) skip: Option<PrimitiveId>,
    pub(super) any: bool,
    /// What is found so far, `t_max` away.
    pub(super) nearest: Option<Hit>,
}

impl Kernel for Trace<'_> {
    type Output = Option<Hit>;
    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) -> Option<Hit> {
        let Self { instances, ray, t_max, .. } = self;
        let mut stack = Stack::new();
        let padding = padding(ray.origin.abs().max_element()) as f32;
        let (origin, direction) = (ray.origin.as_vec3().to_array(), ray.direction.as_vec3().to_array());
        let box_ray = BoxRay::new(simd, origin, direction, padding, 0.0);
        box_ray.visit_leaves(simd, instances.tree, round_up(t_max), &mut stack, &mut self);
        self.nearest
    }
}

impl<S: Simd> LeafVisitor<S> for Trace<'_> {
    #[inline(always)]
    fn expect(&self, simd: S, child: u32) {
        let Instances { tree, list } = self.instances;
        if child & LEAF != 0 {
            simd.prefetch(&list[(child & !LEAF) as usize]);
        } else {
            simd.prefetch(&tree.nodes[child as usize]);
        }
    }

    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, stack: &mut Stack<Entry>, t_far: &mut f32) -> bool {
        let instance = &self.instances.list[leaf as usize];
        let mesh = &*instance.mesh;
        let mesh_from_relative = instance.mesh_from_relative();
        let origin = mesh_from_relative.transform_point3(self.ray.origin);
        let direction = mesh_from_relative.transform_vector3(self.ray.direction);
        // Re-centred on the ray's point nearest to the mesh's centre, so the remainder has the mesh's
        // magnitude.
        let to_centre = mesh.centre - origin;
        let t_centre = to_centre.dot(direction) / direction.length_squared();
        let centred = origin + t_centre * direction;
        let from_origin = centred.abs().max_element();
        let box_ray = BoxRay::new(
            simd,
            centred.as_vec3().to_array(),
            direction.as_vec3().to_array(),
            padding(from_origin) as f32,
            round_down(-t_centre),
        );
        let local_t_far = round_up(self.t_max - t_centre);
        // A flat leaf lies diagonally in its box in relative space, so most rays through the box miss it.
        if !box_ray.may_meet(simd, &mesh.tree, local_t_far) {
            return false;
        }
        let reach = from_origin + f64::from(mesh.tree.bounds.magnitude().max_element());
        let slack = padding(reach) / direction.abs().max_element();
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
        let over = box_ray.visit_leaves(simd, &mesh.tree, local_t_far, stack, &mut query);
        *t_far = round_up(self.t_max);
        over
    }
}

/// Query over one instance's mesh.
struct MeshQuery<'a, 'b, L> {
    mesh: &'a MeshTree,
    instance: &'a Instance,
    /// The ray in the mesh's space; its direction is not normalised, so that `t` is the same as outside.
    origin: DVec3,
    direction: DVec3,
    /// Magnitude of the numbers from which the ray's ends are computed, in the mesh's space; their rounding
    /// is a fraction of it.
    magnitude: f64,
    /// End of the ray, if it ends at a given point.
    t_end: f64,
    t_centre: f64,
    shear: Shear<L>,
    t_min: L,
    /// Error bound of a distance in single precision.
    slack: f64,
    skip: u32,
    query: &'b mut Trace<'a>,
}

impl<S: Simd> LeafVisitor<S> for MeshQuery<'_, '_, S::Lanes> {
    #[inline(always)]
    fn visit(&mut self, simd: S, leaf: u32, _: &mut Stack<Entry>, t_far: &mut f32) -> bool {
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
    /// Distance and barycentrics in double precision of a hit found in single precision (Moller and Trumbore
    /// 1997).
    #[inline(always)]
    fn settle(&self, block: &Block, lane: usize) -> (f64, [f64; 2]) {
        let [a, b, c] = block.corners(lane);
        let (ab, ac) = (b - a, c - a);
        let from_a = self.origin - a;
        let normal = ab.cross(ac);
        let moment = from_a.cross(self.direction);
        let (height, growth) = (from_a.dot(normal), self.direction.dot(normal));
        // A ray does not hit the surface on which it starts, nor a shadow ray that of its light: two leaves
        // in one plane would shadow each other by rounding.
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
        // Single and double precision disagree at an edge.
        let (inside, beyond) = nearest_inside(u, v);
        if beyond <= BESIDE_AN_EDGE {
            return (t, inside);
        }
        let [u, v] = inside;
        let point = self.instance.relative_from_mesh.transform_point3(a + u * ab + v * ac);
        ((point - self.query.ray.origin).dot(self.query.ray.direction), inside)
    }
}

/// Barycentrics of the triangle's point nearest to one outside, and the distance of that, also in
/// barycentrics.
#[cold]
fn nearest_inside(u: f64, v: f64) -> ([f64; 2], f64) {
    let (mut near_u, mut near_v) = (u.clamp(0.0, 1.0), v.clamp(0.0, 1.0));
    let sum = near_u + near_v;
    if sum.is_nan() {
        // The triangle is edge-on.
        return ([1.0 / 3.0; 2], f64::INFINITY);
    }
    if sum > 1.0 {
        (near_u, near_v) = (near_u / sum, 1.0 - near_u / sum);
    }
    ([near_u, near_v], (u - near_u).abs().max((v - near_v).abs()))
}
