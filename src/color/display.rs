//! Display transform. In goes linear Rec. 709 of any brightness, out come sRGB values and bytes. Invariant: a
//! byte depends on the colour and the pixel alone, and its mean over 8 by 8 pixels is the value.

use super::{Look, Rgb, agx::agx, srgb_from_linear};

/// Tone curve, from scene light to the range of a display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Curve {
    /// AgX as Blender shows it: bright light fades to white as on film.
    #[default]
    Agx,
    /// Nothing but the sRGB encoding; what is brighter than 1 is cut off.
    Srgb,
    /// The linear values themselves, cut off at 1: data.
    Raw,
}

/// Light that a lens scatters over a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Bloom {
    /// With AgX a twentieth of the light above white, such as a sun's glare; none otherwise.
    #[default]
    Auto,
    /// The given share of all light, `0..=1`.
    Share(f64),
}

/// Settings of pictures for viewing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Display {
    /// Tone curve.
    pub curve: Curve,
    /// Contrast, with AgX.
    pub look: Look,
    /// Exposure in stops, applied before the curve.
    pub exposure_stops: f64,
    /// Light that a lens scatters, applied first. Single colours have none.
    pub bloom: Bloom,
}

/// Largest value: light beyond it is white with every curve, and its logarithm stays finite.
const GLARE: f64 = 1e9;

/// Bayer's 8x8 threshold matrix (Bayer 1973, An optimum method for two-level rendition of
/// continuous-tone pictures).
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

impl Display {
    /// Display values, `0..=1`, of a colour.
    pub fn encode(&self, color: Rgb) -> Rgb {
        let light = (color * self.exposure_stops.exp2()).clamp(Rgb::ZERO, Rgb::splat(GLARE));
        match self.curve {
            Curve::Agx => agx(light.as_vec3(), self.look).as_dvec3().map(srgb_from_linear),
            Curve::Srgb => light.min(Rgb::ONE).map(srgb_from_linear),
            Curve::Raw => light.min(Rgb::ONE),
        }
    }
}

/// Bytes of display values, `0..=1`, at a pixel. Ordered dither rounds a value up with a frequency equal to
/// its fraction, so smooth fog shows no bands.
pub fn dithered(values: Rgb, x: usize, y: usize) -> [u8; 3] {
    let threshold = (f64::from(BAYER[y % 8][x % 8]) + 0.5) / 64.0;
    values.to_array().map(|value| (value * 255.0 + threshold) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const AGX: Display =
        Display { curve: Curve::Agx, look: Look::None, exposure_stops: 0.0, bloom: Bloom::Auto };

    /// Colours, and what Blender 5.0.1 shows of them: view AgX, display sRGB, saved with 16 bits
    /// (`tools/display/against_blender.py` prints these).
    const BLENDER: [([f64; 3], [f64; 3]); 9] = [
        ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
        ([0.18, 0.18, 0.18], [0.46133, 0.46133, 0.46137]),
        ([1.0, 1.0, 1.0], [0.77098, 0.77098, 0.77099]),
        ([16.0, 16.0, 16.0], [0.99857, 0.99857, 0.99857]),
        ([1.0, 0.0, 0.0], [0.85801, 0.22409, 0.1292]),
        ([0.0, 1.0, 0.0], [0.43247, 0.77264, 0.31843]),
        ([0.4, 0.15, 0.02], [0.6439, 0.40874, 0.11585]),
        ([8.0, 3.0, 0.2], [0.98921, 0.87236, 0.76916]),
        ([0.8, 0.5, 0.05], [0.75935, 0.64056, 0.36564]),
    ];

    #[test]
    fn agx_is_blenders() {
        for (light, shown) in BLENDER {
            let ours = AGX.encode(light.into());
            // In between the 57 nodes a side of Blender's table its colours are off by up to a
            // few steps of 8 bits.
            assert!(ours.abs_diff_eq(shown.into(), 2.5 / 255.0), "{light:?}: {ours}, in Blender {shown:?}");
        }
    }

    #[test]
    fn black_is_black_and_glare_is_white() {
        for curve in [Curve::Agx, Curve::Srgb, Curve::Raw] {
            let display = Display { curve, ..AGX };
            assert_eq!(dithered(display.encode(Rgb::ZERO), 3, 5), [0; 3], "{curve:?}");
            for glare in [1e4, f64::MAX, f64::INFINITY] {
                assert_eq!(dithered(display.encode(Rgb::splat(glare)), 0, 0), [255; 3], "{curve:?} {glare}");
            }
        }
    }

    /// A leaf with the sun behind it, ever brighter: it goes to white, and on the way does not become yellow,
    /// as it does where each channel is cut off or compressed by itself.
    #[test]
    fn bright_orange_fades_to_white_without_turning_yellow() {
        let orange = Rgb::new(1.0, 0.35, 0.02);
        // How far green stands between the least and the most: 0 is red, 1 is yellow.
        let yellowness = |shown: Rgb| (shown.y - shown.min_element()) / (shown.x - shown.min_element());
        let at = |display: Display, stops: f64| yellowness(display.encode(orange * stops.exp2()));
        let cut_off = Display { curve: Curve::Srgb, ..AGX };
        assert!(at(cut_off, 3.0) > 0.99, "{}", at(cut_off, 3.0));
        for stops in 0..=5 {
            let yellowness = at(AGX, f64::from(stops));
            assert!((0.3..0.75).contains(&yellowness), "{stops} stops: {yellowness}");
        }
        assert!(AGX.encode(orange * 1e4).min_element() > 0.97);
    }

    #[test]
    fn dithering_keeps_the_mean_between_two_steps() {
        for light in [0.1, 0.18, 0.5, 1.0].map(Rgb::splat) {
            let places = (0..64).map(|place| dithered(AGX.encode(light), place % 8, place / 8)[0]);
            let mean = places.map(f64::from).sum::<f64>() / 64.0;
            let exact = 255.0 * AGX.encode(light).x;
            assert!((mean - exact).abs() <= 1.0 / 64.0, "{light}: {mean} {exact}");
        }
    }

    proptest! {
        #[test]
        fn grey_stays_grey_and_brightens(stops in -12.0..12.0_f64, more in 0.01..2.0_f64) {
            for curve in [Curve::Agx, Curve::Srgb, Curve::Raw] {
                let at = |exposure_stops: f64| Display { curve, exposure_stops, ..AGX }.encode(Rgb::splat(0.18));
                let (dark, bright) = (at(stops), at(stops + more));
                prop_assert!(dark.abs_diff_eq(Rgb::splat(dark.x), 2e-6), "{dark}");
                prop_assert!(bright.x >= dark.x - 1e-7, "{dark} {bright}");
                prop_assert!(bright.x > dark.x || dark.x < 1e-3 || dark.x > 0.999);
            }
        }

        #[test]
        fn any_light_has_a_value(color in prop::array::uniform3(prop::num::f64::ANY)) {
            let shown = AGX.encode(color.into());
            prop_assert!(color.iter().any(|c| c.is_nan()) || (shown.min_element() >= 0.0 && shown.max_element() <= 1.0));
        }

        /// More of the same light is nowhere darker by more than a step of 8 bits.
        #[test]
        fn brightness_only_rises(color in prop::array::uniform3(0.0..1.0_f64), stops in -8.0..8.0_f64) {
            let at = |stops: f64| crate::color::luminance(AGX.encode(Rgb::from(color) * stops.exp2()));
            prop_assert!(at(stops + 0.1) >= at(stops) - 1.0 / 255.0);
        }
    }
}
