//! Materials of a scene file. In goes RON, out come materials. Invariant: docs/scene-format.md describes
//! every field.

use super::defaults::one;
use super::number::{Finite, NonNegative, Number, Triple, UnitInterval};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Material of a surface.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Material {
    /// Lambert reflectance, linear Rec. 709, multiplied by the texture; 0.8 by default, or 1 with a texture.
    pub base_color: Option<Triple<UnitInterval>>,
    /// A PNG, JPEG, WebP or PPM image in sRGB, relative to the scene file.
    pub texture: Option<PathBuf>,
    /// Alpha, multiplied by the texture's.
    pub opacity: Option<Number<UnitInterval>>,
    /// Alpha below which the surface is cut away.
    pub alpha_cutoff: Option<Number<UnitInterval>>,
    /// Share of light that goes straight through where alpha is 1.
    pub filter_color: Option<Triple<UnitInterval>>,
    /// Lambert transmittance to the far side, multiplied by its texture, or else by `texture`.
    pub transmission: Triple<UnitInterval>,
    /// Image of the transmitted colours, in place of `texture`.
    pub transmission_texture: Option<PathBuf>,
    /// Normal map.
    pub normal_map: Option<NormalMap>,
    /// Roughness of the coat; without it the surface is matte.
    pub roughness: Option<Number<UnitInterval>>,
    /// Share of metal.
    pub metallic: Option<Number<UnitInterval>>,
    /// Perfect mirror reflectance.
    pub mirror: Triple<UnitInterval>,
    /// Radiance emitted to either side.
    pub emission_w_per_m2_sr: Option<Triple<NonNegative>>,
}

impl Material {
    /// Lambert reflectance alone, linear Rec. 709.
    pub fn matte(base_color: impl Into<Triple<UnitInterval>>) -> Self {
        Self { base_color: Some(base_color.into()), ..Self::default() }
    }
}

/// Normal map, as in glTF.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct NormalMap {
    /// A PNG, JPEG, WebP or PPM image whose red, green and blue are x, y and z, from -1 to 1.
    pub texture: PathBuf,
    /// Factor on x and y.
    #[serde(default = "one")]
    pub scale: Number<Finite>,
}

impl NormalMap {
    /// Creates a normal map with scale 1.
    pub fn new(texture: impl Into<PathBuf>) -> Self {
        Self { texture: texture.into(), scale: one() }
    }
}
