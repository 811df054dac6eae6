//! Ray and shadow queries of triangles. In go placed meshes and rays, out come nearest hits, occlusion, and
//! the parts of a ray in the shadow of a light. Invariant: answers have the same bits with and without SIMD.
//!
//! A [`MeshTree`] is built once per mesh and shared. An [`InstanceTree`] places such meshes for one frame in
//! *relative space*: world axes, with the camera at the origin. The camera is subtracted in double precision
//! before anything is rounded. Inside, a query is re-centred once more on each instance it visits. So single
//! precision has to resolve a mesh, never a landscape.
//!
//! The kernels are written once over `simd::Lanes` and instantiated for AVX2 and for plain Rust. The
//! instruction set is detected at run time (`level.rs`).

#[cfg(target_arch = "x86_64")]
mod avx2;
mod block;
mod box_ray;
mod box_region;
mod each_shadow;
mod hit;
mod instance;
mod instance_tree;
mod level;
mod light_plane;
mod mesh_tree;
mod prefetch;
mod ray_query;
mod rounding;
mod shadow_query;
mod shear;
mod simd;
mod slice_query;
mod triangle_cut;
mod wide_tree;

pub use each_shadow::TriangleShadow;
pub use hit::{Hit, PrimitiveId};
pub use instance::PlacedMesh;
pub use instance_tree::{InstanceTree, SharedTree};
pub use level::{Vectorized, vectorized};
pub use light_plane::LightPlane;
pub use mesh_tree::MeshTree;
pub use prefetch::prefetch;
pub use slice_query::{Cut, HalfPlane};
