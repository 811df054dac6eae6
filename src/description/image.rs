//! Image files in, linear light out. Invariant: `width * height` texels, none larger than the
//! limits allow, whatever the file's header claims.

use super::ktx2;
use crate::color::{CodeCurve, Primaries, Texels};
use crate::diagnostic::{Diagnostic, Place};
use ::image::{DynamicImage, ImageFormat, ImageReader, Limits};
use exr::math::Vec2;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use glam::{DMat3, DVec2, Vec3};
use std::io::Cursor;

/// Longest side that is accepted, in texels.
const MAX_SIDE: u32 = 16_384;
/// Most texels that are accepted; 1 GiB once decoded, if they are radiances.
const MAX_TEXELS: u64 = 1 << 26;
/// Most memory the decoder may take beside the result, in bytes.
const MAX_DECODER_BYTES: u64 = 1 << 30;

/// An RGBA image in linear Rec. 709, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedImage {
    /// Texels a row, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Linear colour, alpha last, row by row from the top.
    pub texels: Texels,
}

/// What the numbers of an image stand for; alpha is always itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoding {
    /// Colours in sRGB.
    Srgb,
    /// Numbers as they are.
    Linear,
    /// Light, of any brightness: Radiance HDR and OpenEXR.
    Radiance,
}

/// Elements of a matrix between primaries that are the same, but for the digits that files give.
const SAME_PRIMARIES: f64 = 1e-3;

/// Larger radiances are refused, as larger numbers are everywhere.
const MOST_RADIANCE: f32 = 1e15;

/// Decodes a PNG, JPEG, WebP, PPM or KTX2 (Basis Universal) image, or one of radiances, recognised by its content.
///
/// # Errors
/// If it is none of these, is damaged, or exceeds 16384 texels a side or 2^26 in all; `place` says where.
pub fn decode(bytes: &[u8], encoding: Encoding, place: Place) -> Result<DecodedImage, Diagnostic> {
    let (expected, remedy) = match encoding {
        Encoding::Srgb | Encoding::Linear => (
            "a PNG, JPEG, WebP, PPM or KTX2 (Basis Universal) image of at most 16384 texels a side",
            "save the image again as PNG, or scale it down",
        ),
        Encoding::Radiance => (
            "a Radiance HDR (.hdr) or OpenEXR (.exr) image with red, green and blue, at most 16384 texels a side",
            "save the image again as .hdr or as .exr with ZIP compression, or scale it down",
        ),
    };
    let reject = |found: String| Diagnostic::error(place.clone(), found).expected(expected).remedy(remedy);
    if encoding != Encoding::Radiance && ktx2::is_ktx2(bytes) {
        return ktx2::decode(bytes, MAX_SIDE, MAX_TEXELS)
            .map(|image| linear(image, encoding))
            .map_err(reject);
    }
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| reject(format!("the image cannot be read: {error}")))?;
    let is_read = match reader.format() {
        Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Pnm | ImageFormat::WebP) => {
            encoding != Encoding::Radiance
        }
        Some(ImageFormat::Hdr | ImageFormat::OpenExr) => encoding == Encoding::Radiance,
        _ => false,
    };
    if !is_read {
        return Err(reject(String::from("this is not an image in a format that is read")));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let (width, height) = dimensions(bytes).map_err(&reject)?;
    if width == 0 || height == 0 || u64::from(width) * u64::from(height) > MAX_TEXELS {
        return Err(reject(format!("the image has {width}x{height} texels")));
    }
    let ours_from_its = match reader.format() {
        Some(ImageFormat::OpenExr) => ours_from_exr(bytes).map_err(&reject)?,
        _ => None,
    };
    let decoded = reader
        .decode()
        .map_err(|error| reject(format!("the image cannot be decoded: {}", error.to_string().trim_end())))?;
    if encoding == Encoding::Radiance {
        radiances(decoded, ours_from_its).map_err(reject)
    } else {
        Ok(linear(decoded, encoding))
    }
}

/// Linear Rec. 709 from the colours of an OpenEXR image, if it has others.
///
/// Refuses what would make the decoder take more memory than the limits, which it does not keep to for OpenEXR:
/// parts and tiles of any size, and channels that have fewer samples than the picture.
fn ours_from_exr(bytes: &[u8]) -> Result<Option<DMat3>, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false)
        .map_err(|error| format!("the image cannot be decoded: {error}"))?;
    let fits = |header: &Header| {
        let is_small = |Vec2(width, height): Vec2<usize>| {
            let samples = (width as u64).saturating_mul(height as u64);
            samples.saturating_mul(4 * header.channels.list.len() as u64) <= MAX_DECODER_BYTES
        };
        let tile_is_small = match header.blocks {
            BlockDescription::Tiles(tiles) => is_small(tiles.tile_size),
            BlockDescription::ScanLines => true,
        };
        let is_whole = header.channels.list.iter().all(|channel| channel.sampling == Vec2(1, 1));
        !header.deep && is_whole && tile_is_small && is_small(header.layer_size)
    };
    if !meta.headers.iter().all(fits) {
        return Err(String::from(
            "the image has deep data, a subsampled channel, or a part of more than 1 GiB",
        ));
    }
    // Without the attribute they are Rec. 709 (OpenEXR, "Standard attributes").
    let said = meta.headers.first().and_then(|header| header.shared_attributes.chromaticities);
    let Some(said) = said else { return Ok(None) };
    let place = |Vec2(x, y): Vec2<f32>| DVec2::new(x.into(), y.into());
    let [red, green, blue, white] = [said.red, said.green, said.blue, said.white].map(place);
    let matrix = Primaries { red, green, blue, white }.to_rec_709();
    let matrix = matrix.ok_or("the image's chromaticities span no colours")?;
    Ok(Some(matrix).filter(|matrix| !matrix.abs_diff_eq(DMat3::IDENTITY, SAME_PRIMARIES)))
}

fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| format!("the image cannot be read: {error}"))?
        .into_dimensions()
        .map_err(|error| format!("the image cannot be decoded: {}", error.to_string().trim_end()))
}

/// Codes of 8 bits stay codes of 8 bits.
fn linear(decoded: DynamicImage, encoding: Encoding) -> DecodedImage {
    let curve = if encoding == Encoding::Srgb { CodeCurve::Srgb } else { CodeCurve::Linear };
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let has_words = decoded.color().bytes_per_pixel() > decoded.color().channel_count();
    let texels = if has_words {
        Texels::of_words(decoded.into_rgba16().into_raw(), curve)
    } else {
        Texels::of_bytes(decoded.into_rgba8().into_raw(), curve)
    };
    DecodedImage { width, height, texels }
}

/// What is wrong is said of the first texel concerned.
fn radiances(decoded: DynamicImage, ours_from_its: Option<DMat3>) -> Result<DecodedImage, String> {
    let rgba = decoded.into_rgba32f();
    let mut texels: Vec<[f32; 4]> = rgba.pixels().map(|pixel| pixel.0).collect();
    if let Some(ours_from_its) = ours_from_its {
        for [red, green, blue, _] in &mut texels {
            let ours = ours_from_its * Vec3::new(*red, *green, *blue).as_dvec3();
            [*red, *green, *blue] = ours.as_vec3().to_array();
        }
    }
    let is_bad =
        |texel: &[f32; 4]| texel[..3].iter().any(|value| value.is_nan() || value.abs() > MOST_RADIANCE);
    let width = rgba.width() as usize;
    if let Some(bad) = texels.iter().position(is_bad) {
        return Err(format!(
            "the texel in column {} of row {} has the radiance {:?}",
            bad % width,
            bad / width,
            &texels[bad][..3]
        ));
    }
    Ok(DecodedImage { width, height: rgba.height() as usize, texels: texels.into() })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::color::linear_from_srgb;
    use ::image::{ImageBuffer, Luma, Rgb, Rgba};

    fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.into().write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn texels(bytes: &[u8]) -> Vec<[f32; 4]> {
        decode(bytes, Encoding::Srgb, Place::Nowhere).unwrap().texels.into_floats()
    }

    fn linear(encoded: f64) -> f32 {
        linear_from_srgb(encoded) as f32
    }

    #[test]
    fn plain_and_binary_ppm_are_top_row_first_and_linear() {
        let expected = [[1.0, 0.0, linear(51.0 / 255.0), 1.0], [0.0, 0.0, 0.0, 1.0]];
        for bytes in [&b"P3\n# by hand\n1 2\n255\n255 0 51 0 0 0\n"[..], b"P6\n1 2\n255\n\xff\x00\x33\0\0\0"]
        {
            let image = decode(bytes, Encoding::Srgb, Place::Nowhere).unwrap();
            assert_eq!((image.width, image.height), (1, 2));
            assert_eq!(image.texels.into_floats(), expected);
        }
    }

    #[test]
    fn png_keeps_its_16_bits_and_its_linear_alpha() {
        let image = ImageBuffer::from_pixel(1, 1, Rgba([12_345_u16, 0, 65_535, 32_768]));
        let expected = [linear(12_345.0 / 65_535.0), 0.0, 1.0, 32_768.0 / 65_535.0];
        assert_eq!(texels(&encoded(image, ImageFormat::Png)), [expected]);
    }

    #[test]
    fn webp_is_read_as_it_was_written() {
        let image = ImageBuffer::from_pixel(2, 3, Rgba([200_u8, 100, 50, 128]));
        let expected = [200.0, 100.0, 50.0].map(|code| linear(code / 255.0));
        let expected = [expected[0], expected[1], expected[2], 128.0 / 255.0];
        assert_eq!(texels(&encoded(image, ImageFormat::WebP)), [expected; 6]);
    }

    #[test]
    fn grey_png_is_grey() {
        let image = ImageBuffer::from_pixel(1, 1, Luma([128_u8]));
        let grey = linear(128.0 / 255.0);
        assert_eq!(texels(&encoded(image, ImageFormat::Png)), [[grey, grey, grey, 1.0]]);
    }

    #[test]
    fn jpeg_comes_near() {
        let image = ImageBuffer::from_pixel(16, 16, Rgb([200_u8, 100, 50]));
        let [r, g, b, alpha] = texels(&encoded(image, ImageFormat::Jpeg))[100];
        let expected = [200.0, 100.0, 50.0].map(|code| linear(code / 255.0));
        assert!([r, g, b].iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 0.02));
        assert_eq!(alpha, 1.0);
    }
}
