//! Error estimates of a picture from its own samples. In goes a film whose samples are in two halves. Out
//! come variances of pixels and of blocks of pixels. Invariant: a block's estimate uses all of its own pixels
//! and no others, as the halves of a single pixel may agree by chance.

use super::Film;
use super::hues::HueSums;
use super::pixel_sum::{PixelSum, ROUNDING, value};
use super::smooth::{FogPlanes, Smoothed};
use crate::color::{Rgb, luminance};
use crate::scene::Window;

/// Estimate of a pixel from its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelEstimate {
    /// Luminance.
    pub luminance: f64,
    /// Squared standard error of the colour: the mean over the channels, weighted as in luminance. It equals
    /// the luminance's where channels err alike, and is larger where the hue errs. `None` without two halves.
    pub variance: Option<f64>,
}

/// Estimate of a block from its samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockEstimate {
    /// Mean luminance of its pixels.
    pub luminance: f64,
    /// Mean over the pixels of the squared standard error of their colour. Infinite if no pixel has two
    /// halves.
    pub variance: f64,
    /// Variance of the pixels' luminance beyond noise, relative to the squared luminance: the contrast.
    pub detail: f64,
}

impl Film {
    /// Estimate of a pixel of the full picture; `None` where there are no samples.
    ///
    /// If a pixel's known and fresh samples have means A and B and their weights add up to a and b, then
    /// the pixel's value, (a A + b B) / (a + b), has the variance (A - B)^2 a b / (a + b)^2: exactly so if
    /// samples are independent, for then A - B varies by s^2 (1/a + 1/b) and the value by s^2 / (a + b).
    /// Halves that complete one another err in opposite directions, and the value is better than that.
    pub fn estimate(&self, (x, y): (usize, usize)) -> Option<PixelEstimate> {
        let pixel = self.window.index(x, y)?;
        let all = value(&self.weights[pixel]);
        let color = |sums: &[PixelSum]| Rgb::from_array([0, 1, 2].map(|channel| value(&sums[channel])));
        let [fresh, fresh_sum @ ..] = &self.fresh[pixel];
        let (sum, fresh, fresh_sum) =
            (color(&self.sums[pixel * self.stride()..]), value(fresh), color(fresh_sum));
        let known = all - fresh;
        let hues = self.hues.get(pixel);
        let variance = (known > 0.0 && fresh > 0.0).then(|| {
            let missing = |hues: &HueSums| hues.missing_of_halves(known, fresh);
            let [of_known, of_fresh] = hues.map_or([Rgb::ZERO; 2], missing);
            let difference = (sum - fresh_sum + of_known) / known - (fresh_sum + of_fresh) / fresh;
            let is_rounding = difference.abs().cmple(ROUNDING * sum.abs());
            let difference = Rgb::select(is_rounding, Rgb::ZERO, difference);
            luminance(difference * difference) * known * fresh / (all * all)
        });
        let missing = || hues.map_or(Rgb::ZERO, |hues| hues.missing(all));
        (all > 0.0).then(|| PixelEstimate { luminance: luminance(sum + missing()) / all, variance })
    }

    /// Estimates of the pixels with samples in a part of the picture, from that part alone. `completion` is
    /// the factor on variances for halves that complete one another.
    pub fn estimates(&self, part: Window, completion: f64) -> Vec<((usize, usize), PixelEstimate)> {
        let of_pixel = |pixel| {
            let PixelEstimate { luminance, variance } = self.estimate(pixel)?;
            Some((
                pixel,
                PixelEstimate { luminance, variance: variance.map(|variance| completion * variance) },
            ))
        };
        let mut estimates: Vec<_> = part.pixels().filter_map(of_pixel).collect();
        if let Some(smoothed) = self.smoothed(part, completion) {
            for (pixel, estimate) in &mut estimates {
                let left = part.index(pixel.0, pixel.1).map_or(1.0, |index| smoothed.left(index));
                estimate.variance = estimate.variance.map(|variance| left * variance);
            }
        }
        estimates
    }

