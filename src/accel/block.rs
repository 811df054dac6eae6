//! Up to eight triangles side by side. In go triangles, out come their vertices by lane. Invariant: lanes
//! without a triangle hold NaN, which fails every comparison, so nothing hits them.

use super::simd::{Eight, WIDTH};
use glam::{DVec3, Vec3};

/// A leaf of a mesh's tree.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    /// Coordinates by vertex, then axis.
    pub(super) vertices: [[Eight; 3]; 3],
    /// Number of each lane's triangle in the mesh.
    pub(super) triangles: [u32; WIDTH],
}

impl Block {
    pub(super) fn new(triangles: impl Iterator<Item = (u32, [Vec3; 3])>) -> Self {
        let mut block = Self { vertices: [[Eight([f32::NAN; WIDTH]); 3]; 3], triangles: [u32::MAX; WIDTH] };
        for (lane, (index, corners)) in triangles.enumerate().take(WIDTH) {
            block.triangles[lane] = index;
            for (vertex, corner) in corners.into_iter().enumerate() {
                for axis in 0..3 {
                    block.vertices[vertex][axis].0[lane] = corner[axis];
                }
            }
        }
        block
    }

    #[inline(always)]
    pub(super) fn corners(&self, lane: usize) -> [DVec3; 3] {
        self.vertices
            .map(|[x, y, z]| DVec3::new(f64::from(x.0[lane]), f64::from(y.0[lane]), f64::from(z.0[lane])))
    }

    /// The lanes that hold triangles.
    pub(super) fn lanes(&self) -> impl Iterator<Item = usize> {
        (0..WIDTH).filter(|lane| self.triangles[*lane] != u32::MAX)
    }
}
