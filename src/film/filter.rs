//! Blackman-Harris reconstruction filter. In goes a distance from the pixel's centre, out comes a weight; or
//! an offset for samples of equal weight. Invariant: the weight is that of one axis, and integrates to 1.

use std::array;
use std::f64::consts::TAU;
use std::sync::LazyLock;

/// Width of the filter in pixels, Blender's default.
const WIDTH_PX: f64 = 1.5;

/// Terms of 0 to 3 waves (Harris 1978, "On the use of windows for harmonic analysis with the discrete
/// Fourier transform", table 1, four terms, minimum).
const TERMS: [f64; 4] = [0.35875, 0.48829, 0.14128, 0.01168];

/// Entries of both tables. Interpolation is accurate to 1e-5 for weights, and to 1e-4 pixels for offsets,
/// except at the ends, where hardly any samples are.
const ENTRIES: usize = 1024;

/// Weight of a sample at a distance from the pixel's centre along one axis; 0 beyond 0.75 pixels.
pub fn weight(distance_px: f64) -> f64 {
    // One more entry than intervals, so that the last interval has two ends.
    static TABLE: LazyLock<[f64; ENTRIES + 2]> =
        LazyLock::new(|| array::from_fn(|entry| window(entry as f64 / ENTRIES as f64 * 0.5 * WIDTH_PX)));
    let at = distance_px.abs() * (ENTRIES as f64 / (0.5 * WIDTH_PX));
    if at >= ENTRIES as f64 { 0.0 } else { between(TABLE.as_slice(), at) }
}

/// Offset from the pixel's centre of a sample with the density of [`weight`], for a number in `0..1`.
pub fn offset_px(number: f64) -> f64 {
    static TABLE: LazyLock<[f64; ENTRIES + 2]> =
        LazyLock::new(|| array::from_fn(|entry| where_sum_is(entry as f64 / ENTRIES as f64)));
    between(TABLE.as_slice(), number * ENTRIES as f64)
}

/// Linear interpolation between entries of a table.
fn between(table: &[f64], at: f64) -> f64 {
    let entry = at as usize;
    table[entry] + (at - entry as f64) * (table[entry + 1] - table[entry])
}

/// Value of the filter, which integrates to 1 over its width.
fn window(distance_px: f64) -> f64 {
    let turn = TAU / WIDTH_PX * distance_px;
    let waves = (1..).zip(&TERMS[1..]).map(|(times, term)| term * (f64::from(times) * turn).cos());
    (TERMS[0] + waves.sum::<f64>()) / (TERMS[0] * WIDTH_PX)
}

/// Integral of the [`window`] up to a place.
fn sum(distance_px: f64) -> f64 {
    let turn = TAU / WIDTH_PX * distance_px;
    let waves = (1..).zip(&TERMS[1..]).map(|(times, term)| {
        let times = f64::from(times);
        term * (times * turn).sin() / (TAU * times)
    });
    0.5 + distance_px / WIDTH_PX + waves.sum::<f64>() / TERMS[0]
}

/// Inverse of [`sum`], by bisection.
fn where_sum_is(wanted: f64) -> f64 {
    let (mut low, mut high) = (-0.5 * WIDTH_PX, 0.5 * WIDTH_PX);
    for _ in 0..52 {
        let middle = 0.5 * (low + high);
        if sum(middle) < wanted {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn weights_add_up_to_one_and_end_near_nothing() {
        let steps = 3000;
        let width = 2.0 / f64::from(steps);
        let total: f64 = (0..steps).map(|step| width * weight(-1.0 + (f64::from(step) + 0.5) * width)).sum();
        assert!((total - 1.0).abs() < 1e-6, "{total}");
        assert!(weight(0.0) > 1.85 && weight(0.7499) < 4e-4 && weight(0.75) == 0.0);
    }

    /// The terms as they are written in the paper.
    #[test]
    fn is_the_window_of_the_paper() {
        for step in 0..100 {
            let place = f64::from(step) / 100.0;
            let wave = |times: f64| (times * TAU * place).cos();
            let paper = 0.35875 - 0.48829 * wave(1.0) + 0.14128 * wave(2.0) - 0.01168 * wave(3.0);
            let found = weight(WIDTH_PX * (place - 0.5));
            let expected = if step == 0 { 0.0 } else { paper / (0.35875 * WIDTH_PX) };
            assert!((found - expected).abs() < 1e-5, "{place}: {found} {expected}");
        }
    }

    proptest! {
        /// But for the outermost entries of the table, between which places are not so well known.
        #[test]
        fn samples_are_as_dense_as_the_weight(number in 0.01..0.99_f64) {
            let step = 1e-3;
            let density = step / (offset_px(number + 0.5 * step) - offset_px(number - 0.5 * step));
            let expected = weight(offset_px(number));
            prop_assert!((density / expected - 1.0).abs() < 0.1, "{density} {expected}");
            prop_assert!((sum(offset_px(number)) - number).abs() < 1e-4);
            prop_assert!((offset_px(number) + offset_px(1.0 - number)).abs() < 1e-9);
        }
    }
}
