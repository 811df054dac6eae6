//! Glare of a lens, for viewing. In go a plane of linear light and the scattered part, out comes the plane
//! with that part blurred. Invariant: a constant plane stays as it is, and so does any plane without
//! scattered light.

use crate::color::{Bloom, Curve, Display};
use rayon::prelude::*;

/// Part of a picture's light that a lens scatters.
#[derive(Clone, Copy)]
pub(super) struct Scatter {
    /// Share, `0..=1`.
    pub(super) share: f64,
    /// Value above which light is scattered.
    pub(super) above: f32,
}

impl Scatter {
    pub(super) fn of(display: &Display) -> Self {
        match display.bloom {
            Bloom::Auto if display.curve == Curve::Agx => {
                Self { share: GLARE, above: (WHITE * (-display.exposure_stops).exp2()) as f32 }
            }
            Bloom::Auto => Self { share: 0.0, above: 0.0 },
            Bloom::Share(share) => Self { share, above: 0.0 },
        }
    }
}

/// Share of a sun's light that is scattered, chosen by eye beside a photograph. Lenses differ (Talvala et
/// al. 2007, "Veiling glare in high dynamic range imaging").
const GLARE: f64 = 0.05;

/// White with AgX: 6.5 stops above middle grey.
const WHITE: f64 = 0.18 * 90.509_667_991_878_09;

/// Standard deviations of the Gaussian kernels, relative to the picture's height. All have the same energy,
/// and each has half the width of the last. So their sum falls as the square of the distance. Eyes and lenses
/// have powers of 2 to 3 (Spencer et al. 1995, "Physically-based glare effects for digital images", section
/// 2).
const WIDTHS: [f64; 6] = [1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0, 1.0 / 64.0, 1.0 / 128.0, 1.0 / 256.0];

/// Number of successive box filters that approximate a Gaussian (Wells 1986, "Efficient synthesis of Gaussian
/// filters by cascaded uniform filters").
const BOXES: usize = 3;

/// Maximum value of scattered light, as infinity and NaN would spread over the whole picture.
const BRIGHTEST: f32 = 1e9;

/// Scatters light of a plane of rows of `width` pixels. `height_px` is the height of the whole picture, of
/// which the plane may be a part; light outside the plane is ignored.
pub(super) fn bloom(plane: &mut [f32], width: usize, height_px: usize, scatter: Scatter) {
    let Scatter { share, above } = scatter;
    if share == 0.0 {
        return;
    }
    let excess = |value: &f32| if value.is_nan() { 0.0 } else { (value - above).clamp(0.0, BRIGHTEST) };
    let light: Vec<f32> = plane.par_iter().map(excess).collect();
    if light.par_iter().all(|excess| *excess == 0.0) {
        return;
    }
    plane.iter_mut().zip(&light).for_each(|(value, light)| *value -= share as f32 * light);
    for relative in WIDTHS {
        let scattered = blurred(&light, width, relative * height_px as f64);
        let part = (share / WIDTHS.len() as f64) as f32;
        plane.iter_mut().zip(scattered).for_each(|(value, scattered)| *value += part * scattered);
    }
}

/// Blurs a plane by a Gaussian with a standard deviation in pixels, along rows and columns.
fn blurred(plane: &[f32], width: usize, deviation_px: f64) -> Vec<f32> {
    // Boxes of 2 r + 1 pixels each have a variance of ((2 r + 1)^2 - 1) / 12.
    let box_px = (12.0 / BOXES as f64 * deviation_px * deviation_px + 1.0).sqrt();
    let radius = (0.5 * (box_px - 1.0)).round() as usize;
    let mut across = plane.to_vec();
    blur_rows(&mut across, width, radius);
    let mut down = transposed(&across, width);
    blur_rows(&mut down, plane.len() / width, radius);
    transposed(&down, plane.len() / width)
}

fn blur_rows(plane: &mut [f32], width: usize, radius: usize) {
    plane.par_chunks_exact_mut(width).for_each_init(
        || vec![0.0; width + 1],
        |sums, row| {
            for _ in 0..BOXES {
                for (column, value) in row.iter().enumerate() {
                    sums[column + 1] = sums[column] + f64::from(*value);
                }
                for (column, value) in row.iter_mut().enumerate() {
                    // At the rim, the mean of existing pixels.
                    let (from, to) = (column.saturating_sub(radius), (column + radius + 1).min(width));
                    *value = ((sums[to] - sums[from]) / (to - from) as f64) as f32;
                }
            }
        },
    );
}

