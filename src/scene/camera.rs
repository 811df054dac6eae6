//! Cameras: a node and a lens. Invariant: the camera looks along its node's -Z with +Y up
//! (glTF and Blender); its node's scale does not reach the picture.

use super::{NodeIndex, Track};

/// A camera at a node.
#[derive(Clone, Debug)]
pub struct Camera {
    /// The author's name.
    pub name: String,
    /// Where it is.
    pub node: NodeIndex,
    /// What it sees.
    pub lens: Lens,
}

/// How film positions become rays.
#[derive(Clone, Debug)]
pub enum Lens {
    /// Pinhole with a vertical field of view in radians, in `(0, pi)`.
    Perspective {
        /// Full vertical angle, radians.
        fov_y: Track<f64>,
    },
}
