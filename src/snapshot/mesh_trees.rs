//! Mesh trees, built when a frame first needs them and kept for all frames. Invariant: a tree is
//! built at most once; meshes that no frame shows cost nothing.

use crate::accel::MeshTree;
use crate::scene::{MeshIndex, Scene};
use std::sync::{Arc, OnceLock};

/// One tree for each of a scene's meshes.
#[derive(Default)]
pub struct MeshTrees {
    trees: Vec<OnceLock<Arc<MeshTree>>>,
}

impl MeshTrees {
    /// Room for the trees of `scene`.
    pub fn new(scene: &Scene) -> Self {
        Self { trees: scene.meshes.iter().map(|_| OnceLock::new()).collect() }
    }

    /// The tree of a mesh of the scene that these trees were made for.
    pub(super) fn get(&self, scene: &Scene, mesh: MeshIndex) -> Arc<MeshTree> {
        let tree = self.trees[mesh].get_or_init(|| {
            let mesh = &scene.meshes[mesh];
            let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
            Arc::new(MeshTree::new(&mesh.positions, &triangles))
        });
        Arc::clone(tree)
    }

    /// How many trees exist, and how many there could be.
    pub fn built(&self) -> (usize, usize) {
        (self.trees.iter().filter(|tree| tree.get().is_some()).count(), self.trees.len())
    }
}