fn transposed(plane: &[f32], width: usize) -> Vec<f32> {
    let height = plane.len() / width;
    let mut columns = vec![0.0; plane.len()];
    columns.par_chunks_exact_mut(height).enumerate().for_each(|(column, values)| {
        for (row, value) in values.iter_mut().enumerate() {
            *value = plane[row * width + column];
        }
    });
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 301;
    const HEIGHT: usize = 257;

    /// A picture that is dark but for a point in its middle, and what a lens makes of it.
    fn of_a_point(light: f32, share: f64) -> Vec<f32> {
        let mut plane = vec![0.0; WIDTH * HEIGHT];
        plane[HEIGHT / 2 * WIDTH + WIDTH / 2] = light;
        bloom(&mut plane, WIDTH, HEIGHT, Scatter { share, above: 0.0 });
        plane
    }

    /// Value in the middle row, some pixels beside the middle.
    fn beside(plane: &[f32], distance_px: usize) -> f64 {
        f64::from(plane[HEIGHT / 2 * WIDTH + WIDTH / 2 + distance_px])
    }

    #[test]
    fn light_is_spread_and_none_is_lost() {
        let plane = of_a_point(1000.0, 0.3);
        let all: f64 = plane.iter().map(|value| f64::from(*value)).sum();
        assert!((all - 1000.0).abs() < 5.0, "{all}");
        assert!(beside(&plane, 0) > 700.0);
        let down = HEIGHT / 2 + 20;
        assert!(
            (f64::from(plane[down * WIDTH + WIDTH / 2]) / beside(&plane, 20) - 1.0).abs() < 1e-4,
            "as far down as across"
        );
    }

    /// By the square of the distance, from the narrowest to the widest.
    #[test]
    fn it_falls_by_the_square_of_the_distance() {
        let plane = of_a_point(1000.0, 0.3);
        for distance_px in [4, 8, 16] {
            let fall = beside(&plane, distance_px) / beside(&plane, 2 * distance_px);
            assert!((3.0..5.5).contains(&fall), "{fall} at {distance_px}");
        }
    }

    #[test]
    fn one_colour_stays_and_so_does_everything_without_a_share() {
        let mut plane = vec![0.25; WIDTH * HEIGHT];
        bloom(&mut plane, WIDTH, HEIGHT, Scatter { share: 0.5, above: 0.0 });
        assert!(plane.iter().all(|value| (value - 0.25).abs() < 1e-6));
        let mut plane = vec![f32::NAN, f32::INFINITY, -1.0, 0.5];
        bloom(&mut plane, 2, 2, Scatter { share: 0.0, above: 0.0 });
        assert!(plane[0].is_nan() && plane[1..] == [f32::INFINITY, -1.0, 0.5]);
    }

    /// By itself a lens scatters what is beyond white, and exposure says where that is.
    #[test]
    fn a_sun_has_glare_and_all_else_stays() {
        let by_itself = |sun: f32, curve: Curve, exposure_stops: f64| {
            let mut plane = vec![0.25; WIDTH * HEIGHT];
            plane[HEIGHT / 2 * WIDTH + WIDTH / 2] = sun;
            let display = Display { curve, exposure_stops, ..Display::default() };
            bloom(&mut plane, WIDTH, HEIGHT, Scatter::of(&display));
            [beside(&plane, 0), beside(&plane, 20)]
        };
        let [sun, near] = by_itself(10_000.0, Curve::Agx, 0.0);
        assert!(sun < 9_700.0 && near > 0.2505, "{sun} {near}");
        assert_eq!(by_itself(16.0, Curve::Agx, 0.0), [16.0, 0.25]);
        assert!(by_itself(16.0, Curve::Agx, 1.0)[0] < 16.0);
        assert_eq!(by_itself(10_000.0, Curve::Srgb, 0.0), [10_000.0, 0.25]);
    }

    #[test]
    fn what_is_no_number_stays_where_it_is() {
        let mut plane = vec![0.5; 64 * 64];
        plane[0] = f32::NAN;
        bloom(&mut plane, 64, 64, Scatter { share: 0.1, above: 0.0 });
        assert!(plane[0].is_nan() && plane[1..].iter().all(|value| (0.4..=0.5001).contains(value)));
    }

    #[test]
    fn pictures_of_any_size_are_taken() {
        for (width, height) in [(1, 1), (1, 50), (50, 1), (3, 2), (0, 0)] {
            let mut plane = vec![1.0; width * height];
            bloom(&mut plane, width, height, Scatter { share: 1.0, above: 0.0 });
            assert!(plane.iter().all(|value| (value - 1.0).abs() < 1e-6));
        }
    }
}
