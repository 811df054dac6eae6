//! Lights: a node, a colour and a kind. In go validated parameters, out come lights. Invariants: a light
//! emits along its node's -Z (glTF and Blender). Powers are radiometric, per channel, never photometric.
//!
//! A new light needs a variant here, readers in `from_ron` and `from_gltf`, and its frozen form in
//! `snapshot`: a distribution over the two kinds of light without extent that `transport` supports.

use super::{NodeIndex, SunPicture, SunShows, Track};
use crate::color::Rgb;
use std::f64::consts::PI;

/// A light at a node.
#[derive(Clone, Debug)]
pub struct Light {
    /// The author's name.
    pub name: String,
    /// Node of its position and direction.
    pub node: NodeIndex,
    /// Power. For a sun: irradiance on a perpendicular plane, W/m^2. For points, spheres and spots:
    /// intensity, W/sr, from afar. For an area light: radiant power, W.
    pub power: Track<Rgb>,
    /// Kind, and its shape.
    pub kind: LightKind,
}

/// Kind of a light.
#[derive(Clone, Debug)]
pub enum LightKind {
    /// Parallel light from infinitely far away.
    Sun,
    /// A disc infinitely far away.
    SunDisc(SunDisc),
    /// A point with the same intensity in all directions.
    Point,
    /// A sphere of uniform radiance.
    Sphere {
        /// Metres, whatever the node's scale.
        radius: Track<f64>,
    },
    /// A point or sphere with a cone of soft edges.
    Spot {
        /// Half angle beyond which there is no light, radians, in `(0, pi/2]`.
        outer_angle: Track<f64>,
        /// Blender's edge softness, `0..=1`: 1 - inner/outer angle.
        blend: Track<f64>,
        /// Radius of the sphere, metres, whatever the node's scale; 0 is a point.
        radius: Track<f64>,
    },
    /// A flat light of uniform radiance, from one side; with a spread, from a limited range of directions.
    Area {
        /// Outline.
        shape: AreaShape,
        /// Along the node's x axis, metres before the node's scale.
        width: Track<f64>,
        /// Along the node's y axis, metres before the node's scale.
        height: Track<f64>,
        /// Blender's *Spread*: the full angle of a grid before the light, radians in `(0, pi]`. With pi there
        /// is no grid. The power stays the same.
        spread: Track<f64>,
    },
}

/// Outline of a flat light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaShape {
    /// A rectangle as wide and as high as the light.
    Rectangle,
    /// The ellipse within that rectangle.
    Ellipse,
}

/// Sun with a visible disc.
#[derive(Clone, Debug)]
pub struct SunDisc {
    /// Full angle of the disc, radians, in `[0, pi)`.
    pub angular_diameter: Track<f64>,
    /// Picture on the disc; without one its radiance is uniform.
    pub picture: Option<SunPicture>,
    /// Rotation of the picture, anticlockwise, radians.
    pub picture_rotation: Track<f64>,
    /// Whether rays that leave the scene within the disc see it.
    pub visible_to_camera: bool,
}

impl SunDisc {
    /// Creates a disc of uniform radiance that only lights.
    pub fn even(angular_diameter: Track<f64>) -> Self {
        Self { angular_diameter, picture: None, picture_rotation: Track::from(0.0), visible_to_camera: false }
    }
}

impl LightKind {
    /// All parameters that may be keyed, with their names in `sunfleck_light`.
    pub fn numbers(&self) -> Vec<(&'static str, &Track<f64>)> {
        match self {
            Self::Sun | Self::Point => vec![],
            Self::SunDisc(disc) => {
                let mut numbers = vec![("angle", &disc.angular_diameter)];
                if let Some(picture) = &disc.picture {
                    numbers.push(("picture_rotation", &disc.picture_rotation));
                    if let SunShows::Julia(julia) = picture.shows() {
                        numbers
                            .extend([("fractal_real", &julia.real), ("fractal_imaginary", &julia.imaginary)]);
                    }
                }
                numbers
            }
            Self::Sphere { radius } => vec![("radius", radius)],
            Self::Spot { outer_angle, blend, radius } => {
                vec![("outer_angle", outer_angle), ("blend", blend), ("radius", radius)]
            }
            Self::Area { width, height, spread, .. } => {
                vec![("width", width), ("height", height), ("spread", spread)]
            }
        }
    }

    /// Name of its power in `sunfleck_light`, in Blender's units, and Blender's value over this one.
    pub(crate) fn blenders_power(&self) -> (&'static str, f64) {
        match self {
            Self::Sun | Self::SunDisc(_) => ("strength_w_m2", 1.0),
            Self::Point | Self::Sphere { .. } | Self::Spot { .. } => ("power_w", 4.0 * PI),
            Self::Area { .. } => ("power_w", 1.0),
        }
    }
}
