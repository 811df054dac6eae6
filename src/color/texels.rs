//! Texels of images, stored as in their files. In go codes, out comes linear light. Invariant: lookups equal
//! those of single-precision texels, and memory is that of the codes.

use super::linear_from_srgb;
use glam::{DVec2, DVec4};
use std::sync::LazyLock;

/// Linear RGBA texels, row by row from the top. They compare equal if all lookups are equal.
#[derive(Clone, Debug)]
pub struct Texels {
    stored: Stored,
    /// Whether interpolation mixes sRGB codes, and not light.
    pub(crate) mixes_codes: bool,
}

/// Texels, four numbers each unless they say otherwise.
#[derive(Clone, Debug)]
enum Stored {
    /// 8 bits each; colours become light by `curve`, one value a code. Opaque texels have three numbers.
    Bytes { codes: Vec<u8>, numbers: usize, curve: &'static [f32] },
    /// 16 bits each, likewise, but always four.
    Words { codes: Vec<u16>, curve: &'static [f32] },
    /// Linear light.
    Floats(Vec<[f32; 4]>),
}

/// Encoding of a colour's codes. Alpha is always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodeCurve {
    /// sRGB.
    Srgb,
    /// Fractions of the largest code.
    Linear,
}

static SRGB_WORDS: LazyLock<Vec<f32>> = LazyLock::new(|| curve(u16::MAX, linear_from_srgb));
static LINEAR_WORDS: LazyLock<Vec<f32>> = LazyLock::new(|| curve(u16::MAX, |share| share));
static SRGB_BYTES: LazyLock<Vec<f32>> = LazyLock::new(|| curve(u8::MAX.into(), linear_from_srgb));
static LINEAR_BYTES: LazyLock<Vec<f32>> = LazyLock::new(|| curve(u8::MAX.into(), |share| share));

/// Table of the light of every code up to `largest`.
fn curve(largest: u16, light: impl Fn(f64) -> f64) -> Vec<f32> {
    (0..=largest).map(|code| light(f64::from(code) / f64::from(largest)) as f32).collect()
}

impl Texels {
    fn stored(stored: Stored) -> Self {
        Self { stored, mixes_codes: false }
    }

    /// Interpolates sRGB colours by their codes, as Cycles does (`svm_image_texture` in its
    /// `kernel/svm/image.h` decodes after interpolation). Linear light stays as it is.
    pub fn mix_codes(&mut self) {
        self.mixes_codes = !matches!(self.stored, Stored::Floats(_));
    }

    /// Bilinear interpolation of four texels, row by row, at a fraction of the way from the first to the
    /// last.
    ///
    /// # Panics
    /// If one of them does not exist.
    #[inline]
    pub fn between(&self, indices: [usize; 4], DVec2 { x, y }: DVec2) -> DVec4 {
        let mix = |[a, b, c, d]: [DVec4; 4]| a.lerp(b, x).lerp(c.lerp(d, x), y);
        match &self.stored {
            Stored::Bytes { codes, numbers, .. } if self.mixes_codes => {
                light_of_words(257.0 * mix(indices.map(|index| numbers_of(texel(codes, *numbers, index)))))
            }
            Stored::Words { codes, .. } if self.mixes_codes => {
                light_of_words(mix(indices.map(|index| numbers_of(texel(codes, 4, index)))))
            }
            Stored::Bytes { codes, numbers, curve } => {
                let texel = |index: usize| {
                    let [a, b, c, d] = light(texel(codes, *numbers, index), curve);
                    DVec4::new(a.into(), b.into(), c.into(), d.into())
                };
                let [a, b, c, d] = indices;
                mix([texel(a), texel(b), texel(c), texel(d)])
            }
            _ => mix(indices.map(|index| DVec4::from_array(self.get(index).map(f64::from)))),
        }
    }

    /// The first byte of a texel of bytes.
    pub fn byte(&self, index: usize) -> Option<&u8> {
        match &self.stored {
            Stored::Bytes { codes, numbers, .. } => codes.get(numbers * index),
            _ => None,
        }
    }

