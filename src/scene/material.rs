//! What surfaces are made of. Invariant: `base_color + transmission + mirror + filter_color <= 1` per
//! channel, so no surface gives more than it receives.

use super::TextureIndex;
use crate::color::Rgb;

/// A two-sided surface: Lambert to the near and to the far side, mirror and emission added up, perhaps
/// under a coat.
#[derive(Clone, Debug)]
pub struct Material {
    /// The author's name.
    pub name: String,
    /// Lambert reflectance, `0..=1`; multiplied by the texture if there is one.
    pub base_color: Rgb,
    /// Image whose colour multiplies `base_color`; looked up with the first texture coordinates.
    pub base_color_texture: Option<TextureIndex>,
    /// Lambert transmittance, `0..=1`: what comes out, diffuse, on the side that the light does not
    /// fall on.
    pub transmission: Rgb,
    /// Image whose colour multiplies `transmission`.
    pub transmission_texture: Option<TextureMap>,
    /// Perfect mirror reflectance, `0..=1`.
    pub mirror: Rgb,
    /// Radiance emitted to either side, W m^-2 sr^-1.
    pub emission: Rgb,
    /// Image whose colour multiplies `emission`.
    pub emission_texture: Option<TextureMap>,
    /// What makes it shine, or a metal; without one it is matte.
    pub coat: Option<Coat>,
    /// Image of directions that bend the normal, and how much of their bending counts.
    pub normal_map: Option<(TextureMap, f64)>,
    /// What alpha, `opacity` times that of the texture, does.
    pub alpha_mode: AlphaMode,
    /// Alpha, `0..=1`; multiplied by the texture's if there is one.
    pub opacity: f64,
    /// Share of light that goes straight through where alpha is 1, `0..=1`.
    pub filter_color: Rgb,
}

/// An image and the texture coordinates that it is looked up with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureMap {
    /// Which.
    pub texture: TextureIndex,
    /// 0 is [`super::Mesh::uvs`], the others are [`super::Mesh::more_uvs`].
    pub layer: usize,
}

/// glTF's metallic-roughness model (`scattering::Gloss`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    /// How much of a metal it is, `0..=1`: metals reflect `base_color` in the coat and nothing beneath it.
    pub metallic: f64,
    /// `0..=1`; glTF's roughness, the square root of its alpha.
    pub roughness: f64,
    /// Image whose blue multiplies `metallic` and whose green `roughness`.
    pub texture: Option<TextureMap>,
    /// Reflectance along the normal of what is no metal, `0..=1`.
    pub f0: Rgb,
    /// The same at grazing angles.
    pub f90: f64,
}

/// glTF's alpha modes; what a mask hides is cut out of the mesh instead (`scene/outline`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// The share `1 - alpha + alpha * filter_color` of what lies behind shows, and the share alpha of the surface.
    Blend,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::from("default"),
            base_color: Rgb::splat(0.8),
            base_color_texture: None,
            transmission: Rgb::ZERO,
            transmission_texture: None,
            mirror: Rgb::ZERO,
            emission: Rgb::ZERO,
            emission_texture: None,
            coat: None,
            normal_map: None,
            alpha_mode: AlphaMode::Opaque,
            opacity: 1.0,
            filter_color: Rgb::ZERO,
        }
    }
}
