//! Instances that are still while the shutter is open. In goes a scene, out come the instances that never
//! move, and their tree. Invariant: the tree is the same at every moment, wherever the camera is.

use crate::accel::{InstanceTree, PlacedMesh, SharedTree};
use crate::scene::Scene;
use glam::DVec3;
use std::sync::{Arc, OnceLock};

/// Maximum motion of the camera, as a share of the diagonal of the still instances. A tree in single
/// precision is only accurate near its origin.
const FARTHEST: f64 = 0.01;

/// Still instances. Most of a wood is still, and a tree for each moment would take most of the memory.
pub(super) struct Still {
    /// Whether each of the scene's instances is still.
    keeps: Vec<bool>,
    /// Tree of these instances, and its origin in the world.
    tree: OnceLock<(Arc<InstanceTree>, DVec3)>,
}

impl Still {
    /// Finds the still instances; `None` if there are none.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        let mut nodes: Vec<bool> = Vec::with_capacity(scene.nodes.len());
        for node in &scene.nodes {
            let is_carried = node.parent.is_some_and(|parent| !nodes[parent]);
            nodes.push(!is_carried && node.motion.is_still() && node.visible.is_constant());
        }
        let keeps = scene.instances.iter();
        let keeps: Vec<bool> = keeps.map(|one| one.deformation.is_none() && nodes[one.node]).collect();
        keeps.contains(&true).then_some(Self { keeps, tree: OnceLock::new() })
    }

    pub(super) fn keeps(&self, instance: usize) -> bool {
        self.keeps[instance]
    }

    /// Tree of the still instances with opaque triangles, which are given in the scene's order relative to an
    /// origin in the world. `None` if that is too far from the origin of the first call.
    pub(super) fn tree(&self, opaque: &[PlacedMesh], origin: DVec3) -> Option<SharedTree> {
        let made = || (Arc::new(InstanceTree::new(opaque.to_vec())), origin);
        let (tree, about) = self.tree.get_or_init(made);
        let origin = origin - about;
        let diagonal = tree.bounds().map_or(0.0, |(low, high)| low.distance(high));
        let count = opaque.len() as u32;
        (origin.length() <= FARTHEST * diagonal).then(|| SharedTree { tree: Arc::clone(tree), count, origin })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::accel::MeshTree;
    use crate::scene::{Extend, Instance, Key, Motion, Rotation, Segment, Track};
    use glam::{DAffine3, DQuat, Vec3};

    fn moving() -> Motion {
        let key = |time_s, x| Key { time_s, value: DVec3::new(x, 0.0, 0.0), to_next: Segment::Linear };
        // The motion is back at its start when the shutter closes.
        let keys = vec![key(0.0, 0.0), key(0.5, 1.0), key(1.0, 0.0)];
        Motion::Keyed {
            translation: Track::new(keys, Extend::Hold).unwrap(),
            rotation: Rotation::Quaternion(Track::from(DQuat::IDENTITY)),
            scale: Track::from(DVec3::ONE),
        }
    }

    /// Objects that are still, that move, and that are children of moving ones.
    fn scene() -> Scene {
        let mut scene = Scene::default();
        let stands = scene.add_node(String::new(), None, Motion::STILL);
        let moves = scene.add_node(String::new(), None, moving());
        let rides = scene.add_node(String::new(), Some(moves), Motion::STILL);
        let instance = |node| Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None };
        scene.instances = [stands, moves, rides].map(instance).to_vec();
        scene
    }

    #[test]
    fn what_moves_and_what_it_carries_does_not_keep_still() {
        let still = Still::of(&scene()).unwrap();
        assert_eq!(still.keeps, [true, false, false]);
    }

    /// A camera with a small motion shares the tree; one with a large motion has its own.
    #[test]
    fn a_tree_is_shared_by_who_is_near() {
        let still = Still::of(&scene()).unwrap();
        let mesh = Arc::new(MeshTree::new(&[Vec3::ZERO, Vec3::X, Vec3::Y], &[[0, 1, 2]]));
        let placed = [0.0, 99.0].map(|x| {
            let relative_from_mesh = DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
            PlacedMesh { mesh: Arc::clone(&mesh), relative_from_mesh }
        });
        let origins =
            [5.0, 5.9, 6.1].map(|x| still.tree(&placed, DVec3::X * x).map(|shared| shared.origin.x));
        assert_eq!(origins.map(|x| x.map(|x| (10.0 * x).round())), [Some(0.0), Some(9.0), None]);
    }
}
