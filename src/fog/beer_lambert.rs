//! Transmittance by the Beer-Lambert law. In goes an optical depth, out comes a transmittance. Invariant:
//! nothing cancels, however small the depth.

use crate::color::Rgb;

/// Optical depth beyond which nothing is visible: `exp(-40)` is 4e-18, below one rounding of the sum to which
/// it is added.
pub(super) const NOTHING_LEFT: f64 = 40.0;

/// `exp(-tau)` per channel, computed once where the channels are equal.
pub fn exp_minus(tau: Rgb) -> Rgb {
    if tau.x == tau.y && tau.y == tau.z {
        return Rgb::splat((-tau.x).exp());
    }
    Rgb::new((-tau.x).exp(), (-tau.y).exp(), (-tau.z).exp())
}

/// `exp(-x)` and its mean over `0..x`; for small x by Padé's approximation, within 2e-6 and 6e-6.
#[inline]
pub fn exp_minus_with_mean(x: Rgb) -> (Rgb, Rgb) {
    const LITTLE: f64 = 0.25;
    if x.max_element() > LITTLE {
        return (exp_minus(x), mean_transmittance_between(Rgb::ZERO, x));
    }
    let even = Rgb::ONE + x * x / 12.0;
    let below = even + 0.5 * x;
    ((even - 0.5 * x) / below, Rgb::ONE / below)
}

/// `(1 - exp(-d)) / d`, the mean of `exp(-x)` over `[0, d]`, for `d >= 0`.
pub(super) fn mean_transmittance(d: f64) -> f64 {
    if d < 1e-3 {
        // Taylor: the next term is d^4 / 120, below 1e-14.
        return 1.0 - d * (0.5 - d * (1.0 / 6.0 - d / 24.0));
    }
    -(-d).exp_m1() / d
}

/// The mean of `exp(-x)` between two depths, per channel.
pub(super) fn mean_transmittance_between(from: Rgb, to: Rgb) -> Rgb {
    let mean = |from: f64, to: f64| (-from.min(to)).exp() * mean_transmittance((to - from).abs());
    if from == Rgb::splat(from.x) && to == Rgb::splat(to.x) {
        return Rgb::splat(mean(from.x, to.x));
    }
    Rgb::new(mean(from.x, to.x), mean(from.y, to.y), mean(from.z, to.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn little_depths_have_their_exponential_and_its_mean() {
        for step in 0..=400 {
            let x = Rgb::new(0.001, 0.0005, 0.002) * f64::from(step);
            let exact = Rgb::from_array(x.to_array().map(|x| (-x).exp()));
            let (found, mean) = exp_minus_with_mean(x);
            assert!((found - exact).abs().max_element() < 2e-6, "{x}");
            let exact_mean = Rgb::from_array(x.to_array().map(mean_transmittance));
            assert!((mean - exact_mean).abs().max_element() < 1e-5, "{x}");
        }
    }
}
