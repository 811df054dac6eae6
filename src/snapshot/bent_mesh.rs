//! Meshes in the shape that they have at one moment, ready to be hit. In go an instance and its pose, out
//! come vertices and trees. Invariant: the same pose of the same instance is the same mesh, whoever asked for
//! another in between; an instance that keeps its pose keeps its trees.

use crate::accel::MeshTree;
use crate::scene::{Pose, Shape};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Mesh of one instance at one moment.
#[derive(Debug)]
pub(super) struct BentMesh {
    pub(super) pose: Pose,
    pub(super) shape: Shape,
    /// Trees of its opaque and of its blended triangles, where it has such.
    pub(super) trees: [Option<Arc<MeshTree>>; 2],
}

/// The last shape of each instance that changes its own, by the instance's number.
#[derive(Default)]
pub(super) struct BentMeshes {
    last: Mutex<HashMap<usize, Arc<BentMesh>>>,
}

impl BentMeshes {
    /// The mesh of an instance by its number, in a pose; `bend` makes it if it was in another.
    pub(super) fn get(
        &self,
        number: usize,
        pose: Pose,
        bend: impl FnOnce(&Pose) -> (Shape, [Option<Arc<MeshTree>>; 2]),
    ) -> Arc<BentMesh> {
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(mesh) = last().get(&number).filter(|mesh| mesh.pose == pose) {
            return Arc::clone(mesh);
        }
        let (shape, trees) = bend(&pose);
        let mesh = Arc::new(BentMesh { pose, shape, trees });
        last().insert(number, Arc::clone(&mesh));
        mesh
    }
}
