//! Boxes in, answers out: which triangle a ray meets first, whether it meets any, and which parts of
//! it lie in the shadow of a light. Invariant: answers are the same bits with and without SIMD.
//!
//! A [`MeshTree`] is built once per mesh and shared; an [`InstanceTree`] places such meshes for one
//! frame in *relative space*: world axes, with the origin at the camera, subtracted in double
//! precision before anything is rounded. Inside, a query is re-centred once more on each instance it
//! visits, so that single precision has to resolve a mesh, never a landscape.
//!
//! The kernels are written once over `simd::Lanes` and instantiated for AVX2 and for plain Rust;
//! the processor is asked at run time.

#[cfg(target_arch = "x86_64")]
mod avx2;
mod block;
mod each_shadow;
mod instance_tree;
mod light_plane;
mod mesh_tree;
mod ray_query;
mod rounding;
mod shadow_query;
mod simd;
mod slice_query;
mod stack;
mod triangle_cut;
mod wide_tree;

pub use each_shadow::TriangleShadow;
pub use instance_tree::{InstanceTree, PlacedMesh};
pub use light_plane::LightPlane;
pub use mesh_tree::MeshTree;
pub use slice_query::{Cut, HalfPlane};

/// A triangle of a placed mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimitiveId {
    /// Index into the meshes an [`InstanceTree`] was made of.
    pub instance: u32,
    /// Index into the triangles its [`MeshTree`] was made of.
    pub triangle: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, in metres.
    pub t: f64,
    /// What it met.
    pub primitive: PrimitiveId,
    /// Weights of the triangle's vertices 1 and 2; both and their sum lie in `[0, 1]`.
    pub barycentrics: [f64; 2],
}
