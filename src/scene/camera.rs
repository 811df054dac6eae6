//! Cameras: a node and a lens. In go lens parameters, out come projections. Invariant: the camera looks along
//! its node's -Z with +Y up (glTF and Blender); its node's scale has no effect.

use super::{NodeIndex, Track};
use glam::{DMat4, DVec2, DVec4};

/// A camera at a node.
#[derive(Clone, Debug)]
pub struct Camera {
    /// The author's name.
    pub name: String,
    /// Node that it stands at.
    pub node: NodeIndex,
    /// Projection.
    pub lens: Lens,
    /// Offset of the picture's centre from the view axis, to the right and up, relative to the picture's
    /// longer side: Blender's shift.
    pub shift: DVec2,
    /// Opening for depth of field; `None` is a pinhole.
    pub aperture: Option<Aperture>,
    /// Clipping planes.
    pub clip: Clip,
}

/// Blender's clip start and end: the camera sees only surfaces between two planes perpendicular to the view
/// axis. Mirrors, light and fog ignore them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clip {
    /// Distance of the nearer plane along the view axis, metres, at least 0.
    pub start_m: f64,
    /// Distance of the farther one, more than `start_m`; infinite if there is none.
    pub end_m: f64,
}

impl Clip {
    /// No clipping.
    pub const NONE: Self = Self { start_m: 0.0, end_m: f64::INFINITY };
}

/// Opening of a thin lens.
#[derive(Clone, Debug)]
pub struct Aperture {
    /// Focal length over the opening's diameter, above 0.
    pub f_stop: Track<f64>,
    /// Width of the sensor, metres, which with the horizontal angle of view determines the focal length.
    pub sensor_width_m: f64,
    /// Distance of the plane in focus along the view axis, metres, above 0.
    pub focus_distance_m: Track<f64>,
    /// Straight blades of the opening, at least 3; 0 is a round one.
    pub blades: u32,
}

/// Projection from film positions to rays.
#[derive(Clone, Debug)]
pub enum Lens {
    /// Pinhole with a vertical field of view in radians, in `(0, pi)`.
    Perspective {
        /// Full vertical angle, radians.
        fov_y: Track<f64>,
    },
    /// Parallel rays along the view axis, from the camera's plane.
    Orthographic {
        /// Height of the whole picture, metres, above 0.
        height_m: Track<f64>,
    },
}

impl Lens {
    /// Parameter that may be keyed: the angle of view, or the height.
    pub fn number(&self) -> &Track<f64> {
        match self {
            Self::Perspective { fov_y } => fov_y,
            Self::Orthographic { height_m } => height_m,
        }
    }

    /// Half the picture's height, at distance 1 for a pinhole.
    pub fn half_height(&self, time_s: f64) -> f64 {
        match self {
            Self::Perspective { fov_y } => (0.5 * fov_y.at(time_s)).tan(),
            Self::Orthographic { height_m } => 0.5 * height_m.at(time_s),
        }
    }
}

impl Camera {
    /// Half the picture's width and height, and its centre, to the right and up, in the plane at distance 1
    /// (for an orthographic camera in any plane, metres). `aspect` is width / height.
    pub fn picture(&self, aspect: f64, time_s: f64) -> (DVec2, DVec2) {
        let half_height = self.lens.half_height(time_s);
        let half = DVec2::new(half_height * aspect, half_height);
        (half, self.shift * 2.0 * half.max_element())
    }

    /// OpenGL's projection of camera space, except for depth: clipping planes may be infinitely far away, so
    /// the third row gives the distance along the view axis.
    pub fn projection(&self, aspect: f64, time_s: f64) -> DMat4 {
        let (half, middle) = self.picture(aspect, time_s);
        let (scale, offset) = (half.recip(), middle / half);
        let depth = DVec4::new(0.0, 0.0, -1.0, 0.0);
        let rows = match self.lens {
            Lens::Perspective { .. } => [
                DVec4::new(scale.x, 0.0, offset.x, 0.0),
                DVec4::new(0.0, scale.y, offset.y, 0.0),
                depth,
                depth,
            ],
            Lens::Orthographic { .. } => [
                DVec4::new(scale.x, 0.0, 0.0, -offset.x),
                DVec4::new(0.0, scale.y, 0.0, -offset.y),
                depth,
                DVec4::W,
            ],
        };
        DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
    }
}
