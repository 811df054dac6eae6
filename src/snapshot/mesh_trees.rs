//! Mesh trees, built when a frame first needs them and kept for all frames. Invariant: a tree is
//! built at most once; meshes that no frame shows cost nothing.

use crate::accel::MeshTree;
use crate::color::Rgb;
use crate::scene::{AlphaMode, Instance, Material, MeshIndex, Scene};
use std::sync::{Arc, OnceLock};

/// The trees of each of a scene's meshes.
#[derive(Default)]
pub struct MeshTrees {
    trees: Vec<PartTrees>,
    /// Of each material, whether anything shows through it.
    is_blended: Vec<bool>,
}

/// Trees of a mesh, as far as they were needed; triangles keep their numbers in all of them.
#[derive(Default)]
struct PartTrees {
    whole: OnceLock<Arc<MeshTree>>,
    /// Of meshes whose materials differ: all opaque triangles, and all blended ones.
    parts: [OnceLock<Arc<MeshTree>>; 2],
}

impl MeshTrees {
    /// Room for the trees of `scene`.
    pub fn new(scene: &Scene) -> Self {
        Self {
            trees: scene.meshes.iter().map(|_| PartTrees::default()).collect(),
            is_blended: scene.materials.iter().map(|material| is_blended(scene, material)).collect(),
        }
    }

    /// The trees of an instance's opaque and of its blended triangles, where it has such, of the scene that
    /// these trees were made for.
    pub(super) fn of(&self, scene: &Scene, instance: &Instance) -> [Option<Arc<MeshTree>>; 2] {
        let mesh = &scene.meshes[instance.mesh];
        let has = match instance.material {
            Some(material) => [!self.is_blended[material], self.is_blended[material]],
            None => [false, true].map(|class| {
                mesh.triangles.iter().any(|triangle| self.is_blended[triangle.material] == class)
            }),
        };
        match has {
            [true, true] => [false, true].map(|class| Some(self.part(scene, instance.mesh, class))),
            [false, true] => [None, Some(self.whole(scene, instance.mesh))],
            _ => [Some(self.whole(scene, instance.mesh)), None],
        }
    }

    fn whole(&self, scene: &Scene, mesh: MeshIndex) -> Arc<MeshTree> {
        let tree = self.trees[mesh].whole.get_or_init(|| {
            let mesh = &scene.meshes[mesh];
            let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
            Arc::new(MeshTree::new(&mesh.positions, &triangles))
        });
        Arc::clone(tree)
    }

    fn part(&self, scene: &Scene, mesh: MeshIndex, blended: bool) -> Arc<MeshTree> {
        let tree = self.trees[mesh].parts[usize::from(blended)].get_or_init(|| {
            let mesh = &scene.meshes[mesh];
            // Corners that do not exist: such triangles are left out.
            let nowhere = [u32::MAX; 3];
            let triangles = mesh.triangles.iter().map(|triangle| {
                if self.is_blended[triangle.material] == blended { triangle.vertices } else { nowhere }
            });
            Arc::new(MeshTree::new(&mesh.positions, &triangles.collect::<Vec<_>>()))
        });
        Arc::clone(tree)
    }

    /// How many meshes have trees, and how many there are.
    pub fn built(&self) -> (usize, usize) {
        let is_built = |trees: &&PartTrees| {
            trees.whole.get().is_some() || trees.parts.iter().any(|part| part.get().is_some())
        };
        (self.trees.iter().filter(is_built).count(), self.trees.len())
    }
}

/// Whether anything shows through a material anywhere.
fn is_blended(scene: &Scene, material: &Material) -> bool {
    let texture = material.base_color_texture.map(|texture| &scene.textures[texture]);
    material.alpha_mode == AlphaMode::Blend
        && (material.opacity < 1.0
            || material.filter_color != Rgb::ZERO
            || texture.is_some_and(|texture| texture.has_alpha()))
}
