//! Cameras and lights in glTF's terms. In go validated numbers, out come typed values. Invariant: every
//! number is in glTF's range.

use glam::DVec3;
use serde_json::Value;

/// A camera; looks along its node's -Z.
#[derive(Clone, Debug)]
pub struct Camera {
    /// The author's name, else `camera N`.
    pub name: String,
    /// Projection.
    pub lens: Lens,
    /// Clipping distances along the view axis, metres: the nearer 0 or more, the farther beyond it or
    /// infinite.
    pub clip_m: (f64, f64),
    /// Custom properties.
    pub extras: Value,
}

/// The two kinds of camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// A pinhole.
    Perspective {
        /// Full vertical angle, radians, in `(0, pi)`.
        fov_y: f64,
        /// Width over height, if given, > 0.
        aspect: Option<f64>,
    },
    /// Parallel rays.
    Orthographic {
        /// Half the picture's width, metres, > 0.
        half_width: f64,
        /// Half the picture's height, metres, > 0.
        half_height: f64,
    },
}

impl Lens {
    /// Width over height of the picture, if given.
    pub fn aspect(&self) -> Option<f64> {
        match *self {
            Self::Perspective { aspect, .. } => aspect,
            Self::Orthographic { half_width, half_height } => Some(half_width / half_height),
        }
    }
}

/// A light; shines along its node's -Z.
#[derive(Clone, Debug)]
pub struct Light {
    /// The author's name, else `light N`.
    pub name: String,
    /// Linear.
    pub color: DVec3,
    /// Intensity in the file's units, >= 0.
    pub intensity: f64,
    /// Distance beyond which it has no light, metres.
    pub range_m: Option<f64>,
    /// Kind, and its shape.
    pub kind: LightKind,
    /// Custom properties.
    pub extras: Value,
}

/// The kinds of KHR_lights_punctual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light.
    Directional,
    /// A point that shines in all directions.
    Point,
    /// A point that shines within a cone; `0 <= inner <= outer <= pi/2`, `outer` more than 0.
    Spot {
        /// Half angle of full intensity, radians.
        inner_angle: f64,
        /// Half angle beyond which there is no light, radians.
        outer_angle: f64,
    },
}
