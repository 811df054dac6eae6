//! Brightness of a picture to a viewer. In goes a frame, out come the exposure with which a display shows it
//! well, and whether next to nothing of it is seen. Invariant: only beauty and alpha count.

use super::Frame;
use crate::color::{Rgb, luminance};
use crate::scene::Window;

/// Pictures whose average is a stop darker or brighter than middle grey (0.18) are shown as they are; others
/// are brought to that, so that what was lit darkly stays rather dark.
const DARKEST_AVERAGE: f64 = 0.09;
const BRIGHTEST_AVERAGE: f64 = 0.36;

/// Shadows count as if they were at least this part of the picture's median: how black they are says
/// nothing of the rest.
const DEEPEST_SHADOW: f64 = 1.0 / 256.0;

/// No picture is brightened beyond where its brightest twentieth starts to be brighter than this:
/// what is well lit stays so.
const BRIGHTEST_TWENTIETH: f64 = 1.0;

/// Maximum change of the exposure, in stops: what is darker counts as absent.
const MOST_STOPS: f64 = 16.0;

/// Mean luminance of a picture's brightest hundredth, below which nobody sees anything: four
/// stops below middle grey.
const DARK: f64 = 0.01;

/// A picture on which next to nothing is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dark {
    /// The share of it that things cover, seen or not, `0..=1`.
    pub covered: f64,
}

impl Frame {
    /// Exposure in powers of two with which a display should show the picture: 0 for most, in steps of a
    /// half. The average is that of logarithms (Reinhard et al. 2002, "Photographic Tone Reproduction for
    /// Digital Images", equation 1), over the pixels that show light.
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

    /// Whether next to nothing is seen. It is the brightest hundredth that has to be dark, so a lamp in the
    /// night is none. Of a part of a picture nobody can tell.
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

    /// Luminance of every pixel; none if the frame has no colour. NaN is dark.
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
