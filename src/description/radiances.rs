//! Images of radiances, OpenEXR and Radiance HDR, in linear Rec. 709. In go bytes, out come texels.
//! Invariant: every channel is a number of at most 1e15 in magnitude.

use super::LARGEST_NUMBER;
use super::decoded_image::DecodedImage;
use super::exr::{self, Fault};
use crate::diagnostic::Loss;
use ::image::DynamicImage;

/// Decodes an OpenEXR image.
///
/// # Errors
/// With the reason if it is damaged, not supported or too large, or with its first invalid texel.
pub(super) fn of_exr(bytes: &[u8], most_texels: u64) -> Result<DecodedImage, Fault> {
    Ok(checked(exr::of_exr(&exr::of_the_kind_of_its_flags(bytes), most_texels)?)?)
}

/// Converts an image in Radiance's HDR format.
pub(super) fn of_hdr(decoded: DynamicImage) -> Result<DecodedImage, String> {
    let rgb = decoded.into_rgb32f();
    let (width, height) = (rgb.width() as usize, rgb.height() as usize);
    let texel = |pixel: &::image::Rgb<f32>| [pixel[0], pixel[1], pixel[2], 1.0];
    checked(DecodedImage::new(width, height, rgb.pixels().map(texel).collect()))
}

/// Loss for an `EXPOSURE` in the header, a factor on the image's numbers which other programs ignore too.
/// Source: "Radiance File Formats", Ward Larson (several lines of `EXPOSURE` multiply).
pub(super) fn exposure(bytes: &[u8]) -> Option<(Loss, String)> {
    let lines = bytes.split(|byte| *byte == b'\n').take_while(|line| !line.is_empty());
    let exposures = lines.filter_map(|line| std::str::from_utf8(line.strip_prefix(b"EXPOSURE=")?).ok());
    let product: f64 = exposures.filter_map(|exposure| exposure.trim().parse::<f64>().ok()).product();
    (product != 1.0).then(|| {
        let found = format!(
            "its header has EXPOSURE={product}: with a strength of {} it has its radiance",
            1.0 / product
        );
        (Loss::RadianceExposure, found)
    })
}

/// Image, or its first invalid texel.
fn checked(image: DecodedImage) -> Result<DecodedImage, String> {
    let is_bad = |texel: &[f32; 4]| {
        texel[..3].iter().any(|value| value.is_nan() || value.abs() > LARGEST_NUMBER as f32)
    };
    let bad = image.texels.iter().enumerate().find(|(_, texel)| is_bad(texel));
    match bad {
        Some((bad, texel)) => Err(format!(
            "the texel in column {} of row {} has the radiance {:?}",
            bad % image.width,
            bad / image.width,
            &texel[..3]
        )),
        None => Ok(image),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn exposures_of_a_header_multiply_and_pixels_have_none() {
        let file =
            |head: &str| format!("#?RADIANCE\n{head}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\nEXPOSURE=9\n");
        let told = |head: &str| exposure(file(head).as_bytes()).map(|(_, found)| found);
        assert!(
            told("EXPOSURE=2.0\nEXPOSURE= 4\n").unwrap().contains("EXPOSURE=8: with a strength of 0.125")
        );
        assert_eq!([told(""), told("EXPOSURE=1\n"), told("EXPOSURE=two\n")], [const { None }; 3]);
    }

    #[test]
    fn a_texel_that_is_no_radiance_is_named() {
        let rgb = ::image::ImageBuffer::from_fn(2, 2, |x, y| ::image::Rgb([1.0, (x + y) as f32 * 6e14, 0.0]));
        let refused = of_hdr(DynamicImage::ImageRgb32F(rgb)).unwrap_err();
        assert!(refused.contains("column 1 of row 1"), "{refused}");
    }
}