    /// Texels from 8 bits a number, four numbers a texel; a rest of fewer is left out.
    pub fn of_bytes(codes: Vec<u8>, curve: CodeCurve) -> Self {
        Self::of_numbers(4, codes, curve)
    }

    /// Opaque texels from 8 bits a number, three numbers a texel.
    pub fn of_opaque_bytes(codes: Vec<u8>, curve: CodeCurve) -> Self {
        Self::of_numbers(3, codes, curve)
    }

    fn of_numbers(numbers: usize, codes: Vec<u8>, curve: CodeCurve) -> Self {
        let curve = match curve {
            CodeCurve::Srgb => SRGB_BYTES.as_slice(),
            CodeCurve::Linear => LINEAR_BYTES.as_slice(),
        };
        Self::stored(Stored::Bytes { codes, numbers, curve })
    }

    /// Creates texels from 16-bit numbers, four a texel; an incomplete last texel is dropped.
    pub fn of_words(codes: Vec<u16>, curve: CodeCurve) -> Self {
        let curve = match curve {
            CodeCurve::Srgb => SRGB_WORDS.as_slice(),
            CodeCurve::Linear => LINEAR_WORDS.as_slice(),
        };
        Self::stored(Stored::Words { codes, curve })
    }

    /// Number of texels.
    pub fn len(&self) -> usize {
        match &self.stored {
            Stored::Bytes { codes, numbers, .. } => codes.len() / numbers,
            Stored::Words { codes, .. } => codes.len() / 4,
            Stored::Floats(texels) => texels.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Linear colour, alpha last.
    ///
    /// # Panics
    /// If there is no such texel.
    #[inline]
    pub fn get(&self, index: usize) -> [f32; 4] {
        match &self.stored {
            Stored::Bytes { codes, numbers, curve } => light(texel(codes, *numbers, index), curve),
            Stored::Words { codes, curve } => light(texel(codes, 4, index), curve),
            Stored::Floats(texels) => texels[index],
        }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = [f32; 4]> + '_ {
        (0..self.len()).map(|index| self.get(index))
    }

    /// Linear colours of all texels in single precision.
    pub fn into_floats(self) -> Vec<[f32; 4]> {
        match self.stored {
            Stored::Floats(texels) => texels,
            _ => self.iter().collect(),
        }
    }
}

fn texel<T>(codes: &[T], numbers: usize, index: usize) -> &[T] {
    &codes[numbers * index..][..numbers]
}

/// Codes of a texel, with the largest for an alpha that it lacks.
#[inline(always)]
fn numbers_of<T: Copy + Into<u16>>(texel: &[T]) -> DVec4 {
    let number = |channel: usize| -> f64 {
        let code: u16 = texel[channel].into();
        code.into()
    };
    let opaque = f64::from(if size_of::<T>() == 1 { u8::MAX.into() } else { u16::MAX });
    DVec4::new(number(0), number(1), number(2), texel.get(3).map_or(opaque, |_| number(3)))
}

/// Light of mixed sRGB codes of 16 bits.
#[inline(always)]
fn light_of_words(codes: DVec4) -> DVec4 {
    let light = |code: f64| f64::from(SRGB_WORDS[code.round() as usize]);
    DVec4::new(light(codes.x), light(codes.y), light(codes.z), codes.w / f64::from(u16::MAX))
}

/// Colour by its curve, alpha as a share of the largest code, which is the curve's last; 1 without alpha.
#[inline(always)]
fn light<T: Copy + Into<u16>>(texel: &[T], curve: &[f32]) -> [f32; 4] {
    let color = |channel: usize| -> f32 {
        let code: u16 = texel[channel].into();
        curve[usize::from(code)]
    };
    let alpha = texel.get(3).map_or(1.0, |&code| {
        let code: u16 = code.into();
        f32::from(code) / (curve.len() - 1) as f32
    });
    [color(0), color(1), color(2), alpha]
}

impl From<Vec<[f32; 4]>> for Texels {
    fn from(texels: Vec<[f32; 4]>) -> Self {
        Self::stored(Stored::Floats(texels))
    }
}

impl IntoIterator for Texels {
    type Item = [f32; 4];
    type IntoIter = std::vec::IntoIter<[f32; 4]>;

    fn into_iter(self) -> Self::IntoIter {
        self.into_floats().into_iter()
    }
}

impl FromIterator<[f32; 4]> for Texels {
    fn from_iter<I: IntoIterator<Item = [f32; 4]>>(texels: I) -> Self {
        Self::stored(Stored::Floats(texels.into_iter().collect()))
    }
}

impl PartialEq for Texels {
    fn eq(&self, other: &Self) -> bool {
        self.mixes_codes == other.mixes_codes && self.iter().eq(other.iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_looked_up_as_the_nearest_single_precision() {
        for (kind, light) in
            [(CodeCurve::Srgb, linear_from_srgb as fn(f64) -> f64), (CodeCurve::Linear, |x| x)]
        {
            for code in 0..=u8::MAX {
                let share = f64::from(code) / 255.0;
                let expected = [light(share) as f32, light(0.0) as f32, light(1.0) as f32, share as f32];
                assert_eq!(Texels::of_bytes(vec![code, 0, 255, code], kind).get(0), expected);
            }
            for code in (0..=u16::MAX).step_by(13) {
                let share = f64::from(code) / 65_535.0;
                let expected = [light(share) as f32, light(0.0) as f32, light(1.0) as f32, share as f32];
                assert_eq!(Texels::of_words(vec![code, 0, u16::MAX, code], kind).get(0), expected);
            }
        }
    }

    #[test]
    fn codes_are_mixed_where_that_is_wanted() {
        let bytes = Texels::of_bytes(vec![0, 0, 0, 0, 255, 255, 255, 255], CodeCurve::Srgb);
        let words =
            Texels::of_words([0, u16::MAX].into_iter().flat_map(|code| [code; 4]).collect(), CodeCurve::Srgb);
        for mut texels in [bytes, words] {
            let halfway = |texels: &Texels| texels.between([0, 1, 0, 1], DVec2::new(0.5, 0.3));
            assert_eq!(halfway(&texels), DVec4::splat(0.5));
            texels.mix_codes();
            let [red, .., alpha] = halfway(&texels).to_array();
            assert!(
                (red - linear_from_srgb(0.5)).abs() < 1e-4 && (alpha - 0.5).abs() < 1e-9,
                "{red} {alpha}"
            );
        }
    }

    #[test]
    fn opaque_texels_are_those_with_an_alpha_of_one() {
        let with_alpha = Texels::of_bytes(vec![9, 80, 200, 255, 0, 130, 255, 255], CodeCurve::Srgb);
        let opaque = Texels::of_opaque_bytes(vec![9, 80, 200, 0, 130, 255], CodeCurve::Srgb);
        assert_eq!(opaque, with_alpha);
        for mixes_codes in [false, true] {
            let [opaque, with_alpha] = [&opaque, &with_alpha].map(|texels| {
                let texels = Texels { mixes_codes, ..texels.clone() };
                texels.between([0, 1, 1, 0], DVec2::new(0.3, 0.6))
            });
            assert_eq!(opaque, with_alpha);
        }
    }

    #[test]
    fn however_they_are_kept_equal_texels_are_equal() {
        let bytes = Texels::of_bytes((0..64).collect(), CodeCurve::Srgb);
        let words = Texels::of_words((0..64).map(|code| code * 257).collect(), CodeCurve::Srgb);
        let floats: Texels = bytes.iter().collect();
        assert_eq!((bytes.len(), words.len(), floats.len()), (16, 16, 16));
        assert_eq!(bytes, words);
        assert_eq!(bytes, floats);
        assert_ne!(bytes, Texels::of_bytes((0..64).collect(), CodeCurve::Linear));
        assert_ne!(bytes, Texels::of_bytes((0..60).collect(), CodeCurve::Srgb));
        assert_eq!(bytes.clone().into_floats(), bytes.iter().collect::<Vec<_>>());
    }
}
