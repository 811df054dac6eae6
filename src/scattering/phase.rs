//! Phase functions: the cosine of a deflection in, a density per steradian out. Invariant: they
//! integrate to 1 over the sphere.

use std::f64::consts::PI;

/// Henyey & Greenstein 1941, eq. 2: `(1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^1.5)`, 1/sr.
///
/// `cos_deflection` is that between the directions of travel before and after, so `g > 0` scatters
/// forward; seen from the camera it is `to_light . view_direction`.
pub fn henyey_greenstein(cos_deflection: f64, g: f64) -> f64 {
    let spread = (1.0 + g * g - 2.0 * g * cos_deflection).max(0.0);
    (1.0 - g * g) / (4.0 * PI * spread * spread.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::gauss_legendre;

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
}
