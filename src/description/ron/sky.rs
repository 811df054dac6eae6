//! Sky of a scene file. In goes RON, out comes a sky. Invariant: every field's unit is in its name.

use super::animated::Animated;
use super::defaults::one;
use super::number::{Degrees, NonNegative, Number, Triple};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Sky, seen behind the scene, which it lights.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum Sky {
    /// Uniform.
    #[non_exhaustive]
    Constant {
        /// Radiance.
        radiance_w_per_m2_sr: Animated<Triple<NonNegative>>,
        /// Contents of the scene that it lights.
        #[serde(default)]
        lights: SkyLight,
    },
    /// Gradient from the horizon up, and one colour below.
    #[non_exhaustive]
    Gradient {
        /// Radiance at the zenith.
        zenith_w_per_m2_sr: Triple<NonNegative>,
        /// Radiance just above the horizon.
        horizon_w_per_m2_sr: Triple<NonNegative>,
        /// Radiance below the horizon.
        #[serde(default)]
        ground_w_per_m2_sr: Triple<NonNegative>,
        /// Factor on the whole sky.
        #[serde(default = "one")]
        strength: Animated<Triple<NonNegative>>,
        /// Contents of the scene that it lights.
        #[serde(default)]
        lights: SkyLight,
    },
    /// An image of all directions.
    #[non_exhaustive]
    Image {
        /// Radiance HDR or OpenEXR, longitude across and latitude down, relative to the scene file.
        image: PathBuf,
        /// Radiance where the image is 1.
        #[serde(default = "one")]
        strength_w_per_m2_sr: Animated<Triple<NonNegative>>,
        /// Rotation about +y, anticlockwise from above.
        #[serde(default)]
        rotation_deg: Animated<Number<Degrees>>,
        /// Contents of the scene that it lights.
        #[serde(default)]
        lights: SkyLight,
    },
}

impl Sky {
    /// Creates a uniform sky.
    pub fn constant(radiance_w_per_m2_sr: impl Into<Animated<Triple<NonNegative>>>) -> Self {
        Self::Constant { radiance_w_per_m2_sr: radiance_w_per_m2_sr.into(), lights: SkyLight::default() }
    }

    /// Creates a gradient from the horizon up, black below.
    pub fn gradient(
        zenith_w_per_m2_sr: impl Into<Triple<NonNegative>>,
        horizon_w_per_m2_sr: impl Into<Triple<NonNegative>>,
    ) -> Self {
        Self::Gradient {
            zenith_w_per_m2_sr: zenith_w_per_m2_sr.into(),
            horizon_w_per_m2_sr: horizon_w_per_m2_sr.into(),
            ground_w_per_m2_sr: Triple::default(),
            strength: one(),
            lights: SkyLight::default(),
        }
    }

    /// Creates an image of all directions, as radiant as it says.
    pub fn image(image: impl Into<PathBuf>) -> Self {
        Self::Image {
            image: image.into(),
            strength_w_per_m2_sr: one(),
            rotation_deg: Animated::default(),
            lights: SkyLight::default(),
        }
    }
}

/// Contents of a scene that a sky lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[non_exhaustive]
pub enum SkyLight {
    /// Nothing; the sky is only seen.
    Nothing,
    /// Surfaces alone.
    Surfaces,
    /// Surfaces and fog.
    #[default]
    SurfacesAndFog,
}
