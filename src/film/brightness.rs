//! Brightness of a picture to a viewer. In goes a frame, out come an exposure for its display and whether the
//! picture looks black. Invariant: both depend on beauty and alpha alone.

use super::Frame;
use crate::color::{Rgb, luminance};
use crate::scene::Window;

/// Least log average of a picture that is displayed unchanged, a stop below middle grey (0.18); the greatest
/// is a stop above it. Other pictures are scaled to these bounds, so a dark picture stays rather dark.
const DARKEST_AVERAGE: f64 = 0.09;
const BRIGHTEST_AVERAGE: f64 = 0.36;

/// Least value of shadows in the average, relative to the picture's median, so that deep blacks do not
/// dominate it.
const DEEPEST_SHADOW: f64 = 1.0 / 256.0;

/// Maximum of the brightest twentieth's lower bound after brightening, so that bright parts are not
/// overexposed.
const BRIGHTEST_TWENTIETH: f64 = 1.0;

/// Maximum change of the exposure in stops; anything darker counts as black.
const MOST_STOPS: f64 = 16.0;

/// Mean luminance of a picture's brightest hundredth below which the picture looks black: four stops below
/// middle grey.
const DARK: f64 = 0.01;

/// Picture that looks black.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dark {
    /// Share of the picture that surfaces cover, visible or not, `0..=1`.
    pub covered: f64,
}

impl Frame {
    /// Automatic exposure for the display, in stops: 0 for most pictures, in steps of a half. The average is
    /// that of logarithms (Reinhard et al. 2002, "Photographic Tone Reproduction for Digital Images",
    /// equation 1), over the pixels with light.
    pub fn auto_exposure_stops(&self) -> f64 {
        let mut lit: Vec<f64> =
            self.luminances().into_iter().filter(|light| *light > 0.0 && light.is_finite()).collect();
        lit.sort_unstable_by(f64::total_cmp);
        let (Some(median), Some(bright)) = (lit.get(lit.len() / 2), lit.get(lit.len() * 19 / 20)) else {
            return 0.0;
        };
        let light = lit.iter().map(|light| light.max(DEEPEST_SHADOW * median).ln());
        let average = (light.sum::<f64>() / lit.len() as f64).exp();
        let stops = (average.clamp(DARKEST_AVERAGE, BRIGHTEST_AVERAGE) / average).log2();
        let stops = stops.min((BRIGHTEST_TWENTIETH / bright).log2().max(0.0));
        (2.0 * stops.clamp(-MOST_STOPS, MOST_STOPS)).round() / 2.0
    }

    /// Returns `Some` if the picture looks black. The brightest hundredth decides, so a lamp in the night
    /// does not count. A crop returns `None`.
    pub fn darkness(&self) -> Option<Dark> {
        if self.window != Window::whole(self.full) {
            return None;
        }
        let mut light = self.luminances();
        let brightest = light.len().div_ceil(100);
        light.sort_unstable_by(|a, b| b.total_cmp(a));
        let sum: f64 = light.iter().take(brightest).sum();
        let covered = self.channel("A").map_or(1.0, |alpha| {
            let sum: f64 = alpha.pixels.iter().map(|alpha| f64::from(*alpha)).sum();
            sum / alpha.pixels.len().max(1) as f64
        });
        (brightest > 0 && sum < DARK * brightest as f64).then_some(Dark { covered })
    }

    /// Luminance of every pixel; empty without R, G and B. NaN counts as 0.
    fn luminances(&self) -> Vec<f64> {
        let [Some(red), Some(green), Some(blue)] = ["R", "G", "B"].map(|name| self.channel(name)) else {
            return Vec::new();
        };
        let light = |pixel: usize| {
            let color = [red, green, blue].map(|channel| f64::from(channel.pixels[pixel]));
            let light = luminance(Rgb::from(color));
            if light.is_finite() { light } else { 0.0 }
        };
        (0..red.pixels.len()).map(light).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Precision};
    use crate::scene::Size;

    /// A grey picture of 20x10 pixels, covered where there is light.
    fn frame(light: impl Fn(usize) -> f32) -> Frame {
        let full = Size { width: 20, height: 10 };
        let grey: Vec<f32> = (0..200).map(light).collect();
        let alpha = grey.iter().map(|light| f32::from(*light > 0.0)).collect();
        let mut channels =
            ["R", "G", "B"].map(|name| Channel::new(name, Precision::Half, grey.clone())).to_vec();
        channels.push(Channel::new("A", Precision::Half, alpha));
        Frame { full, window: Window::whole(full), channels }
    }

    #[test]
    fn pictures_near_middle_grey_stay_and_others_come_near() {
        for (light, stops) in
            [(0.18, 0.0), (0.1, 0.0), (0.3, 0.0), (0.09 / 8.0, 3.0), (0.36 * 4.0, -2.0), (1e-9, 16.0)]
        {
            assert_eq!(frame(|_| light).auto_exposure_stops(), stops, "{light}");
        }
        assert_eq!(frame(|_| 0.0).auto_exposure_stops(), 0.0);
        assert_eq!(frame(|_| f32::NAN).auto_exposure_stops(), 0.0);
    }

    /// Neither the black around a thing nor the shadow on it makes it brighter, nor a sun in the
    /// picture everything dark.
    #[test]
    fn what_is_black_and_what_glares_hardly_count() {
        let alone = |pixel: usize| if pixel < 20 { 0.2 } else { 0.0 };
        assert_eq!(frame(alone).auto_exposure_stops(), 0.0);
        let in_shadow = |pixel: usize| if pixel < 20 { 1e-7 } else { 0.2 };
        assert_eq!(frame(in_shadow).auto_exposure_stops(), 0.0);
        let mostly_in_shadow = |pixel: usize| if pixel < 180 { 1e-7 } else { 0.2 };
        assert_eq!(frame(mostly_in_shadow).auto_exposure_stops(), 2.5);
        let with_a_sun = |pixel: usize| if pixel < 4 { 5e3 } else { 0.2 };
        assert_eq!(frame(with_a_sun).auto_exposure_stops(), 0.0);
    }

    #[test]
    fn a_lamp_in_the_night_is_not_dark() {
        assert_eq!(frame(|_| 0.001).darkness(), Some(Dark { covered: 1.0 }));
        assert_eq!(frame(|_| 0.0).darkness(), Some(Dark { covered: 0.0 }));
        assert_eq!(frame(|pixel| if pixel == 7 { 0.2 } else { 0.0 }).darkness(), None);
        assert_eq!(frame(|_| 0.02).darkness(), None);
        let part = Frame { full: Size { width: 40, height: 10 }, ..frame(|_| 0.0) };
        assert_eq!(part.darkness(), None);
    }
}
