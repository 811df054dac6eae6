//! Smoothing of shafts, for pixels that sample the light and the lens at points of their own. In go a frame
//! and its variances, out come shafts with less noise, in their pass and in the beauty. Invariants: a pixel
//! depends on those within [`REACH_PX`]. As noise falls to zero, so does the change.
//!
//! A shaft is as wide as the light's penumbra, and noise is as narrow as a slice. Where surfaces of several
//! distances lie in a pixel, shafts follow transmittance, which is almost free of noise. So shafts are fitted
//! by a linear function of transmittance around each pixel (He, Sun & Tang 2010, "Guided image filtering",
//! with weights). The residual is added back as far as it exceeds noise (James & Stein 1961).

use super::{Channel, Frame};
use crate::passes::Pass;
use crate::scene::Window;
use rayon::prelude::*;

/// Radius of the neighbourhood of the linear fit.
const FITTED_PX: usize = 2;
/// Radius of the neighbourhood in which residual and noise are compared.
const COMPARED_PX: usize = 4;
/// Maximum distance of pixels that a smoothed pixel depends on.
pub const REACH_PX: usize = FITTED_PX + COMPARED_PX;
/// Share of the variance of slice-wide noise that remains after weighting: the sum of squared weights across.
const LEFT: f64 = 19.0 / 81.0;
/// Expected squared residual relative to that variance; a value has a third of the weight in its own mean.
const LACKING: f64 = 1.0 - 2.0 / 3.0 + LEFT;
/// Regularization: variance of transmittance below which the slope vanishes.
const SAME_DISTANCE: f64 = 1e-5;

/// Fog in a part of the picture, a value a pixel.
pub(super) struct FogPlanes {
    /// Red, green and blue.
    pub(super) shafts: [Vec<f32>; 3],
    /// Transmittance, the mean over the channels.
    pub(super) through: Vec<f32>,
}

/// Smooths the shafts of a frame, in the beauty and in their own pass. Variances are those of its pixels, the
/// mean over the channels, NaN where they are unknown.
pub(super) fn smooth(frame: &mut Frame, fog: &FogPlanes, variances: &[f32]) {
    let smoothed = Smoothed::new(frame.window, fog, variances);
    let names = ["R", "G", "B"].into_iter().zip(Pass::Shafts.row().channels);
    for ((shafts, fitted), (beauty, own)) in fog.shafts.iter().zip(&smoothed.fitted).zip(names) {
        let is_smoothed = |channel: &&mut Channel| channel.name == beauty || channel.name == *own;
        for channel in frame.channels.iter_mut().filter(is_smoothed) {
            let values = channel.pixels.iter_mut().zip(shafts.iter().zip(fitted)).enumerate();
            values.for_each(|(pixel, (value, (shaft, fit)))| {
                *value += (1.0 - smoothed.signal(pixel)) * (fit - shaft);
            });
        }
    }
}

/// Fitted shafts of a part of the picture, and their residuals.
pub(super) struct Smoothed {
    fitted: Vec<Vec<f32>>,
    /// Mean squared residual around each pixel.
    lacking: Vec<f32>,
    /// Mean variance around each pixel.
    noise: Vec<f32>,
}

impl Smoothed {
    /// Fits the shafts.
    pub(super) fn new(window: Window, fog: &FogPlanes, variances: &[f32]) -> Self {
        let FogPlanes { shafts, through } = fog;
        let fitted: Vec<Vec<f32>> = shafts.iter().map(|values| fit(window, through, values)).collect();
        let lacking = |pixel: usize| {
            let squares =
                shafts.iter().zip(&fitted).map(|(values, fit)| (values[pixel] - fit[pixel]).powi(2));
            squares.sum::<f32>() / shafts.len() as f32
        };
        let lacking: Vec<f32> = (0..variances.len()).map(lacking).collect();
        let around = |values: &[f32]| tent(window, COMPARED_PX, values);
        Self { fitted, lacking: around(&lacking), noise: around(variances) }
    }

    /// Share of a pixel's residual that is signal (James-Stein shrinkage).
    fn signal(&self, pixel: usize) -> f32 {
        let (lacking, noise) = (self.lacking[pixel], self.noise[pixel]);
        if lacking > noise { 1.0 - noise / lacking } else { 0.0 }
    }

    /// Share of a pixel's variance that remains, squared bias included.
    pub(super) fn left(&self, pixel: usize) -> f64 {
        let [lacking, noise, signal] =
            [self.lacking[pixel], self.noise[pixel], self.signal(pixel)].map(f64::from);
        if noise.is_nan() || noise <= 0.0 {
            return 1.0;
        }
        let of_shafts = (lacking / LACKING).min(noise);
        let smooth = 1.0 - signal;
        let taken = of_shafts * (1.0 - signal * signal - smooth * smooth * LEFT) - signal * smooth * noise;
        (1.0 - taken / noise).clamp(0.0, 1.0)
    }
}

/// Value of each pixel by a linear fit over `guide` to the values around it.
fn fit(window: Window, guide: &[f32], values: &[f32]) -> Vec<f32> {
    (0..values.len())
        .into_par_iter()
        .map(|pixel| {
            // Relative to the pixel's own values, to avoid cancellation.
            let (g, v) = (f64::from(guide[pixel]), f64::from(values[pixel]));
            let mut sums = [0.0; 5];
            for (near, weight) in around(window, FITTED_PX, pixel) {
                let (g, v) = (f64::from(guide[near]) - g, f64::from(values[near]) - v);
                for (sum, term) in sums.iter_mut().zip([1.0, g, v, g * g, g * v]) {
                    *sum += weight * term;
                }
            }
            let [all, g_mean, v_mean, gg, gv] = sums.map(|sum| sum / sums[0]);
            debug_assert!(all == 1.0);
            let slope = (gv - g_mean * v_mean) / ((gg - g_mean * g_mean).max(0.0) + SAME_DISTANCE);
            // Radiance is not negative.
            (v + v_mean - slope * g_mean).max(0.0) as f32
        })
        .collect()
}

