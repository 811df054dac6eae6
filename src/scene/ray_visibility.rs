//! Ray visibility of a node's meshes. In go nodes and flags, out come the flags of a node. Invariant: light
//! scattered between surfaces sees all of them.

use super::{NodeIndex, Scene};

/// Ray visibility of the meshes at a node, its descendants excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayVisibility {
    /// Whether the camera sees them; mirrors always do.
    pub visible_to_camera: bool,
    /// Whether they block light from lights and the sky.
    pub casts_shadow: bool,
    /// Whether they are holdouts, which the camera sees as black with alpha 0.
    pub holdout: bool,
}

impl RayVisibility {
    /// Default visibility.
    pub const USUAL: Self = Self { visible_to_camera: true, casts_shadow: true, holdout: false };
}

impl Scene {
    /// Sets the ray visibility of the meshes at a node.
    pub fn set_ray_visibility(&mut self, node: NodeIndex, rays: RayVisibility) {
        if rays != RayVisibility::USUAL {
            self.ray_visibility.insert(node, rays);
        }
    }
}
