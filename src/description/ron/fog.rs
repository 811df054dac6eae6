//! Fog of a scene file. In goes RON, out come fog volumes. Invariant: docs/scene-format.md describes every
//! field.

use super::animated::Animated;
use super::defaults::one;
use super::mist::Mist;
use super::number::{Anisotropy, Finite, NonNegative, Number, Point, Positive, Triple, UnitInterval};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Fog volume: in a box, thinner with height, or both; or with the density of voxels.
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
    /// Height over which its density falls to 1/e.
    pub scale_height_m: Option<Animated<Number<Positive>>>,
    /// Base of the falloff: a y coordinate of its parent's space.
    pub base_m: Option<Number<Finite>>,
    /// OpenVDB file with its density, in its parent's space.
    pub vdb: Option<PathBuf>,
    /// Name of the file's density grid [default: `density`].
    pub grid: Option<String>,
    /// Name of the file's grid of colours that multiply its albedo.
    pub albedo_grid: Option<String>,
    /// Name of the file's grid of emission.
    pub emission_grid: Option<String>,
    /// Emission where that grid is 1.
    pub emission_w_per_m3_sr: Option<Animated<Triple<NonNegative>>>,
    /// Temperature where that grid is 1, in kelvin: emission is that of a black body, relative to its
    /// luminance there.
    pub emission_kelvin: Option<Number<Positive>>,
    /// Drifting mist in its box.
    pub mist: Option<Mist>,
    /// Extinction coefficient sigma_t where the fog is densest; for voxels, where they are 1.
    pub density_per_m: Animated<Triple<NonNegative>>,
    /// Single-scattering albedo.
    #[serde(default = "one")]
    pub albedo: Animated<Triple<UnitInterval>>,
    /// Henyey-Greenstein g; positive is forward.
    #[serde(default)]
    pub anisotropy: Animated<Number<Anisotropy>>,
}

impl Fog {
    /// Creates grey fog in a box from its extinction per metre. It absorbs nothing and scatters
    /// isotropically.
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
