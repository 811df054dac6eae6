//! Linear RGB colours. In goes linear or sRGB-encoded light, out comes the other. Invariant: every colour
//! inside the renderer is linear Rec. 709; only textures and pictures for viewing use the sRGB curve.

mod agx;
mod blackbody;
mod display;
mod look;
mod primaries;
mod space;
mod texels;

use glam::DVec3;

pub use blackbody::Blackbody;
pub use display::{Bloom, Curve, Display, dithered};
pub use look::Look;
pub use primaries::Primaries;
pub use space::{ColorSpace, NamedSpace};
pub use texels::{CodeCurve, Texels};

/// Linear Rec. 709 colour: `x` red, `y` green, `z` blue.
///
/// Reflectances are in `0..=1`, radiances in W m^-2 sr^-1, irradiances in W m^-2, intensities in W/sr.
pub type Rgb = DVec3;

/// Luminous efficacy in lumens a watt of any colour, as Blender and glTF importers use it.
pub const LUMENS_PER_WATT: f64 = 683.0;

/// Weights of red, green and blue in luminance (ITU-R BT.709, item 3.2).
const LUMINANCES: Rgb = DVec3::new(0.2126, 0.7152, 0.0722);

/// Relative luminance of a linear Rec. 709 colour.
pub fn luminance(color: Rgb) -> f64 {
    color.dot(LUMINANCES)
}

/// Decodes one sRGB value in `0..=1` to linear light (IEC 61966-2-1).
pub fn linear_from_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// Encodes one linear value in `0..=1` with the sRGB curve (IEC 61966-2-1).
pub fn srgb_from_linear(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn srgb_curve_is_its_own_inverse() {
        for step in 0..=1000 {
            let value = f64::from(step) / 1000.0;
            assert!((linear_from_srgb(srgb_from_linear(value)) - value).abs() < 1e-7);
        }
    }

    #[test]
    fn white_has_luminance_one() {
        assert!((luminance(Rgb::ONE) - 1.0).abs() < 1e-12);
    }
}
