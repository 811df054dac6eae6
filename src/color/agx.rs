//! AgX, a tone curve from scene light of any brightness to the range of a display. In goes linear Rec. 709,
//! out comes linear Rec. 709 in `0..=1`. Invariant: grey stays grey, and more light never looks darker.
//!
//! It is Troy Sobotka's AgX as Blender 4 and later show it. Blender's table was made from Eary Chow's
//! formulas: `AgXBaseRec2020.py` and `AgXBasesRGB.py` of github.com/EaryChow/AgX_LUT_Gen. Every colour is
//! first mixed with a little of the other two (the inset), so bright saturated light goes to white as on
//! film. The channels are compressed one by one. Then the mix is taken back (the outset). docs/display.md has
//! the constants and how close this is.

use super::Look;
use glam::{Mat3, Vec3};
use std::sync::LazyLock;

/// ITU-R BT.2087-0, table 1.
const REC_2020_FROM_REC_709: Mat3 = from_rows([
    [0.627_403_9, 0.329_283_04, 0.043_313_07],
    [0.069_097_29, 0.919_540_4, 0.011_362_32],
    [0.016_391_44, 0.088_013_31, 0.895_595_25],
]);
const REC_709_FROM_REC_2020: Mat3 = from_rows([
    [1.660_491, -0.587_641_1, -0.072_849_86],
    [-0.124_550_47, 1.132_899_9, -0.008_349_42],
    [-0.018_150_76, -0.100_578_9, 1.118_729_7],
]);
/// Primaries of Rec. 2020 turned by 2.14, -1.23 and -3.05 degrees and drawn in by 0.330, 0.281 and 0.125 of
/// their distance from white; as in Blender's `config.ocio`, colour space `AgX Log`.
const INSET: Mat3 = from_rows([
    [0.856_627_15, 0.095_121_24, 0.048_251_61],
    [0.137_318_97, 0.761_242, 0.101_439_04],
    [0.111_898_21, 0.076_799_42, 0.811_302_37],
]);
/// Inverse of the mix with primaries drawn in by 0.323, 0.283 and 0.037, not turned.
const OUTSET: Mat3 = from_rows([
    [1.127_100_6, -0.110_606_64, -0.016_493_94],
    [-0.141_329_76, 1.157_823_7, -0.016_493_94],
    [-0.141_329_76, -0.110_606_64, 1.251_936_4],
]);

/// Linear value of middle grey, in the middle of the curve.
const MIDDLE_GREY: f32 = 0.18;
/// Stops from black to middle grey.
const STOPS_BELOW: f32 = 10.0;
/// Stops from middle grey to white.
const STOPS_ABOVE: f32 = 6.5;
/// Rise of the curve at middle grey, over the whole range of stops as 1.
const SLOPE: f32 = 2.4;
/// Exponent of display light where the curve works (ITU-R BT.1886).
const GAMMA: f32 = 2.4;
/// Share of the hue shift to keep that compression of single channels causes. With all of it orange turns
/// yellow before it turns white.
const HUE_SHIFT_KEPT: f32 = 0.4;

const fn from_rows([a, b, c]: [[f32; 3]; 3]) -> Mat3 {
    Mat3::from_cols_array_2d(&[[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]])
}

