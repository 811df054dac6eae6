//! Mesh trees, built on first use and kept for all frames. In go a scene's meshes, out come trees. Invariant:
//! a tree is built at most once; meshes that no frame shows cost nothing.

use super::bent_mesh::{BentMesh, BentMeshes};
use super::mesh_parts::MeshParts;
use crate::accel::MeshTree;
use crate::color::Rgb;
use crate::scene::{AlphaMode, Deformation, Instance, Material, Mesh, Pose, Scene, Triangle};
use glam::Vec3;
use std::sync::{Arc, OnceLock};

/// The trees of each of a scene's meshes.
#[derive(Default)]
pub struct MeshTrees {
    trees: Vec<PartTrees>,
    /// Whether a material transmits light straight through anywhere, by material.
    pub(super) is_blended: Arc<[bool]>,
    /// Meshes with a changing shape.
    bent: BentMeshes,
    /// Connected parts of the meshes.
    pub(super) parts: Arc<MeshParts>,
}

/// Trees of a mesh, as far as they have been used; triangles have the same numbers in all of them.
#[derive(Default)]
struct PartTrees {
    whole: OnceLock<Arc<MeshTree>>,
    /// Trees of all opaque and of all blended triangles, where the materials of a mesh differ.
    parts: [OnceLock<Arc<MeshTree>>; 2],
}

impl MeshTrees {
    /// Empty trees for `scene`.
    pub fn new(scene: &Scene) -> Self {
        Self {
            trees: scene.meshes.iter().map(|_| PartTrees::default()).collect(),
            is_blended: blended(scene),
            bent: BentMeshes::default(),
            parts: Arc::new(MeshParts::new(scene)),
        }
    }

    /// An instance's mesh, bent into a pose.
    pub(super) fn bent(
        &self,
        scene: &Scene,
        (number, instance): (usize, &Instance),
        deformation: &Deformation,
        pose: Pose,
    ) -> Arc<BentMesh> {
        self.bent.get(number, pose, |pose| {
            let shape = deformation.shape(&scene.meshes[instance.mesh], pose);
            let mesh = &scene.meshes[instance.mesh];
            let trees = self.by_class(scene, instance, |part| self.build(mesh, &shape.positions, part));
            (shape, trees)
        })
    }

    /// Trees of an instance's opaque and of its blended triangles, `None` where it has none. The scene must
    /// be the one that the trees were made for.
    pub(super) fn of(&self, scene: &Scene, instance: &Instance) -> [Option<Arc<MeshTree>>; 2] {
        let (index, mesh) = (instance.mesh, &scene.meshes[instance.mesh]);
        let trees = &self.trees[index];
        self.by_class(scene, instance, |part| {
            let tree = part.map_or(&trees.whole, |class| &trees.parts[usize::from(class)]);
            Arc::clone(tree.get_or_init(|| self.build(mesh, &mesh.positions, part)))
        })
    }

    /// Trees of opaque and of blended triangles, from a function that makes the tree of one of them, or of
    /// all.
    fn by_class(
        &self,
        scene: &Scene,
        instance: &Instance,
        tree: impl Fn(Option<bool>) -> Arc<MeshTree>,
    ) -> [Option<Arc<MeshTree>>; 2] {
        match self.classes(scene, instance) {
            [true, true] => [false, true].map(|class| Some(tree(Some(class)))),
            [false, true] => [None, Some(tree(None))],
            _ => [Some(tree(None)), None],
        }
    }

    /// Whether an instance has opaque triangles, and whether it has blended ones.
    fn classes(&self, scene: &Scene, instance: &Instance) -> [bool; 2] {
        let triangles = &scene.meshes[instance.mesh].triangles;
        match instance.material {
            Some(material) => [!self.is_blended[material], self.is_blended[material]],
            None => [false, true]
                .map(|class| triangles.iter().any(|triangle| self.is_blended[triangle.material] == class)),
        }
    }

    /// The tree of all triangles, or of the opaque or blended ones.
    fn build(&self, mesh: &Mesh, positions: &[Vec3], part: Option<bool>) -> Arc<MeshTree> {
        // Invalid corners, so that the tree leaves such triangles out.
        let nowhere = [u32::MAX; 3];
        let is_in = |triangle: &Triangle| part.is_none_or(|part| self.is_blended[triangle.material] == part);
        let corners = |triangle| if is_in(triangle) { triangle.vertices } else { nowhere };
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(corners).collect();
        Arc::new(MeshTree::new(positions, &triangles))
    }
}

/// Whether each material transmits light straight through anywhere.
fn blended(scene: &Scene) -> Arc<[bool]> {
    let mut fades = vec![false; scene.materials.len()];
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let fading = if mesh.alphas.is_empty() { &[] } else { mesh.triangles.as_slice() };
        for triangle in fading {
            fades[instance.material.unwrap_or(triangle.material)] = true;
        }
    }
    scene.materials.iter().zip(fades).map(|(material, fades)| is_blended(scene, material, fades)).collect()
}

/// Whether a material transmits light straight through anywhere; `fades` if vertices that have an alpha show
/// it.
fn is_blended(scene: &Scene, material: &Material, fades: bool) -> bool {
    let texture = material.base_color_texture.map(|texture| &scene.textures[texture]);
    material.alpha_mode == AlphaMode::Blend
        && (material.opacity < 1.0
            || fades
            || material.changes.is_some()
            || material.filter_color != Rgb::ZERO
            || texture.is_some_and(|texture| texture.has_alpha()))
}
