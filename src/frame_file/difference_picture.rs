//! Picture of two frames and their difference, side by side. In go two files, out comes a picture: output,
//! reference, and the largest difference of each pixel's channels. Invariant: it shows the pixels of both
//! files.

use super::compare::intersection;
use super::{FrameFile, Picture};
use crate::color::Display;
use crate::film::Frame;
use crate::scene::Size;

/// Colours from no difference to the largest, of increasing lightness, so that they are readable in grey.
const HEAT: [[f64; 3]; 5] =
    [[0.0; 3], [70.0, 10.0, 110.0], [200.0, 40.0, 70.0], [250.0, 150.0, 40.0], [255.0, 255.0, 220.0]];
/// Black columns between the pictures.
const GAP: usize = 4;
/// Share of the pixels that are not white by default.
const BELOW_WHITE: f64 = 0.999;

/// Output, reference and difference; `white` is the difference shown as white, by default one that few pixels
/// exceed.
///
/// # Errors
/// With the reason if one of them has no colour, or they share no pixel.
pub fn difference_picture(
    output: FrameFile,
    reference: FrameFile,
    display: &Display,
    white: Option<f64>,
) -> Result<Picture, String> {
    let frames = [output, reference].map(FrameFile::shown);
    let window = intersection(frames[0].window, frames[1].window).ok_or("they have no pixel in common")?;
    let [output, reference] = frames.map(|frame| frame.within(window));
    let shown = [Picture::of(&output, display)?, Picture::of(&reference, display)?];
    let size = Size { width: window.width, height: window.height };
    let heat = heat(size, &differences(&output, &reference), white);
    let mut all = Picture::black(Size { width: 3 * size.width + 2 * GAP, height: size.height });
    for (column, picture) in shown.iter().chain([&heat]).enumerate() {
        all.paste(column * (size.width + GAP), 0, picture);
    }
    Ok(all)
}

/// Largest difference of each pixel's channels; NaN where a value is NaN.
fn differences(output: &Frame, reference: &Frame) -> Vec<f64> {
    let mut largest = vec![0.0; output.window.width * output.window.height];
    for one in &output.channels {
        let Some(other) = reference.channel(&one.name) else { continue };
        for (largest, (a, b)) in largest.iter_mut().zip(one.pixels.iter().zip(&other.pixels)) {
            let apart = if a == b { 0.0 } else { f64::from(a - b).abs() };
            *largest = if apart > *largest || apart.is_nan() { apart } else { *largest };
        }
    }
    largest
}

fn heat(size: Size, differences: &[f64], white: Option<f64>) -> Picture {
    let white = white.unwrap_or_else(|| usual_white(differences));
    let byte = |place: f64, channel: usize| {
        let below = (place as usize).min(HEAT.len() - 2);
        let (from, to) = (HEAT[below][channel], HEAT[below + 1][channel]);
        (from + (to - from) * (place - below as f64)).round() as u8
    };
    let pixel = |apart: &f64| {
        let share = if apart.is_finite() { (apart / white).min(1.0) } else { 1.0 };
        [0, 1, 2].map(|channel| byte(share * (HEAT.len() - 1) as f64, channel))
    };
    Picture { size, bytes: differences.iter().flat_map(pixel).collect() }
}

fn usual_white(differences: &[f64]) -> f64 {
    let mut finite: Vec<f64> = differences.iter().copied().filter(|apart| apart.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    let Some(&largest) = finite.last() else { return 1.0 };
    let usual = finite[((finite.len() - 1) as f64 * BELOW_WHITE) as usize];
    // If fewer pixels differ at all, the largest difference is white.
    [usual, largest].into_iter().find(|white| *white > 0.0).unwrap_or(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_is_white_where_it_differs_most_and_black_where_it_does_not() {
        let size = Size { width: 4, height: 1 };
        let picture = heat(size, &[0.0, 1.0, 2.0, f64::NAN], Some(2.0));
        let pixels: Vec<[u8; 3]> = picture.bytes.as_chunks().0.to_vec();
        assert_eq!(pixels, [[0, 0, 0], [200, 40, 70], [255, 255, 220], [255, 255, 220]]);
    }

    #[test]
    fn white_is_a_difference_that_is_there() {
        assert_eq!(usual_white(&[0.0, 0.0]), 1.0);
        let mut rare = vec![0.0; 5000];
        rare[7] = 0.25;
        assert_eq!(usual_white(&rare), 0.25);
        assert_eq!(usual_white(&[f64::NAN, f64::INFINITY, 3.0]), 3.0);
    }
}