    /// Part with smoothed shafts, if the film smooths them.
    fn smoothed(&self, part: Window, completion: f64) -> Option<Smoothed> {
        let is_smoothed = !self.fog.is_empty();
        let variance = |pixel| {
            let variance = self.estimate(pixel).and_then(|estimate| estimate.variance);
            variance.map_or(f32::NAN, |variance| (completion * variance) as f32)
        };
        let new =
            || Smoothed::new(part, &self.fog_planes(part), &part.pixels().map(variance).collect::<Vec<_>>());
        is_smoothed.then(new)
    }

    /// Planes of fog in a part of the picture.
    pub(super) fn fog_planes(&self, part: Window) -> FogPlanes {
        let plane = |channel: usize| -> Vec<f32> {
            let mean = |(x, y): (usize, usize)| {
                let Some(pixel) = self.window.index(x, y) else { return 0.0 };
                let weight = value(&self.weights[pixel]);
                if weight > 0.0 { (f64::from(self.fog[pixel][channel]) / weight) as f32 } else { 0.0 }
            };
            part.pixels().map(mean).collect()
        };
        FogPlanes { shafts: [0, 1, 2].map(plane), through: plane(3) }
    }
}

impl BlockEstimate {
    /// Estimate over the pixels with known errors. A pixel with one half has half as many samples, and so
    /// twice the variance.
    pub fn of(pixels: impl Iterator<Item = PixelEstimate> + Clone) -> Self {
        let (mut variances, mut judged, mut count) = (0.0, 0.0, 0.0);
        for pixel in pixels.clone() {
            count += 1.0;
            if let Some(variance) = pixel.variance {
                variances += variance;
                judged += 1.0;
            }
        }
        let of_halves = 2.0 * (count - judged);
        let variance =
            if judged > 0.0 { variances / judged * (judged + of_halves) / count } else { f64::INFINITY };
        Self::new(pixels.map(|pixel| pixel.luminance), variance)
    }

