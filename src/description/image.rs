//! Image files. In go bytes, out comes linear light. Invariant: an image has `width * height` texels, within
//! the limits whatever the file's header declares.

pub use super::decoded_image::DecodedImage;
use super::exr::{self, Fault};
use super::{ktx2, radiances};
use crate::color::{CodeCurve, Texels};
use crate::diagnostic::{Diagnostic, Place};
use ::image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Maximum side in texels.
const MAX_SIDE: u32 = 16_384;
/// Maximum number of texels; 1 GiB decoded as radiances. A file of a few hundred kilobytes can declare them.
const MAX_TEXELS: u64 = 1 << 26;
/// Maximum bytes that the decoder may take beside the result.
const MAX_DECODER_BYTES: u64 = 1 << 30;

/// Encoding of an image's numbers; alpha is always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Encoding {
    /// Colours in sRGB.
    Srgb,
    /// Linear numbers.
    Linear,
    /// Radiance, of any brightness: Radiance HDR and OpenEXR.
    Radiance,
}

/// Decodes a PNG, JPEG, WebP, PPM or KTX2 (Basis Universal) image, or one of radiances. Its content decides,
/// not its name.
///
/// # Errors
/// If it is none of these, is damaged, or exceeds 16384 texels a side or 2^26 in all; `place` is its place in
/// errors.
pub fn decode(bytes: &[u8], encoding: Encoding, place: Place) -> Result<DecodedImage, Diagnostic> {
    let (expected, remedy) = wanted(encoding);
    let reject = |found: String| Diagnostic::error(place.clone(), found).expected(expected).remedy(remedy);
    let reject_exr = |fault: Fault| match fault.remedy {
        Some(remedy) => reject(fault.found).remedy(remedy),
        None => reject(fault.found),
    };
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
        let name = reader.format().and_then(|format| format.extensions_str().first());
        let name = name.map_or(String::new(), |name| format!(", but in {}", name.to_uppercase()));
        return Err(reject(format!("this is not an image in a format that is read{name}")));
    }
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    reader.limits(limits);
    let is_exr = reader.format() == Some(ImageFormat::OpenExr);
    let (width, height) = if is_exr {
        exr::size_of_exr(&exr::of_the_kind_of_its_flags(bytes)).map_err(reject_exr)?
    } else {
        dimensions(bytes).map_err(&reject)?
    };
    if width.min(height) == 0
        || width.max(height) > MAX_SIDE
        || u64::from(width) * u64::from(height) > MAX_TEXELS
    {
        return Err(reject(format!(
            "the image has {width}x{height} texels; at most {MAX_SIDE} a side and {MAX_TEXELS} in all are read"
        )));
    }
    if is_exr {
        return radiances::of_exr(bytes, MAX_TEXELS).map_err(reject_exr);
    }
    let decoded = reader
        .decode()
        .map_err(|error| reject(format!("the image cannot be decoded: {}", error.to_string().trim_end())))?;
    if encoding == Encoding::Radiance {
        let image = radiances::of_hdr(decoded).map_err(reject)?;
        Ok(DecodedImage { doubt: radiances::exposure(bytes), ..image })
    } else {
        Ok(linear(decoded, encoding))
    }
}

/// Expected format of an image, and the remedy for another.
fn wanted(encoding: Encoding) -> (&'static str, &'static str) {
    match encoding {
        Encoding::Srgb | Encoding::Linear => (
            "a PNG, JPEG, WebP, PPM or KTX2 (Basis Universal) image of at most 16384 texels a side",
            "save the image again as PNG, or scale it down",
        ),
        Encoding::Radiance => (
            "a Radiance HDR (.hdr) or OpenEXR (.exr) image with red, green and blue, at most 16384 texels a side",
            "save the image again as .hdr or as .exr with ZIP compression, or scale it down",
        ),
    }
}

fn dimensions(bytes: &[u8]) -> Result<(u32, u32), String> {
    ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| format!("the image cannot be read: {error}"))?
        .into_dimensions()
        .map_err(|error| format!("the image cannot be decoded: {}", error.to_string().trim_end()))
}

/// 8-bit codes stay 8-bit codes.
fn linear(decoded: DynamicImage, encoding: Encoding) -> DecodedImage {
    let curve = if encoding == Encoding::Srgb { CodeCurve::Srgb } else { CodeCurve::Linear };
    let (width, height) = (decoded.width() as usize, decoded.height() as usize);
    let has_words = decoded.color().bytes_per_pixel() > decoded.color().channel_count();
    let texels = if has_words {
        Texels::of_words(decoded.into_rgba16().into_raw(), curve)
    } else if decoded.color().has_alpha() {
        Texels::of_bytes(decoded.into_rgba8().into_raw(), curve)
    } else {
        Texels::of_opaque_bytes(decoded.into_rgb8().into_raw(), curve)
    };
    DecodedImage::new(width, height, texels)
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
