//! Correction of colours under a light with a picture. In go samples of single points of the light, each with
//! its hue, out come colours under the whole light. Invariant: light from elsewhere does not change, and
//! where all points are equally visible no single point's hue remains.
//!
//! A picture on a sun has red points and blue points, and a pixel samples only a few of them. The mean hue of
//! the whole sun is 1, so the error of the sampled mean is known. The light's contribution is corrected by
//! it, channel by channel.

use super::pixel_sum::{self, PixelSum};
use crate::color::Rgb;
use crate::transport::Sample;

/// Packed numbers of a sample.
pub(super) const PACKED: usize = 9;

/// A pixel's weighted sums of colours. Those of all samples: hue, then the light's radiance without and with
/// it, then the part of that which was scattered in fog, without and with it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct HueSums {
    all: [[PixelSum; 3]; 5],
    /// The first of these of the fresh half alone, by which the pixel is judged.
    fresh: [[PixelSum; 3]; 3],
}

impl HueSums {
    /// Adds the sums of another film's pixel.
    pub(super) fn add(&mut self, other: &Self) {
        let sums = self.all.iter_mut().chain(&mut self.fresh);
        sums.zip(other.all.iter().chain(&other.fresh)).for_each(|(sums, added)| add(sums, values(*added)));
    }

    /// Adds the packed numbers of a sample.
    pub(super) fn add_packed(&mut self, is_fresh: bool, packed: &[f32], weight: f64) {
        let color = |at: usize| Rgb::from_array([0, 1, 2].map(|i| f64::from(packed[at + i])));
        let (hue, plain, plain_shafts) = (color(0), weight * color(3), weight * color(6));
        let colors = [weight * hue, plain, hue * plain, plain_shafts, hue * plain_shafts];
        self.all.iter_mut().zip(colors).for_each(|(sums, color)| add(sums, color));
        if is_fresh {
            self.fresh.iter_mut().zip(colors).for_each(|(sums, color)| add(sums, color));
        }
    }

    /// Lets the fresh half be known.
    pub(super) fn clear_fresh(&mut self) {
        self.fresh = Default::default();
    }

    /// Correction to add to the weighted radiance of samples, whose light has no hue yet.
    pub(super) fn missing(&self, weight: f64) -> Rgb {
        let [hue, plain, hued, ..] = self.all.map(values);
        by_all_hues(plain, hued, hue / weight) - plain
    }

    /// Corrections as [`Self::missing`] for the known half and for the fresh one.
    pub(super) fn missing_of_halves(&self, known: f64, fresh: f64) -> [Rgb; 2] {
        let ([hue, plain, hued, ..], of_fresh) = (self.all.map(values), self.fresh.map(values));
        let of_known = [hue - of_fresh[0], plain - of_fresh[1], hued - of_fresh[2]];
        [(of_known, known), (of_fresh, fresh)]
            .map(|([hue, plain, hued], weight)| by_all_hues(plain, hued, hue / weight) - plain)
    }

    /// Correction to add to the part that was scattered in fog.
    pub(super) fn missing_shafts(&self, weight: f64) -> Rgb {
        let [hue, _, _, plain, hued] = self.all.map(values);
        by_all_hues(plain, hued, hue / weight) - plain
    }
}

fn values(sums: [PixelSum; 3]) -> Rgb {
    Rgb::from_array(sums.map(|sum| pixel_sum::value(&sum)))
}

fn add(sums: &mut [PixelSum; 3], color: Rgb) {
    sums.iter_mut().zip(color.to_array()).for_each(|(sum, added)| pixel_sum::add(sum, added));
}

/// Estimate under the whole light from points with the mean hue `hue`.
///
/// If the mean hue of a channel is above 1, the sum is divided by it (the ratio estimate: Cochran 1977,
/// "Sampling Techniques", 6.2). If it is below 1, and perhaps 0, the missing share is added without hues
/// (the difference estimate, 7.1). Neither is negative, and both are exact if all points are equally visible.
/// Else their error is the covariance of visibility and hue, and falls with the number of samples.
fn by_all_hues(plain: Rgb, hued: Rgb, hue: Rgb) -> Rgb {
    let channel =
        |i: usize| if hue[i] > 1.0 { hued[i] / hue[i] } else { hued[i] + plain[i] * (1.0 - hue[i]) };
    Rgb::from_array([0, 1, 2].map(channel))
}

/// Packs a sample's light.
pub(super) fn packed(sample: &Sample) -> [f32; PACKED] {
    // All other light counts as that of the whole light, and needs no correction.
    let of_light = sample.radiance - sample.emitted - sample.indirect - sample.indirect_shafts;
    let [h, p, s] =
        [sample.hue, of_light, sample.shafts - sample.indirect_shafts].map(|color| color.to_array());
    [h[0], h[1], h[2], p[0], p[1], p[2], s[0], s[1], s[2]].map(|value| value as f32)
}