    /// Estimate from the luminances of pixels and their mean squared error.
    pub fn new(luminances: impl Iterator<Item = f64>, variance: f64) -> Self {
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0_f64);
        for luminance in luminances {
            sum += luminance;
            squares += luminance * luminance;
            count += 1.0;
        }
        let luminance = sum / count.max(1.0);
        let detail = (squares / count.max(1.0) - luminance * luminance - variance).max(0.0);
        Self { luminance, variance, detail }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Blocks, Mask, Splat};
    use crate::math::Sampler;
    use crate::scene::{Size, Window};
    use crate::transport::Sample;

    const SIZE: Size = Size { width: 16, height: 8 };

    fn grey(radiance: f64) -> Sample {
        Sample { radiance: Rgb::splat(radiance), ..Sample::default() }
    }

    fn film() -> (Film, Blocks) {
        let window = Window::whole(SIZE);
        (Film::new(SIZE, window, &[]), Blocks::covering(window, SIZE))
    }

    fn of_blocks(film: &Film, blocks: &Blocks) -> Vec<BlockEstimate> {
        let of_pixel = |pixel| film.estimate(pixel);
        let of_block = |block| {
            let pixels: Vec<_> = blocks.pixels(block).pixels().filter_map(of_pixel).collect();
            BlockEstimate::of(pixels.iter().copied())
        };
        (0..blocks.count()).map(of_block).collect()
    }

    #[test]
    fn halves_that_agree_have_no_error_and_one_half_says_nothing() {
        let (mut film, blocks) = film();
        for (x, y) in Window::whole(SIZE).pixels() {
            film.add(&Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 }, &grey(3.0));
            if x < 8 {
                film.add_fresh(&Splat { pixel: (x, y), weight: 2.0, from_centre_px: 0.0 }, &grey(3.0));
            }
        }
        let [judged, unknown] = of_blocks(&film, &blocks)[..] else { panic!("two blocks") };
        assert!((judged.luminance - 3.0).abs() < 1e-12 && judged.variance < 1e-24, "{judged:?}");
        assert!((unknown.luminance - 3.0).abs() < 1e-12 && unknown.variance == f64::INFINITY, "{unknown:?}");
    }

    /// Halves that are as bright as each other and differ in hue do not agree.
    #[test]
    fn an_error_of_the_hue_is_one() {
        let (mut film, blocks) = film();
        let [red, green] = [Rgb::X, Rgb::Y].map(|color| color / luminance(color));
        for (x, y) in Window::whole(SIZE).pixels() {
            film.add(
                &Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 },
                &Sample { radiance: red, ..Sample::default() },
            );
            film.add_fresh(
                &Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 },
                &Sample { radiance: green, ..Sample::default() },
            );
        }
        let estimate = of_blocks(&film, &blocks)[0];
        // Each channel is off by half of what it is in one of them.
        let expected = luminance((red - green) * (red - green)) / 4.0;
        assert!((estimate.luminance - 1.0).abs() < 1e-6, "{estimate:?}");
        assert!((estimate.variance - expected).abs() < 1e-6 && expected > 1.0, "{estimate:?} {expected}");
    }

    /// Independent samples of variance 1/12: the mean of n of them has variance 1 / (12 n),
    /// however they are halved.
    #[test]
    fn independent_samples_have_the_variance_that_statistics_says() {
        for (known, fresh) in [(4, 4), (12, 4), (2, 14)] {
            let mut variances = 0.0;
            let rounds = 200;
            for round in 0..rounds {
                let (mut film, blocks) = film();
                for (pixel, (x, y)) in Window::whole(SIZE).pixels().enumerate() {
                    for sample in 0..known + fresh {
                        // A pixel's seed a sample: independent, unlike a pixel's own sequence.
                        let number = Sampler::new(round, pixel as u32, sample, 0).next_1d();
                        if sample < known {
                            film.add(
                                &Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 },
                                &grey(number),
                            );
                        } else {
                            film.add_fresh(
                                &Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 },
                                &grey(number),
                            );
                        }
                    }
                }
                variances += of_blocks(&film, &blocks).iter().map(|block| block.variance).sum::<f64>();
            }
            let mean = variances / f64::from(2 * rounds);
            let truth = 1.0 / (12.0 * f64::from(known + fresh));
            assert!((mean / truth - 1.0).abs() < 0.03, "{known} and {fresh}: {mean} for {truth}");
        }
    }

    #[test]
    fn a_pixel_with_one_half_is_no_better_than_others() {
        let (mut film, blocks) = film();
        for (x, y) in Window::whole(SIZE).pixels() {
            film.add(&Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 }, &grey(1.0));
            if y % 4 != 0 {
                film.add_fresh(&Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 }, &grey(2.0));
            }
        }
        let variance = of_blocks(&film, &blocks)[0].variance;
        assert!((variance - (0.75 * 0.25 + 0.25 * 0.5)).abs() < 1e-12, "{variance}");
    }

    #[test]
    fn what_was_fresh_is_known_later() {
        let (mut film, blocks) = film();
        for (x, y) in Window::whole(SIZE).pixels() {
            film.add(&Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 }, &grey(1.0));
            film.add_fresh(&Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 }, &grey(2.0));
        }
        assert!((of_blocks(&film, &blocks)[0].variance - 0.25).abs() < 1e-12);
        film.let_fresh_be_known(&Mask::all(film.window()));
        for (x, y) in Window::whole(SIZE).pixels() {
            film.add_fresh(&Splat { pixel: (x, y), weight: 2.0, from_centre_px: 0.0 }, &grey(1.5));
        }
        assert!(of_blocks(&film, &blocks)[0].variance < 1e-24);
    }

    #[test]
    fn pixels_that_stay_keep_what_they_were_judged_by() {
        let (mut film, _) = film();
        film.add(&Splat { pixel: (3, 3), weight: 1.0, from_centre_px: 0.0 }, &grey(1.0));
        film.add_fresh(&Splat { pixel: (3, 3), weight: 1.0, from_centre_px: 0.0 }, &grey(2.0));
        film.let_fresh_be_known(&Mask::from_fn(film.window(), |x, _| x != 3));
        let estimate = film.estimate((3, 3)).expect("has samples");
        assert!((estimate.luminance - 1.5).abs() < 1e-12, "{estimate:?}");
        assert!(estimate.variance.is_some_and(|variance| (variance - 0.25).abs() < 1e-12), "{estimate:?}");
    }
}