/// Mean around each pixel with a tent's weights; NaN where no value is known.
fn tent(window: Window, radius: usize, values: &[f32]) -> Vec<f32> {
    let mean = |pixel: usize| {
        let known = around(window, radius, pixel).filter(|&(near, _)| !values[near].is_nan());
        let (sum, all) = known.fold((0.0, 0.0), |(sum, all), (near, weight)| {
            (sum + weight * f64::from(values[near]), all + weight)
        });
        (sum / all) as f32
    };
    (0..values.len()).into_par_iter().map(mean).collect()
}

/// Pixels of a window within a radius of one, with their weights.
fn around(window: Window, radius: usize, pixel: usize) -> impl Iterator<Item = (usize, f64)> {
    let (column, row) = (pixel % window.width, pixel / window.width);
    let near = move |at: usize, count: usize| at.saturating_sub(radius)..(at + radius + 1).min(count);
    let weight = move |at: usize, other: usize| (radius + 1 - at.abs_diff(other)) as f64;
    near(row, window.height).flat_map(move |y| {
        near(column, window.width).map(move |x| (y * window.width + x, weight(row, y) * weight(column, x)))
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::Precision;
    use super::*;
    use crate::math::Sampler;
    use crate::scene::Size;

    const SIZE: Size = Size { width: 48, height: 40 };

    /// A frame with a leaf in fog, whose shafts are `truth` of the transmittance and the row, and noise.
    fn frame(truth: impl Fn(f32, usize) -> f32, noise: f32) -> Frame {
        let window = Window::whole(SIZE);
        let through = |(x, _): (usize, usize)| [0.9, 0.6, 0.2][(x / 7) % 3];
        let error = |(x, y): (usize, usize)| {
            noise * (Sampler::new(1, x as u32, y as u32, 0).next_1d() as f32 - 0.5) * 12.0_f32.sqrt()
        };
        let shafts = |pixel| truth(through(pixel), pixel.1) + error(pixel);
        let channel = |name: &str, of: &dyn Fn((usize, usize)) -> f32| {
            Channel::new(name, Precision::Half, window.pixels().map(of).collect())
        };
        let mut channels = Vec::new();
        for color in ["R", "G", "B"] {
            channels.push(channel(color, &|pixel| 3.0 + shafts(pixel)));
            channels.push(channel(&format!("shafts.{color}"), &shafts));
            channels.push(channel(&format!("transmittance.{color}"), &through));
        }
        Frame { full: SIZE, window, channels }
    }

    /// Smooths a frame by its own passes.
    fn smooth(frame: &mut Frame, variances: &[f32]) {
        let plane = |name: &str| frame.channel(name).unwrap().pixels.clone();
        let shafts = ["shafts.R", "shafts.G", "shafts.B"].map(plane);
        let fog = FogPlanes { shafts, through: plane("transmittance.R") };
        super::smooth(frame, &fog, variances);
    }

    fn error(frame: &Frame, truth: &Frame) -> f32 {
        let of = |frame: &Frame| frame.channel("R").unwrap().pixels.clone();
        let squares = of(frame).iter().zip(of(truth)).map(|(a, b)| (a - b).powi(2)).sum::<f32>();
        (squares / (SIZE.width * SIZE.height) as f32).sqrt()
    }

    #[test]
    fn noise_falls_and_rims_stay() {
        let shaft = |through: f32, y: usize| 5.0 * (1.0 - through) * (1.0 + 0.02 * y as f32);
        let (truth, mut noisy) = (frame(shaft, 0.0), frame(shaft, 0.1));
        let before = error(&noisy, &truth);
        smooth(&mut noisy, &vec![0.01; SIZE.width * SIZE.height]);
        assert!(error(&noisy, &truth) < 0.4 * before, "{} of {before}", error(&noisy, &truth));
    }

    #[test]
    fn without_noise_shafts_are_as_they_were() {
        let stripes = |through: f32, y: usize| (1.0 - through) * (y % 3) as f32;
        let (truth, mut smoothed) = (frame(stripes, 0.0), frame(stripes, 0.0));
        smooth(&mut smoothed, &vec![0.0; SIZE.width * SIZE.height]);
        assert!(error(&smoothed, &truth) < 1e-6);
    }

    #[test]
    fn pixels_see_no_farther_than_they_reach() {
        let shaft = |through: f32, _| 1.0 - through;
        let (mut near, mut far) = (frame(shaft, 0.1), frame(shaft, 0.1));
        let variances = vec![0.01; SIZE.width * SIZE.height];
        let (column, row) = (20, 20);
        for channel in &mut far.channels {
            channel.pixels[row * SIZE.width + column + REACH_PX + 1] *= 2.0;
        }
        smooth(&mut near, &variances);
        smooth(&mut far, &variances);
        let of = |frame: &Frame, x| frame.channel("R").unwrap().pixels[row * SIZE.width + x];
        assert_eq!(of(&near, column), of(&far, column));
        assert_ne!(of(&near, column + REACH_PX + 1), of(&far, column + REACH_PX + 1));
    }
}
