//! Meshes in the shape that they have at one moment, ready to be hit. In go an instance and its pose, out come
//! vertices and trees. Invariant: the same pose of the same instance is the same mesh, whoever asked
//! for another in between; an instance that keeps its pose keeps its trees.

use super::mesh_trees::MeshTrees;
use crate::accel::MeshTree;
use crate::scene::{Deformation, Instance, Pose, Scene, Shape};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// One instance's mesh at one moment.
#[derive(Debug)]
pub(super) struct BentMesh {
    pose: Pose,
    pub(super) shape: Shape,
    /// Of its opaque and of its blended triangles, where it has such.
    pub(super) trees: [Option<Arc<MeshTree>>; 2],
}

/// The last shape of each instance that changes its own, by the instance's number.
#[derive(Default)]
pub(super) struct BentMeshes {
    last: Mutex<HashMap<usize, Arc<BentMesh>>>,
}

impl BentMeshes {
    /// An instance's mesh in a pose.
    pub(super) fn get(
        &self,
        scene: &Scene,
        trees: &MeshTrees,
        (number, instance): (usize, &Instance),
        deformation: &Deformation,
        pose: Pose,
    ) -> Arc<BentMesh> {
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(mesh) = last().get(&number).filter(|mesh| mesh.pose == pose) {
            return Arc::clone(mesh);
        }
        let shape = deformation.shape(&scene.meshes[instance.mesh], &pose);
        let trees = trees.of_shape(scene, instance, &shape.positions);
        let mesh = Arc::new(BentMesh { pose, shape, trees });
        last().insert(number, Arc::clone(&mesh));
        mesh
    }
}
