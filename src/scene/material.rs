//! What surfaces are made of. Invariant: `base_color + mirror <= 1` per channel, so no surface
//! returns more than it receives.

use super::TextureIndex;
use crate::color::Rgb;

/// A two-sided surface: Lambert, mirror and emission added up.
#[derive(Clone, Debug)]
pub struct Material {
    /// The author's name.
    pub name: String,
    /// Lambert reflectance, `0..=1`; multiplied by the texture if there is one.
    pub base_color: Rgb,
    /// Image whose colour multiplies `base_color`.
    pub base_color_texture: Option<TextureIndex>,
    /// Perfect mirror reflectance, `0..=1`.
    pub mirror: Rgb,
    /// Radiance emitted to either side, W m^-2 sr^-1.
    pub emission: Rgb,
    /// What the author asked of the alpha channel. Recognised; surfaces are rendered opaque.
    pub alpha_mode: AlphaMode,
}

/// glTF's alpha modes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// Visible where alpha >= cutoff.
    Mask {
        /// In `0..=1`.
        cutoff: f64,
    },
    /// Blended over what lies behind.
    Blend,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::from("default"),
            base_color: Rgb::splat(0.8),
            base_color_texture: None,
            mirror: Rgb::ZERO,
            emission: Rgb::ZERO,
            alpha_mode: AlphaMode::Opaque,
        }
    }
}
