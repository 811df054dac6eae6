//! The unit disc as the image of the unit square. Invariant: equal areas go to equal areas.

use glam::DVec2;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A point of `[0, 1]^2` in the unit disc: squares about the middle become circles (Shirley & Chiu
/// 1997, "A Low Distortion Map Between Disk and Square").
pub fn disc_from_square(square: DVec2) -> DVec2 {
    let DVec2 { x, y } = 2.0 * square - 1.0;
    if x == 0.0 && y == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, FRAC_PI_2 - FRAC_PI_4 * (x / y)) };
    radius * DVec2::from_angle(angle)
}

/// The way back: a point of the unit disc in `[0, 1]^2`.
pub fn square_from_disc(disc: DVec2) -> DVec2 {
    let radius = disc.length();
    // The quarter that `disc_from_square` took x or y for the radius of, signs included.
    let (x, y) = if disc.x.abs() > disc.y.abs() {
        let radius = radius.copysign(disc.x);
        (radius, radius * (disc.y / disc.x).atan() / FRAC_PI_4)
    } else if disc.y != 0.0 {
        let radius = radius.copysign(disc.y);
        (radius * (disc.x / disc.y).atan() / FRAC_PI_4, radius)
    } else {
        (0.0, 0.0)
    };
    (0.5 * (DVec2::new(x, y) + 1.0)).clamp(DVec2::ZERO, DVec2::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    #[test]
    fn there_and_back() {
        for sample in 0..1000 {
            let square = DVec2::from(Sampler::new(4, 0, 0, sample).next_2d());
            let back = square_from_disc(disc_from_square(square));
            assert!(back.distance(square) < 1e-14, "{square} {back}");
        }
        assert_eq!(square_from_disc(DVec2::ZERO), DVec2::splat(0.5));
    }

    /// The moments of a uniform disc: E[x] = E[xy] = 0, E[x^2] = E[y^2] = 1/4, E[r^4] = 1/3.
    #[test]
    fn uniform_over_the_disc() {
        let count = 1 << 14;
        let mut moments = [0.0; 6];
        for sample in 0..count {
            let p = disc_from_square(Sampler::new(3, 0, 0, sample).next_2d().into());
            assert!(p.length() <= 1.0 + 1e-15);
            let found = [p.x, p.y, p.x * p.y, p.x * p.x, p.y * p.y, p.length_squared().powi(2)];
            for (sum, value) in moments.iter_mut().zip(found) {
                *sum += value / f64::from(count);
            }
        }
        for (found, expected) in moments.into_iter().zip([0.0, 0.0, 0.0, 0.25, 0.25, 1.0 / 3.0]) {
            assert!((found - expected).abs() < 1e-3, "{moments:?}");
        }
    }
}
