//! Lights: a node, a colour and a kind. Invariant: a light shines along its node's -Z
//! (glTF and Blender); intensities are radiometric, per channel, never photometric.
//!
//! To add a light: a variant here, its reading in `from_ron` and `from_gltf`, its frozen form in
//! `snapshot`, and its two answers in `transport`: light on a surface and light in fog along a ray.

use super::{NodeIndex, Track};
use crate::color::Rgb;

/// A light at a node.
#[derive(Clone, Debug)]
pub struct Light {
    /// The author's name.
    pub name: String,
    /// Where it is and where it points.
    pub node: NodeIndex,
    /// Sun: irradiance on a perpendicular plane, W/m^2. Point and spot: intensity, W/sr.
    pub power: Track<Rgb>,
    /// What shape it has.
    pub kind: LightKind,
}

/// The closed set of lights.
#[derive(Clone, Debug)]
pub enum LightKind {
    /// Parallel light from infinitely far away.
    Sun,
    /// The same intensity in all directions from one point.
    Point,
    /// A point with a soft-edged cone.
    Spot {
        /// Half angle beyond which there is no light, radians, in `(0, pi/2]`.
        outer_angle: Track<f64>,
        /// Blender's edge softness, `0..=1`: 1 - inner/outer angle.
        blend: Track<f64>,
    },
}
