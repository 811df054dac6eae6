//! Image files in, linear light out. Invariant: `width * height` texels.

use crate::color::linear_from_srgb;
use crate::diagnostic::{Diagnostic, Place};
use ::image::ImageReader;
use std::io::Cursor;

/// An RGBA image in linear Rec. 709, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct DecodedImage {
    /// Texels a row, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Linear colour, alpha last, row by row from the top.
    pub texels: Vec<[f32; 4]>,
}

/// Decodes an image, recognised by its content; colours are taken as sRGB.
///
/// # Errors
/// If it is no image; `place` says where.
pub fn decode(bytes: &[u8], place: Place) -> Result<DecodedImage, Diagnostic> {
    let image = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| error.to_string())
        .and_then(|reader| reader.decode().map_err(|error| error.to_string()))
        .map_err(|error| {
            Diagnostic::error(place, format!("the image cannot be decoded: {error}"))
                .expected("a PNG, JPEG or PPM image")
                .remedy("save the image again as PNG")
        })?
        .to_rgba8();
    let linear = |code: u8| linear_from_srgb(f64::from(code) / 255.0) as f32;
    let texels =
        image.pixels().map(|p| [linear(p[0]), linear(p[1]), linear(p[2]), f32::from(p[3]) / 255.0]).collect();
    Ok(DecodedImage { width: image.width() as usize, height: image.height() as usize, texels })
}
