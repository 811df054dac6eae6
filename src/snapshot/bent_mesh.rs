//! Meshes in their shape at one moment, with their trees. In go an instance and its pose, out come vertices
//! and trees. Invariant: equal poses of an instance give equal meshes, in any order of requests; an instance
//! that keeps its pose keeps its trees.

use crate::accel::MeshTree;
use crate::scene::{Pose, Shape};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Mesh of one instance at one moment.
#[derive(Debug)]
pub(super) struct BentMesh {
    pub(super) pose: Pose,
    pub(super) shape: Shape,
    /// Trees of its opaque and of its blended triangles; `None` where it has none.
    pub(super) trees: [Option<Arc<MeshTree>>; 2],
}

/// The last shape of each instance with a changing shape, by the instance's number.
#[derive(Default)]
pub(super) struct BentMeshes {
    last: Mutex<HashMap<usize, Arc<BentMesh>>>,
}

impl BentMeshes {
    /// Mesh of an instance, by its number, in a pose; `bend` makes it if the last pose differs.
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
