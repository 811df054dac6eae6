//! A mesh placed in a frame. In go the mesh and its place, out come the data that queries need. Invariant:
//! relative space; a mesh with a singular matrix is no instance.

use super::mesh_tree::MeshTree;
use super::wide_tree::WideTree;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// Largest scale, and inverse of the smallest, that single precision holds; beyond it a matrix counts as
/// singular.
const LARGEST_SCALE: f64 = 1e15;

/// One mesh placed in the frame.
#[derive(Clone, Debug)]
pub struct PlacedMesh {
    /// The mesh.
    pub mesh: Arc<MeshTree>,
    /// Transform, relative to the camera along the world's axes, in metres.
    pub relative_from_mesh: DAffine3,
}

/// A placed mesh with the data that queries need.
#[derive(Debug)]
pub(super) struct Instance {
    pub(super) mesh: Arc<MeshTree>,
    pub(super) relative_from_mesh: DAffine3,
    /// Whether shadows and slices cut it in double precision.
    pub(super) needs_doubles: bool,
    /// Position in the list of placed meshes.
    pub(super) index: u32,
}

/// Distance of the camera, as a fraction of a mesh's size, below which its rounding in single precision, some
/// 1e-7 of its size, is visible. An example is ground that reaches the horizon.
const NEAR: f64 = 0.25;

/// Maximum number of blocks of meshes in double precision, which is slower.
const FEW_BLOCKS: usize = 64;

impl PlacedMesh {
    /// Inverse of its transform; `None` where no ray can hit it, as its matrix is singular or it is empty.
    pub fn mesh_from_relative(&self) -> Option<DAffine3> {
        let Self { mesh, relative_from_mesh } = self;
        let determinant = relative_from_mesh.matrix3.determinant();
        if mesh.tree.bounds.is_empty() || determinant == 0.0 {
            return None;
        }
        let mesh_from_relative = relative_from_mesh.inverse();
        let is_sane = |affine: &DAffine3| {
            affine.to_cols_array().iter().all(|entry| entry.is_finite())
                && affine.matrix3.to_cols_array().iter().all(|entry| entry.abs() < LARGEST_SCALE)
        };
        (is_sane(relative_from_mesh) && is_sane(&mesh_from_relative)).then_some(mesh_from_relative)
    }
}

impl Instance {
    pub(super) fn new(index: u32, placed: PlacedMesh) -> Option<Self> {
        let mesh_from_relative = placed.mesh_from_relative()?;
        let PlacedMesh { mesh, relative_from_mesh } = placed;
        let bounds = mesh.tree.bounds;
        let nearest = mesh_from_relative.translation.clamp(bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let distance = relative_from_mesh.transform_point3(nearest).length();
        let half_size = relative_from_mesh.transform_vector3(bounds.max.as_dvec3() - mesh.centre).length();
        let needs_doubles = mesh.blocks.len() <= FEW_BLOCKS && distance < NEAR * half_size;
        Some(Self { mesh, relative_from_mesh, needs_doubles, index })
    }

    /// Inverse of its transform. It is computed anew, as instances of many moments are most of their memory,
    /// and traversal waits for memory.
    #[inline(always)]
    pub(super) fn mesh_from_relative(&self) -> DAffine3 {
        self.relative_from_mesh.inverse()
    }

    /// Bounds in relative space, from the boxes of its tree's uppermost nodes.
    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let matrix = self.relative_from_mesh.matrix3;
        let absolute = glam::DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs());
        let mut bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for top_box in &self.mesh.tree.top_boxes {
            let (min, max) = (top_box.min.as_dvec3(), top_box.max.as_dvec3());
            let centre = self.relative_from_mesh.transform_point3((min + max) / 2.0);
            let extent = absolute * ((max - min) / 2.0);
            bounds = (bounds.0.min(centre - extent), bounds.1.max(centre + extent));
        }
        bounds
    }
}

/// All instances of a frame, and the tree over them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instances<'a> {
    pub(super) tree: &'a WideTree,
    /// Instances in the order of the tree's leaves.
    pub(super) list: &'a [Instance],
}