/// Corrects the red, green and blue of a picture whose samples have the total `weights`, by `missing`.
pub(super) fn correct<'a>(
    planes: impl Iterator<Item = &'a mut Vec<f32>>,
    hues: &[HueSums],
    weights: &[PixelSum],
    missing: fn(&HueSums, f64) -> Rgb,
) {
    for (number, plane) in planes.enumerate() {
        let known = plane.iter_mut().zip(hues).zip(weights.iter().map(pixel_sum::value));
        for ((value, sums), weight) in known.filter(|(_, weight)| *weight > 0.0) {
            *value = (f64::from(*value) + missing(sums, weight)[number] / weight) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::color::Rgb;
    use crate::film::{Film, Mask, Splat};
    use crate::passes::Pass;
    use crate::scene::{Size, Window};
    use crate::transport::Sample;
    use proptest::prelude::*;

    const ONE_PIXEL: Window = Window { x: 0, y: 0, width: 1, height: 1 };

    fn film() -> Film {
        Film::with_hues(Size { width: 1, height: 1 }, ONE_PIXEL, &[Pass::Shafts])
    }

    /// Sample of fog and a surface by light of a hue, before emission.
    fn sample(shafts: Rgb, lit: Rgb, emitted: Rgb, hue: Rgb) -> Sample {
        Sample { radiance: shafts + lit + emitted, shafts, emitted, hue, ..Sample::default() }
    }

    fn colors(film: &Film, names: [&str; 3]) -> Rgb {
        let frame = film.resolve();
        let channel = |name| frame.channel(name).map_or(f64::NAN, |channel| f64::from(channel.pixels[0]));
        Rgb::from_array(names.map(channel))
    }

    proptest! {
        /// Seen alike from all points, light has the colour of all of them, whichever were met; what shines
        /// by itself is the mean that it always was.
        #[test]
        fn no_hue_of_a_point_is_left(
            points in prop::collection::vec((prop::array::uniform3(0.0..3.0_f64), 0.1..2.0_f64, 0.0..9.0_f64, any::<bool>()), 2..20),
        ) {
            let (shafts, lit) = (Rgb::new(0.3, 0.2, 0.1), Rgb::new(1.0, 0.5, 2.0));
            let mut film = film();
            let (mut own, mut weights) = (0.0, 0.0);
            for &(hue, weight, shines, is_fresh) in &points {
                let sample = sample(shafts, lit, Rgb::splat(shines), Rgb::from_array(hue));
                if is_fresh {
                    film.add_fresh(&Splat { pixel: (0, 0), weight, from_centre_px: 0.0 }, &sample);
                } else {
                    film.add(&Splat { pixel: (0, 0), weight, from_centre_px: 0.0 }, &sample);
                }
                (own, weights) = (own + weight * shines, weights + weight);
            }
            let whole = shafts + lit + own / weights;
            prop_assert!((colors(&film, ["R", "G", "B"]) / whole - 1.0).abs().max_element() < 1e-5);
            prop_assert!((colors(&film, ["shafts.R", "shafts.G", "shafts.B"]) / shafts - 1.0).abs().max_element() < 1e-5);
        }
    }

    /// Halves that have met different hues agree if they have seen the same.
    #[test]
    fn hues_are_no_error() {
        let mut film = film();
        let [red, blue] = [Rgb::new(2.0, 0.8, 0.2), Rgb::new(0.5, 1.0, 1.5)];
        let seen = |hue| sample(Rgb::splat(0.2), Rgb::ONE, Rgb::splat(3.0), hue);
        film.add(&Splat { pixel: (0, 0), weight: 1.0, from_centre_px: 0.0 }, &seen(red));
        film.add_fresh(&Splat { pixel: (0, 0), weight: 2.0, from_centre_px: 0.0 }, &seen(blue));
        let variance = |film: &Film| film.estimate((0, 0)).and_then(|estimate| estimate.variance);
        assert!(variance(&film).is_some_and(|variance| variance < 1e-12), "{:?}", film.estimate((0, 0)));
        film.let_fresh_be_known(&Mask::all(ONE_PIXEL));
        film.add_fresh(&Splat { pixel: (0, 0), weight: 1.0, from_centre_px: 0.0 }, &seen(Rgb::ONE));
        assert!(variance(&film).is_some_and(|variance| variance < 1e-12), "{:?}", film.estimate((0, 0)));
    }
}