/// Maps light to the range of a display.
pub(super) fn agx(light: Vec3, look: Look) -> Vec3 {
    let mixed = look.graded(INSET * (REC_2020_FROM_REC_709 * light), MIDDLE_GREY);
    let formed = Vec3::from(mixed.to_array().map(|channel| encoded(channel).powf(GAMMA)));
    let turned = with_hue(formed, between_hues(hue(mixed), hue(formed), HUE_SHIFT_KEPT));
    // Values outside the display's gamut are clipped; Blender first lifts them a little.
    (REC_709_FROM_REC_2020 * (OUTSET * turned)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// The sigmoid on one side of its pivot: with `x` from the pivot and `d` = 1 - pivot in each direction,
/// `y = s e / (1 + e^1.5)^(2/3)`, `e = slope x / s`, and `s` such that the curve ends in the corner.
///
/// Jed Smith's, with both powers 1.5 (`sigmoid.py` there).
struct Arm {
    sign: f32,
    scale: f32,
}

/// Pivot of the sigmoid, where its arms meet, and the arms below and above it.
static SIGMOID: LazyLock<(f32, [Arm; 2])> = LazyLock::new(|| {
    let x_pivot = STOPS_BELOW / (STOPS_BELOW + STOPS_ABOVE);
    let y_pivot = MIDDLE_GREY.powf(1.0 / GAMMA);
    let arm = |sign: f32, width: f32, height: f32| {
        let rise = SLOPE * width;
        Arm { sign, scale: rise / ((rise / height).powf(1.5) - 1.0).cbrt().powi(2) }
    };
    (y_pivot, [arm(-1.0, x_pivot, y_pivot), arm(1.0, 1.0 - x_pivot, 1.0 - y_pivot)])
});

/// Encoded value of a channel in `0..=1`: a sigmoid of its logarithm, through middle grey.
fn encoded(channel: f32) -> f32 {
    let (y_pivot, arms) = &*SIGMOID;
    let stops = (channel.max(f32::MIN_POSITIVE) / MIDDLE_GREY).log2().clamp(-STOPS_BELOW, STOPS_ABOVE);
    let Arm { sign, scale } = &arms[usize::from(stops >= 0.0)];
    let e = SLOPE * stops.abs() / (STOPS_BELOW + STOPS_ABOVE) / scale;
    let y = y_pivot + sign * scale * e / (1.0 + e * e.sqrt()).cbrt().powi(2);
    y.clamp(0.0, 1.0)
}

/// Hue of the HSV model, `0..6`, 0 for red; arbitrary for greys.
fn hue(color: Vec3) -> f32 {
    let (most, spread) = (color.max_element(), color.max_element() - color.min_element());
    let Vec3 { x: r, y: g, z: b } = color;
    let hue = match () {
        () if spread <= 0.0 => 0.0,
        () if most == r => (g - b) / spread,
        () if most == g => (b - r) / spread + 2.0,
        () => (r - g) / spread + 4.0,
    };
    around(hue)
}

/// Wraps a hue into the circle `0..6`, from at most one turn outside it.
fn around(hue: f32) -> f32 {
    if hue < 0.0 {
        hue + 6.0
    } else if hue >= 6.0 {
        hue - 6.0
    } else {
        hue
    }
}

/// Hue at a fraction of the shorter arc between two hues.
fn between_hues(from: f32, to: f32, fraction: f32) -> f32 {
    let way = around(to - from + 3.0) - 3.0;
    around(from + fraction * way)
}

/// Colour with the same largest and smallest channel and another hue.
fn with_hue(color: Vec3, hue: f32) -> Vec3 {
    let (most, least) = (color.max_element(), color.min_element());
    // Each channel is at its largest for a third of the circle, from one sixth before its own hue on.
    let share = |own: f32| (2.0 - (around(hue - own + 3.0) - 3.0).abs()).clamp(0.0, 1.0);
    least + (most - least) * Vec3::new(share(0.0), share(2.0), share(4.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_keep_white_and_undo_each_other() {
        for matrix in [REC_2020_FROM_REC_709, REC_709_FROM_REC_2020, INSET, OUTSET] {
            assert!((matrix * Vec3::ONE).abs_diff_eq(Vec3::ONE, 3e-7), "{matrix}");
        }
        assert!((REC_709_FROM_REC_2020 * REC_2020_FROM_REC_709).abs_diff_eq(Mat3::IDENTITY, 1e-6));
    }

    #[test]
    fn the_curve_meets_black_middle_grey_and_white() {
        assert_eq!(encoded(0.0), 0.0);
        assert!((encoded(MIDDLE_GREY).powf(GAMMA) - MIDDLE_GREY).abs() < 1e-6);
        assert!((encoded(MIDDLE_GREY * STOPS_ABOVE.exp2()) - 1.0).abs() < 1e-6);
        assert!(encoded(MIDDLE_GREY * (-STOPS_BELOW).exp2()) < 1e-6);
    }

    #[test]
    fn hues_are_those_of_the_color_circle() {
        for (color, expected) in [
            (Vec3::X, 0.0),
            (Vec3::new(1.0, 1.0, 0.0), 1.0),
            (Vec3::Y, 2.0),
            (Vec3::Z, 4.0),
            (Vec3::new(1.0, 0.0, 0.5), 5.5),
        ] {
            assert_eq!(hue(color), expected);
            assert!(with_hue(color, expected).abs_diff_eq(color, 1e-6));
        }
        assert!((between_hues(5.5, 0.5, 0.25) - 5.75).abs() < 1e-6);
        assert!((between_hues(0.5, 5.5, 0.75) - 5.75).abs() < 1e-6);
    }
}
