//! Sky of a scene file. Invariant: every field's unit is in its name.

use super::animated::Animated;
use super::defaults::one;
use super::number::{Degrees, NonNegative, Number, Triple};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Sky behind the scene, which lights it.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub enum Sky {
    /// Uniform.
    Constant {
        /// Radiance.
        radiance_w_per_m2_sr: Animated<Triple<NonNegative>>,
        /// Things that it lights.
        #[serde(default)]
        lights: SkyLight,
    },
    /// Gradient from the horizon up, and one colour below.
    Gradient {
        /// Straight up.
        zenith_w_per_m2_sr: Triple<NonNegative>,
        /// Just above the horizon.
        horizon_w_per_m2_sr: Triple<NonNegative>,
        /// Below the horizon.
        #[serde(default)]
        ground_w_per_m2_sr: Triple<NonNegative>,
        /// Multiplies all of it.
        #[serde(default = "one")]
        strength: Animated<Triple<NonNegative>>,
        /// Things that it lights.
        #[serde(default)]
        lights: SkyLight,
    },
    /// An image of all directions.
    Image {
        /// Radiance HDR or OpenEXR, longitude across and latitude down, relative to the scene file.
        image: PathBuf,
        /// Radiance of what is 1 in the image.
        #[serde(default = "one")]
        strength_w_per_m2_sr: Animated<Triple<NonNegative>>,
        /// Turned about +y, anticlockwise as seen from above.
        #[serde(default)]
        rotation_deg: Animated<Number<Degrees>>,
        /// Things that it lights.
        #[serde(default)]
        lights: SkyLight,
    },
}

/// Things that a sky lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum SkyLight {
    /// It is seen, and lights nothing.
    Nothing,
    /// Surfaces.
    Surfaces,
    /// Surfaces and fog.
    #[default]
    SurfacesAndFog,
}
