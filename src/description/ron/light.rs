//! Lights of a scene file. In goes RON, out come lights. Invariant: docs/scene-format.md describes every
//! field.

use super::animated::Animated;
use super::defaults::one;
use super::number::{
    Degrees, Direction, DiscAngle, HalfAngle, JuliaPart, NonNegative, Number, Point, Positive, Triple,
    UnitInterval, Whole,
};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A light.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum Light {
    /// Light from infinitely far away.
    Sun(Sun),
    /// Light from a point or sphere to all sides.
    #[non_exhaustive]
    Point {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Position in its parent's space.
        position_m: Animated<Point>,
        /// Intensity in every direction, from afar.
        intensity_w_per_sr: Animated<Triple<NonNegative>>,
        /// Radius of the emitting sphere; 0 is a point.
        #[serde(default)]
        radius_m: Animated<Number<NonNegative>>,
    },
    /// Light from a point or sphere into a cone.
    #[non_exhaustive]
    Spot {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Position in its parent's space.
        position_m: Animated<Point>,
        /// Target that it points at.
        target_m: Animated<Point>,
        /// Angle between the axis and the edge of the cone.
        outer_deg: Animated<Number<HalfAngle>>,
        /// Softness of the edge, as in Blender.
        #[serde(default = "soft_edge")]
        blend: Animated<Number<UnitInterval>>,
        /// Intensity on the axis, from afar.
        intensity_w_per_sr: Animated<Triple<NonNegative>>,
        /// Radius of the emitting sphere; 0 is a point.
        #[serde(default)]
        radius_m: Animated<Number<NonNegative>>,
    },
    /// A flat rectangle that emits from one side.
    #[non_exhaustive]
    Rectangle {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Position of its centre in its parent's space.
        position_m: Animated<Point>,
        /// Target that it faces.
        target_m: Animated<Point>,
        /// Direction of its height.
        #[serde(default = "up")]
        up: Direction,
        /// Width.
        width_m: Animated<Number<Positive>>,
        /// Height, along `up`.
        height_m: Animated<Number<Positive>>,
        /// Radiant power.
        power_w: Animated<Triple<NonNegative>>,
    },
    /// A flat disc that emits from one side.
    #[non_exhaustive]
    Disc {
        /// Name of the object that the light follows.
        parent: Option<String>,
        /// Position of its centre in its parent's space.
        position_m: Animated<Point>,
        /// Target that it faces.
        target_m: Animated<Point>,
        /// Diameter of the disc.
        diameter_m: Animated<Number<Positive>>,
        /// Radiant power.
        power_w: Animated<Triple<NonNegative>>,
    },
}

impl Light {
    /// Creates a lamp without extent, which lights all sides alike.
    pub fn point(
        position_m: impl Into<Animated<Point>>,
        intensity_w_per_sr: impl Into<Animated<Triple<NonNegative>>>,
    ) -> Self {
        Self::Point {
            parent: None,
            position_m: position_m.into(),
            intensity_w_per_sr: intensity_w_per_sr.into(),
            radius_m: Animated::default(),
        }
    }

    /// Creates a spot without extent, with a soft edge.
    pub fn spot(
        position_m: impl Into<Animated<Point>>,
        target_m: impl Into<Animated<Point>>,
        outer_deg: impl Into<Animated<Number<HalfAngle>>>,
        intensity_w_per_sr: impl Into<Animated<Triple<NonNegative>>>,
    ) -> Self {
        Self::Spot {
            parent: None,
            position_m: position_m.into(),
            target_m: target_m.into(),
            outer_deg: outer_deg.into(),
            blend: soft_edge(),
            intensity_w_per_sr: intensity_w_per_sr.into(),
            radius_m: Animated::default(),
        }
    }

    /// Creates an upright rectangle, by its width and height.
    pub fn rectangle(
        position_m: impl Into<Animated<Point>>,
        target_m: impl Into<Animated<Point>>,
        [width_m, height_m]: [f64; 2],
        power_w: impl Into<Animated<Triple<NonNegative>>>,
    ) -> Self {
        Self::Rectangle {
            parent: None,
            position_m: position_m.into(),
            target_m: target_m.into(),
            up: up(),
            width_m: width_m.into(),
            height_m: height_m.into(),
            power_w: power_w.into(),
        }
    }

    /// Creates a disc.
    pub fn disc(
        position_m: impl Into<Animated<Point>>,
        target_m: impl Into<Animated<Point>>,
        diameter_m: impl Into<Animated<Number<Positive>>>,
        power_w: impl Into<Animated<Triple<NonNegative>>>,
    ) -> Self {
        Self::Disc {
            parent: None,
            position_m: position_m.into(),
            target_m: target_m.into(),
            diameter_m: diameter_m.into(),
            power_w: power_w.into(),
        }
    }
}

/// Light from infinitely far away: parallel, or from a disc. It has one of `direction` and `to_sun`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Sun {
    /// Name of the object whose rotation the light follows.
    pub parent: Option<String>,
    /// Direction in which the light travels; excludes `to_sun`.
    pub direction: Option<Animated<Direction>>,
    /// Direction to the sun.
    pub to_sun: Option<Animated<Direction>>,
    /// Irradiance on a plane perpendicular to the light.
    pub irradiance_w_per_m2: Animated<Triple<NonNegative>>,
    /// Full angle of its disc; 0 is parallel light.
    #[serde(default)]
    pub angular_diameter_deg: Animated<Number<DiscAngle>>,
    /// Darkening of the disc towards its edge.
    #[serde(default)]
    pub limb_darkening: Number<UnitInterval>,
    /// A PNG, JPEG, WebP or PPM image on the disc, relative to the scene file.
    pub image: Option<PathBuf>,
    /// A fractal on the disc.
    pub fractal: Option<Julia>,
    /// Rotation of image or fractal, anticlockwise.
    #[serde(default)]
    pub picture_rotation_deg: Animated<Number<Degrees>>,
    /// Whether camera and mirrors see the disc.
    #[serde(default)]
    pub visible_to_camera: bool,
}

impl Default for Sun {
    /// Parallel light of 1 W/m² from straight above. [`Sun::with`] turns it by `to_sun`.
    fn default() -> Self {
        Self {
            parent: None,
            direction: None,
            to_sun: Some([0.0, 1.0, 0.0].into()),
            irradiance_w_per_m2: one(),
            angular_diameter_deg: Animated::default(),
            limb_darkening: Number::default(),
            image: None,
            fractal: None,
            picture_rotation_deg: Animated::default(),
            visible_to_camera: false,
        }
    }
}

/// The Julia set of `z^2 + c`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Julia {
    /// Real part of `c`.
    pub real: Animated<Number<JuliaPart>>,
    /// Imaginary part of `c`.
    pub imaginary: Animated<Number<JuliaPart>>,
    /// Maximum number of iterations: points that have not escaped by then count as inside.
    #[serde(default = "hundred")]
    pub iterations: Whole<1, 1000>,
}

impl Julia {
    /// Creates a set with 100 iterations.
    pub fn new(
        real: impl Into<Animated<Number<JuliaPart>>>,
        imaginary: impl Into<Animated<Number<JuliaPart>>>,
    ) -> Self {
        Self { real: real.into(), imaginary: imaginary.into(), iterations: hundred() }
    }
}

fn up() -> Direction {
    [0.0, 1.0, 0.0].into()
}

fn hundred() -> Whole<1, 1000> {
    Whole(100)
}

fn soft_edge() -> Animated<Number<UnitInterval>> {
    0.15.into()
}
