//! Pictures for viewing. In goes a frame, out come 8-bit pixels and PNG files. Invariant: the same frame
//! gives the same bytes, whether just rendered or read from its file.

use super::bloom::{Scatter, bloom};
use super::{FrameFileError, atomic};
use crate::color::{Display, Rgb, dithered};
use crate::film::{Channel, Frame};
use crate::scene::{Size, Window};
use image::codecs::png::PngEncoder;
use image::imageops::{FilterType, resize};
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use rayon::prelude::*;
use std::path::Path;

/// Picture with eight bits of red, green and blue a pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Columns and rows.
    pub size: Size,
    /// Three bytes a pixel, row by row from the top.
    pub bytes: Vec<u8>,
}

impl Picture {
    /// Black picture.
    pub fn black(size: Size) -> Self {
        Self { size, bytes: vec![0; 3 * size.width * size.height] }
    }

    /// Picture of a frame's window for a display: its R, G and B, over black.
    ///
    /// # Errors
    /// With the reason if the frame has no colour.
    pub fn of(frame: &Frame, display: &Display) -> Result<Self, String> {
        let Window { x, y, width, height } = frame.window;
        let plane = |channel: &Channel| {
            let mut plane: Vec<f32> =
                channel.pixels.par_iter().map(|value| channel.precision.stored(*value)).collect();
            bloom(&mut plane, width, frame.full.height, Scatter::of(display));
            plane
        };
        let [red, green, blue] = ["R", "G", "B"].map(|name| frame.channel(name).map(plane));
        let planes = red.zip(green).zip(blue).ok_or("the frame has no R, G and B")?;
        let planes = [planes.0.0, planes.0.1, planes.1];
        let mut bytes = vec![0; 3 * width * height];
        bytes.par_chunks_mut((3 * width).max(1)).enumerate().for_each(|(row, bytes)| {
            // Neighbours often have the same colour.
            let (mut last, mut shown) = (Rgb::ZERO, display.encode(Rgb::ZERO));
            for (column, pixel) in bytes.chunks_exact_mut(3).enumerate() {
                let color = Rgb::from([0, 1, 2].map(|plane| f64::from(planes[plane][row * width + column])));
                if color != last {
                    (last, shown) = (color, display.encode(color));
                }
                pixel.copy_from_slice(&dithered(shown, x + column, y + row));
            }
        });
        Ok(Self { size: Size { width, height }, bytes })
    }

    /// Copies another picture into this one, with its upper left corner at a pixel; it has to fit.
    pub fn paste(&mut self, x: usize, y: usize, other: &Self) {
        for (row, source) in other.bytes.chunks_exact(3 * other.size.width).enumerate() {
            let at = 3 * ((y + row) * self.size.width + x);
            self.bytes[at..at + source.len()].copy_from_slice(source);
        }
    }

    /// Picture resampled to another size.
    pub fn resized(self, size: Size) -> Self {
        let sides =
            |size: Size| [size.width, size.height].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
        let ([columns, rows], [width, height]) = (sides(self.size), sides(size));
        match RgbImage::from_raw(columns, rows, self.bytes) {
            Some(picture) => {
                Self { size, bytes: resize(&picture, width, height, FilterType::Triangle).into_raw() }
            }
            None => Self::black(size),
        }
    }

    /// Size at which pixels of this width by height are square. The picture grows along their shorter side.
    pub fn unsqueezed(&self, pixel_aspect: f64) -> Size {
        let Size { width, height } = self.size;
        let grown = |side: usize, factor: f64| (side as f64 * factor.max(1.0)).round() as usize;
        Size { width: grown(width, pixel_aspect), height: grown(height, 1.0 / pixel_aspect) }
    }

    /// Writes it as PNG, whole or not at all; folders are created.
    pub fn write(&self, path: &Path) -> Result<(), FrameFileError> {
        let encode_error = |reason: String| FrameFileError::Encode { path: path.to_owned(), reason };
        let (width, height) = png_size(self.size).map_err(encode_error)?;
        let mut png = Vec::new();
        PngEncoder::new(&mut png)
            .write_image(&self.bytes, width, height, ExtendedColorType::Rgb8)
            .map_err(|error| encode_error(error.to_string()))?;
        atomic::write(path, &png)
    }
}

/// Columns and rows, if a PNG can have them.
pub(super) fn png_size(size: Size) -> Result<(u32, u32), String> {
    let side = |side: usize| u32::try_from(side).ok().filter(|&side| side <= i32::MAX as u32);
    let sides = side(size.width).zip(side(size.height));
    sides.ok_or_else(|| String::from("the picture is too large for a PNG"))
}

/// Writes a frame's picture.
pub fn write_preview(path: &Path, frame: &Frame, display: &Display) -> Result<(), FrameFileError> {
    Picture::of(frame, display)
        .map_err(|reason| FrameFileError::Encode { path: path.to_owned(), reason })?
        .write(path)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::{Channel, Precision};

    #[test]
    fn a_picture_is_what_the_display_shows_of_each_pixel() {
        let full = Size { width: 9, height: 9 };
        let window = Window { x: 2, y: 1, width: 3, height: 2 };
        let values = |scale: f32| (0..6).map(|place| scale * place as f32).collect();
        let channels = [("R", 0.1), ("G", 0.07), ("B", 0.3)]
            .map(|(name, scale)| Channel::new(name, Precision::Float, values(scale)));
        let frame = Frame { full, window, channels: channels.to_vec() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("preview.png");
        let display = Display { exposure_stops: 1.0, ..Display::default() };
        write_preview(&path, &frame, &display).unwrap();
        let shown = image::open(&path).unwrap().to_rgb8();
        assert_eq!(shown.dimensions(), (3, 2));
        for (index, (x, y)) in window.pixels().enumerate() {
            let color = frame.channels.iter().map(|channel| f64::from(channel.pixels[index]));
            let color: Vec<f64> = color.collect();
            let expected = dithered(display.encode(Rgb::from_slice(&color)), x, y);
            assert_eq!(shown.get_pixel((x - 2) as u32, (y - 1) as u32).0, expected);
        }
    }
}
