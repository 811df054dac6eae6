//! Lights, for programs that make scenes. In go numbers, out come the fields of a file. Invariant: names,
//! units and ranges are those of docs/scene-format.md; there is one of each kind that files have.

use super::animated::Animated;
use serde::Serialize;
use std::path::PathBuf;

/// A light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Light {
    /// Light from infinitely far away.
    Sun(Sun),
    /// Light from a point or sphere to all sides.
    Point {
        /// Name of the object that the light follows.
        #[serde(skip_serializing_if = "Option::is_none")]
        parent: Option<String>,
        /// Where it is in its parent's space.
        position_m: Animated<[f64; 3]>,
        /// In every direction, seen from afar.
        intensity_w_per_sr: Animated<[f64; 3]>,
        /// Of the sphere that shines; 0 is a point.
        radius_m: Animated<f64>,
    },
    /// Light from a point or sphere into a cone.
    Spot {
        /// Name of the object that the light follows.
        #[serde(skip_serializing_if = "Option::is_none")]
        parent: Option<String>,
        /// Where it is in its parent's space.
        position_m: Animated<[f64; 3]>,
        /// Where it points.
        target_m: Animated<[f64; 3]>,
        /// Between the axis and the edge of the cone.
        outer_deg: Animated<f64>,
        /// Softness of the edge, `0..=1`.
        blend: Animated<f64>,
        /// On the axis, seen from afar.
        intensity_w_per_sr: Animated<[f64; 3]>,
        /// Of the sphere that shines; 0 is a point.
        radius_m: Animated<f64>,
    },
    /// A flat rectangle that shines from one side.
    Rectangle {
        /// Name of the object that the light follows.
        #[serde(skip_serializing_if = "Option::is_none")]
        parent: Option<String>,
        /// Where its middle is in its parent's space.
        position_m: Animated<[f64; 3]>,
        /// Where it faces.
        target_m: Animated<[f64; 3]>,
        /// The way its height goes.
        up: [f64; 3],
        /// Across.
        width_m: Animated<f64>,
        /// Along `up`.
        height_m: Animated<f64>,
        /// All light that it emits.
        power_w: Animated<[f64; 3]>,
    },
    /// A flat disc that shines from one side.
    Disc {
        /// Name of the object that the light follows.
        #[serde(skip_serializing_if = "Option::is_none")]
        parent: Option<String>,
        /// Where its middle is in its parent's space.
        position_m: Animated<[f64; 3]>,
        /// Where it faces.
        target_m: Animated<[f64; 3]>,
        /// Of the disc.
        diameter_m: Animated<f64>,
        /// All light that it emits.
        power_w: Animated<[f64; 3]>,
    },
}

/// Light from infinitely far away: parallel, or from a disc.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sun {
    /// Name of the object whose rotation the light follows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Where the light comes from.
    pub to_sun: Animated<[f64; 3]>,
    /// On a plane perpendicular to the light.
    pub irradiance_w_per_m2: Animated<[f64; 3]>,
    /// The whole angle under which its disc is seen; 0 is parallel light.
    pub angular_diameter_deg: Animated<f64>,
    /// How much darker the disc is towards its edge, `0..=1`.
    pub limb_darkening: f64,
    /// A PNG, JPEG, WebP or PPM image on the disc.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image: Option<PathBuf>,
    /// A fractal on the disc; not beside `image`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fractal: Option<Julia>,
    /// How far image or fractal are turned anticlockwise.
    pub picture_rotation_deg: Animated<f64>,
    /// Whether camera and mirrors see the disc.
    pub visible_to_camera: bool,
}

/// The Julia set of `z^2 + c`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Julia {
    /// Real part of `c`.
    pub real: Animated<f64>,
    /// Imaginary part of `c`.
    pub imaginary: Animated<f64>,
    /// After so many a point counts as one that never escapes, `1..=1000`.
    pub iterations: u32,
}

impl Default for Sun {
    /// One watt a square metre from straight above, parallel.
    fn default() -> Self {
        Self {
            parent: None,
            to_sun: [0.0, 1.0, 0.0].into(),
            irradiance_w_per_m2: [1.0; 3].into(),
            angular_diameter_deg: 0.0.into(),
            limb_darkening: 0.0,
            image: None,
            fractal: None,
            picture_rotation_deg: 0.0.into(),
            visible_to_camera: false,
        }
    }
}
