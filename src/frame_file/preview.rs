//! A frame to a PNG for human eyes. Invariant: the same frame gives the same bytes, whether it was just rendered or is
//! read from its file; the EXR stays the picture, this is a look at it.

use super::{FrameFileError, atomic};
use crate::color::{Display, Rgb};
use crate::film::Frame;
use image::ExtendedColorType;
use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use std::path::Path;

/// Writes R, G and B, over black, as an 8-bit PNG of the frame's window.
///
/// # Errors
/// If the frame has no colour or the disk says no.
pub fn write_preview(path: &Path, frame: &Frame, display: &Display) -> Result<(), FrameFileError> {
    let png =
        encode(frame, display).map_err(|reason| FrameFileError::Encode { path: path.to_owned(), reason })?;
    atomic::write(path, &png)
}

fn encode(frame: &Frame, display: &Display) -> Result<Vec<u8>, String> {
    let pixels = shown(frame, display)?;
    let side =
        |side: usize| u32::try_from(side).map_err(|_| String::from("the picture is too large for a PNG"));
    let (width, height) = (side(frame.window.width)?, side(frame.window.height)?);
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(&pixels, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| error.to_string())?;
    Ok(png)
}

/// What a screen is sent for the frame's window: three bytes a pixel, row by row.
fn shown(frame: &Frame, display: &Display) -> Result<Vec<u8>, String> {
    let channel = |name: &str| frame.channel(name).ok_or_else(|| format!("the frame has no channel {name}"));
    let colors = [channel("R")?, channel("G")?, channel("B")?];
    let pixels = frame.window.pixels().enumerate();
    let bytes = pixels.flat_map(|(index, (x, y))| {
        let color = colors.map(|color| f64::from(color.precision.stored(color.pixels[index])));
        display.bytes(Rgb::from(color), x, y)
    });
    Ok(bytes.collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::{Channel, Precision};
    use crate::scene::{Size, Window};

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
            let expected = display.bytes(Rgb::from_slice(&color), x, y);
            assert_eq!(shown.get_pixel((x - 2) as u32, (y - 1) as u32).0, expected);
        }
    }
}
