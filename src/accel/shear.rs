//! Rays against the triangles of a block, in single precision. In go a ray and a block, out come the
//! triangles that the ray may meet. Invariant: no ray passes between triangles that share an edge or a
//! vertex.

use super::{
    block::Block,
    simd::{Eight, Lanes, Mask, Simd, three},
};
use glam::DVec3;

/// The shear that makes the ray the third axis (Woop, Benthin and Wald 2013, "Watertight ray/triangle
/// intersection", JCGT 2(1)).
pub(super) struct Shear<L> {
    axes: [usize; 3],
    origin: [L; 3],
    /// x and y over z of the direction, and 1 over z.
    shear: [L; 3],
}

impl<L: Lanes> Shear<L> {
    #[inline(always)]
    pub(super) fn new<S: Simd<Lanes = L>>(simd: S, origin: DVec3, direction: DVec3) -> Self {
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

    /// Triangles that the ray meets, as bits: certainly within their edges, and between the distances in
    /// single precision.
    #[inline(always)]
    pub(super) fn candidates<S: Simd<Lanes = L>>(&self, simd: S, block: &Block, t_min: L, t_max: L) -> u32 {
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
