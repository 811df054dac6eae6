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
    /// The opening that blurs what is out of focus; `None` is a pinhole.
    pub aperture: Option<Aperture>,
}

/// The opening of a thin lens.
#[derive(Clone, Debug)]
pub struct Aperture {
    /// Focal length over the opening's diameter, above 0.
    pub f_stop: Track<f64>,
    /// Width of the sensor, metres: with the horizontal angle of view it gives the focal length.
    pub sensor_width_m: f64,
    /// Distance of the plane in focus along the view axis, metres, above 0.
    pub focus_distance_m: Track<f64>,
    /// Straight blades of the opening, at least 3; 0 is a round one.
    pub blades: u32,
}

impl Aperture {
    /// True if it is the same at all times.
    pub fn is_constant(&self) -> bool {
        self.f_stop.is_constant() && self.focus_distance_m.is_constant()
    }
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
