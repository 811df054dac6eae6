//! Fog of a scene. Invariant: docs/scene-format.md describes every field.

use super::animated::Animated;
use super::defaults::one;
use super::mist::Mist;
use super::number::{Anisotropy, Finite, NonNegative, Number, Point, Positive, Triple, UnitInterval};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A bank of fog: in a box, thinner with height, or both; or as dense as voxels are.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Fog {
    /// Name of the object that the fog follows.
    pub parent: Option<String>,
    /// The corner of its box with the smallest coordinates, in its parent's space.
    pub min_m: Option<Point>,
    /// The corner with the largest coordinates.
    pub max_m: Option<Point>,
    /// The height over which its density falls to 1/e.
    pub scale_height_m: Option<Animated<Number<Positive>>>,
    /// Base of the falloff: a y coordinate of its parent's space.
    pub base_m: Option<Number<Finite>>,
    /// An OpenVDB file that says how dense it is, in its parent's space.
    pub vdb: Option<PathBuf>,
    /// The file's grid that does [default: `density`].
    pub grid: Option<String>,
    /// The file's grid of colours that its albedo is multiplied by.
    pub albedo_grid: Option<String>,
    /// The file's grid that shines.
    pub emission_grid: Option<String>,
    /// Emission where that grid is 1.
    pub emission_w_per_m3_sr: Option<Animated<Triple<NonNegative>>>,
    /// So many kelvin it has there: it shines as a black body, in proportion to one of these.
    pub emission_kelvin: Option<Number<Positive>>,
    /// Billows that it is made of, in its box.
    pub mist: Option<Mist>,
    /// Extinction coefficient sigma_t where the fog is densest; of voxels that of 1 in them.
    pub density_per_m: Animated<Triple<NonNegative>>,
    /// Share of the extinction that is scattering.
    #[serde(default = "one")]
    pub albedo: Animated<Triple<UnitInterval>>,
    /// Henyey-Greenstein g; forward if positive.
    #[serde(default)]
    pub anisotropy: Animated<Number<Anisotropy>>,
}

impl Fog {
    /// Grey fog in a box, of an extinction a metre; it scatters all that it takes, to all sides alike.
    pub fn in_box(min_m: impl Into<Point>, max_m: impl Into<Point>, density_per_m: f64) -> Self {
        Self {
            parent: None,
            min_m: Some(min_m.into()),
            max_m: Some(max_m.into()),
            scale_height_m: None,
            base_m: None,
            vdb: None,
            grid: None,
            albedo_grid: None,
            emission_grid: None,
            emission_w_per_m3_sr: None,
            emission_kelvin: None,
            mist: None,
            density_per_m: density_per_m.into(),
            albedo: one(),
            anisotropy: Animated::default(),
        }
    }
}
