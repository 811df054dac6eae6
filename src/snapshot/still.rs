//! What keeps still while the shutter is open. In goes a scene, out come the instances that stand in one
//! place at all times, and the tree of these. Invariant: it is the same at every moment.

use crate::accel::{InstanceTree, PlacedMesh};
use crate::scene::Scene;
use std::sync::{Arc, OnceLock};

/// Instances that keep still. Most of a wood does, and a tree of it for each moment would be most of the
/// memory.
pub(super) struct Still {
    /// By the scene's numbers.
    keeps: Vec<bool>,
    tree: OnceLock<Arc<InstanceTree>>,
}

impl Still {
    /// `None` where nothing keeps still beside the camera.
    pub(super) fn of(scene: &Scene, camera: usize) -> Option<Self> {
        let mut nodes: Vec<bool> = Vec::with_capacity(scene.nodes.len());
        for node in &scene.nodes {
            let is_carried = node.parent.is_some_and(|parent| !nodes[parent]);
            nodes.push(!is_carried && node.motion.is_still() && node.visible.is_constant());
        }
        let keeps = scene.instances.iter();
        let keeps: Vec<bool> = keeps.map(|one| one.deformation.is_none() && nodes[one.node]).collect();
        let is_any = nodes[scene.cameras[camera].node] && keeps.contains(&true);
        is_any.then_some(Self { keeps, tree: OnceLock::new() })
    }

    pub(super) fn keeps(&self, instance: usize) -> bool {
        self.keeps[instance]
    }

    /// Tree of those with opaque triangles, which are given in the scene's order.
    pub(super) fn tree(&self, opaque: &[PlacedMesh]) -> Arc<InstanceTree> {
        Arc::clone(self.tree.get_or_init(|| Arc::new(InstanceTree::new(opaque.to_vec()))))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::scene::{Camera, Clip, Extend, Instance, Key, Lens, Motion, Rotation, Segment, Track};
    use glam::{DQuat, DVec2, DVec3};

    fn moving() -> Motion {
        let key = |time_s, x| Key { time_s, value: DVec3::new(x, 0.0, 0.0), to_next: Segment::Linear };
        // Back where it began when the shutter closes.
        let keys = vec![key(0.0, 0.0), key(0.5, 1.0), key(1.0, 0.0)];
        Motion::Keyed {
            translation: Track::new(keys, Extend::Hold).unwrap(),
            rotation: Rotation::Quaternion(Track::from(DQuat::IDENTITY)),
            scale: Track::from(DVec3::ONE),
        }
    }

    /// Things that stand, that move and that stand on what moves.
    fn scene(camera: Motion) -> Scene {
        let mut scene = Scene::default();
        let node = scene.add_node(String::new(), None, camera);
        let lens = Lens::Perspective { fov_y: Track::from(1.0) };
        let (shift, clip) = (DVec2::ZERO, Clip::NONE);
        scene.cameras.push(Camera { name: String::new(), node, lens, shift, aperture: None, clip });
        let stands = scene.add_node(String::new(), None, Motion::STILL);
        let moves = scene.add_node(String::new(), None, moving());
        let rides = scene.add_node(String::new(), Some(moves), Motion::STILL);
        let instance = |node| Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None };
        scene.instances = [stands, moves, rides].map(instance).to_vec();
        scene
    }

    #[test]
    fn what_moves_and_what_it_carries_does_not_keep_still() {
        let still = Still::of(&scene(Motion::STILL), 0).unwrap();
        assert_eq!(still.keeps, [true, false, false]);
    }

    #[test]
    fn nothing_keeps_still_for_a_camera_that_moves() {
        assert!(Still::of(&scene(moving()), 0).is_none());
    }
}
