//! Phase functions. In goes the cosine of a deflection, out comes a density per steradian. Invariant: they
//! integrate to 1 over the sphere.

use crate::math::legendre;
use std::f64::consts::PI;

/// |g| below which cosines are sampled as if the phase function were isotropic.
const EVEN: f64 = 1e-3;

/// Henyey & Greenstein 1941, eq. 2: `(1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^1.5)`, 1/sr.
///
/// `cos_deflection` is that between the directions of travel before and after, so `g > 0` scatters
/// forward; seen from the camera it is `to_light . view_direction`.
pub fn henyey_greenstein(cos_deflection: f64, g: f64) -> f64 {
    let spread = (1.0 + g * g - 2.0 * g * cos_deflection).max(0.0);
    (1.0 - g * g) / (4.0 * PI * spread * spread.sqrt())
}

/// Number of Legendre degrees that the first scattering of a sun's light keeps; its forward peak has those
/// from this one on.
pub const BEAM_DEGREES: i32 = 6;

/// Phase function of light that was scattered `times` before within delta-M's forward peak, 1/sr.
///
/// Each such scattering keeps harmonics up to that degree, L, and multiplies the others by `g^(l - L)`. So
/// the phase function's `g^l` becomes `g^(l + times (l - L))`: a wider lobe, except for the first harmonics.
pub(super) fn scattered_before(cos_deflection: f64, g: f64, times: f64) -> f64 {
    if g <= EVEN {
        return henyey_greenstein(cos_deflection, g);
    }
    let factor = g.powf(-f64::from(BEAM_DEGREES) * times);
    let wide = g.powf(1.0 + times);
    let kept = (0..).zip(legendre::<{ BEAM_DEGREES as usize }>(cos_deflection)).map(|(degree, legendre)| {
        let share = g.powi(degree) - factor * wide.powi(degree);
        f64::from(2 * degree + 1) / (4.0 * PI) * share * legendre
    });
    factor * henyey_greenstein(cos_deflection, wide) + kept.sum::<f64>()
}

/// Cosine of a deflection that a uniform number samples from [`henyey_greenstein`] (Witt 1977, "Multiple
/// scattering in reflection nebulae I", eq. 19), and its density over the sphere, 1/sr.
pub fn sample_henyey_greenstein(g: f64, u: f64) -> (f64, f64) {
    let cos = if g.abs() < EVEN {
        1.0 - 2.0 * u
    } else {
        let ratio = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
        ((1.0 + g * g - ratio * ratio) / (2.0 * g)).clamp(-1.0, 1.0)
    };
    (cos, henyey_greenstein_pdf(g, cos))
}

/// Probability density of [`sample_henyey_greenstein`] for a cosine, over the sphere, 1/sr.
pub fn henyey_greenstein_pdf(g: f64, cos_deflection: f64) -> f64 {
    henyey_greenstein(cos_deflection, if g.abs() < EVEN { 0.0 } else { g })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::gauss_legendre;

    #[test]
    fn what_was_scattered_before_has_the_harmonics_that_it_says() {
        for (g, times) in [(0.5, 1.0), (0.8, 1.0), (0.8, 1.7), (0.9, 2.5)] {
            for degree in 0..9_i32 {
                let legendre = |x: f64| legendre::<9>(x)[degree as usize];
                let density = |x: f64| 2.0 * PI * legendre(x) * scattered_before(x, g, times);
                let half_width = 1.0 / 500.0;
                let middles = (0..500).map(|piece| -1.0 + (2.0 * f64::from(piece) + 1.0) * half_width);
                let piece = |middle: f64| {
                    let nodes = gauss_legendre(8).iter();
                    nodes.map(|(x, weight)| weight * density(middle + x * half_width)).sum::<f64>()
                        * half_width
                };
                let sum: f64 = middles.map(piece).sum();
                let beyond = f64::from((degree - BEAM_DEGREES).max(0));
                let expected = g.powi(degree) * g.powf(times * beyond);
                assert!((sum - expected).abs() < 1e-6, "{g} {times} {degree}: {sum} {expected}");
            }
        }
    }

    #[test]
    fn integrates_to_one_over_the_sphere() {
        for g in [-0.9, -0.5, 0.0, 0.3, 0.5, 0.9] {
            let pieces = 2000;
            let mut sum = 0.0;
            for piece in 0..pieces {
                let half_width = 1.0 / f64::from(pieces);
                let middle = -1.0 + (2.0 * f64::from(piece) + 1.0) * half_width;
                for (node, weight) in gauss_legendre(8) {
                    let cos = middle + node * half_width;
                    sum += 2.0 * PI * weight * half_width * henyey_greenstein(cos, g);
                }
            }
            assert!((sum - 1.0).abs() < 1e-12, "g = {g}: {sum}");
        }
    }

    #[test]
    fn mean_cosine_is_g() {
        let g = 0.6;
        let pieces = 1000;
        let mut sum = 0.0;
        for piece in 0..pieces {
            let half_width = 1.0 / f64::from(pieces);
            let middle = -1.0 + (2.0 * f64::from(piece) + 1.0) * half_width;
            for (node, weight) in gauss_legendre(8) {
                let cos = middle + node * half_width;
                sum += 2.0 * PI * weight * half_width * cos * henyey_greenstein(cos, g);
            }
        }
        assert!((sum - g).abs() < 1e-12);
    }

    /// The mean of `f(cos) / density` over samples is the integral of `f` over the sphere.
    #[test]
    fn cosines_are_picked_as_densely_as_is_said() {
        for g in [-0.9, -0.5, 0.0, 5e-4, 2e-3, 0.3, 0.9] {
            let count = 100_000;
            let mut integrals = [0.0; 3];
            for index in 0..count {
                let (cos, density) = sample_henyey_greenstein(g, (f64::from(index) + 0.5) / f64::from(count));
                assert_eq!(density, henyey_greenstein_pdf(g, cos));
                for (power, sum) in integrals.iter_mut().enumerate() {
                    *sum += cos.powi(power as i32) / density / f64::from(count);
                }
            }
            for (found, expected) in integrals.into_iter().zip([4.0 * PI, 0.0, 4.0 / 3.0 * PI]) {
                assert!((found - expected).abs() < 2e-3, "g = {g}: {integrals:?}");
            }
        }
    }
}
