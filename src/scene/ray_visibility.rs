//! Ray visibility of a node's surfaces. Invariant: light that is scattered from surface to surface meets
//! all of them.

use super::{NodeIndex, Scene};

/// Ray visibility of the meshes at a node, not of those below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayVisibility {
    /// Whether the camera sees them; mirrors do in any case.
    pub visible_to_camera: bool,
    /// Whether they keep light of lights and of the sky from what lies behind them.
    pub casts_shadow: bool,
    /// Whether the camera sees a hole in the picture in their place: black, with alpha 0.
    pub holdout: bool,
}

impl RayVisibility {
    /// Visibility of surfaces without flags.
    pub const USUAL: Self = Self { visible_to_camera: true, casts_shadow: true, holdout: false };
}

impl Scene {
    /// Says which rays meet the meshes at a node.
    pub fn set_ray_visibility(&mut self, node: NodeIndex, rays: RayVisibility) {
        if rays != RayVisibility::USUAL {
            self.ray_visibility.insert(node, rays);
        }
    }
}
