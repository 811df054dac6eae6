//! A frame to a PNG for human eyes. Invariant: the same frame gives the same bytes; the EXR stays
//! the picture, this is a look at it.

use super::{FrameFileError, atomic};
use crate::color::srgb_from_linear;
use crate::film::Frame;
use image::ExtendedColorType;
use image::ImageEncoder;
use image::codecs::png::PngEncoder;
use std::path::Path;

/// Bayer's 8x8 threshold matrix (Bayer 1973, An optimum method for two-level rendition of continuous-tone pictures).
const BAYER: [[u8; 8]; 8] = [
    [0, 32, 8, 40, 2, 34, 10, 42],
    [48, 16, 56, 24, 50, 18, 58, 26],
    [12, 44, 4, 36, 14, 46, 6, 38],
    [60, 28, 52, 20, 62, 30, 54, 22],
    [3, 35, 11, 43, 1, 33, 9, 41],
    [51, 19, 59, 27, 49, 17, 57, 25],
    [15, 47, 7, 39, 13, 45, 5, 37],
    [63, 31, 55, 23, 61, 29, 53, 21],
];

/// Writes R, G and B, over black, as an 8-bit sRGB PNG of the frame's window. `exposure_stops` brightens by powers of two.
///
/// Tones follow Narkowicz' fit to the ACES curve; an ordered dither of one step keeps smooth fog free of bands.
///
/// # Errors
/// If the frame has no colour or the disk says no.
pub fn write_preview(path: &Path, frame: &Frame, exposure_stops: f64) -> Result<(), FrameFileError> {
    let encode_error = |reason: String| FrameFileError::Encode { path: path.to_owned(), reason };
    let channel = |name: &str| {
        frame.channel(name).ok_or_else(|| encode_error(format!("the frame has no channel {name}")))
    };
    let colors = [channel("R")?, channel("G")?, channel("B")?];
    let gain = exposure_stops.exp2();
    let pixels: Vec<u8> = frame
        .window
        .pixels()
        .enumerate()
        .flat_map(|(index, (x, y))| {
            let threshold = (f64::from(BAYER[y % 8][x % 8]) + 0.5) / 64.0;
            colors.map(|color| {
                let encoded = srgb_from_linear(filmic(gain * f64::from(color.pixels[index])));
                // Rounds down or up, the more often up the nearer the value is to the step above.
                (encoded * 255.0 + threshold) as u8
            })
        })
        .collect();
    let mut png = Vec::new();
    let (width, height) = (u32::try_from(frame.window.width), u32::try_from(frame.window.height));
    let (Ok(width), Ok(height)) = (width, height) else {
        return Err(encode_error(String::from("the picture is too large for a PNG")));
    };
    PngEncoder::new(&mut png)
        .write_image(&pixels, width, height, ExtendedColorType::Rgb8)
        .map_err(|error| encode_error(error.to_string()))?;
    atomic::write(path, &png)
}

/// Radiance to display light in `0..=1` (Narkowicz 2015, "ACES Filmic Tone Mapping Curve").
fn filmic(x: f64) -> f64 {
    // Beyond this the curve is at 1, and the squares of infinity would be NaN.
    let x = x.clamp(0.0, 1e6);
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::{Channel, Precision};
    use crate::scene::{Size, Window};

    fn flat(value: f32) -> Vec<u8> {
        let full = Size { width: 8, height: 8 };
        let channels = ["R", "G", "B"].map(|name| Channel::new(name, Precision::Half, vec![value; 64]));
        let frame = Frame { full, window: Window::whole(full), channels: channels.to_vec() };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("preview.png");
        write_preview(&path, &frame, 0.0).unwrap();
        image::open(&path).unwrap().to_rgb8().into_raw()
    }

    #[test]
    fn black_is_black_and_glare_is_white() {
        assert!(flat(0.0).iter().all(|&value| value == 0));
        assert!(flat(1e9).iter().all(|&value| value == 255));
    }

    #[test]
    fn dithering_keeps_the_mean_between_two_steps() {
        for value in [0.1_f32, 0.18, 0.5, 1.0] {
            let pixels = flat(value);
            let mean = pixels.iter().map(|&value| f64::from(value)).sum::<f64>() / pixels.len() as f64;
            let exact = 255.0 * srgb_from_linear(filmic(f64::from(value)));
            assert!((mean - exact).abs() <= 1.0 / 64.0, "{value}: {mean} {exact}");
        }
    }

    #[test]
    fn the_curve_only_rises() {
        let values: Vec<f64> = (0..1000).map(|step| filmic(f64::from(step) * 0.02)).collect();
        assert!(values.windows(2).all(|pair| pair[0] <= pair[1]));
    }
}
