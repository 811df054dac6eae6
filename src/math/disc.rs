//! Equal-area maps from the unit square to the unit disc and the sphere. In go points of one, out come points
//! of the other. Invariant: equal areas go to equal areas.

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// Maps a point of `[0, 1]^2` to the unit disc: squares around the centre become circles (Shirley & Chiu
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

/// Maps a point of the unit disc to `[0, 1]^2`, the inverse of [`disc_from_square`].
pub fn square_from_disc(disc: DVec2) -> DVec2 {
    let radius = disc.length();
    // The sector in which `disc_from_square` used x or y as the radius, signs included.
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

/// Maps a point of `[0, 1]^2` to the unit sphere: the centre to +Y, the whole edge to -Y (Lambert's azimuthal
/// equal-area projection of the disc from that square: `|p| = sin(angle from +Y / 2)`).
pub fn sphere_from_square(square: DVec2) -> DVec3 {
    let disc = disc_from_square(square);
    let squared = disc.length_squared().min(1.0);
    // sin(a) = 2 sin(a / 2) cos(a / 2).
    let around = 2.0 * (1.0 - squared).sqrt() * disc;
    DVec3::new(around.x, 1.0 - 2.0 * squared, around.y)
}

/// Maps a unit vector to `[0, 1]^2`, the inverse of [`sphere_from_square`].
pub fn square_from_sphere(direction: DVec3) -> DVec2 {
    let radius = (0.5 * (1.0 - direction.y)).max(0.0).sqrt();
    let around = DVec2::new(direction.x, direction.z).try_normalize().unwrap_or(DVec2::X);
    square_from_disc(radius.min(1.0) * around)
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

    #[test]
    fn to_the_sphere_and_back() {
        for sample in 0..1000 {
            let square = DVec2::from(Sampler::new(5, 0, 0, sample).next_2d());
            let direction = sphere_from_square(square);
            assert!((direction.length() - 1.0).abs() < 1e-14);
            assert!(square_from_sphere(direction).distance(square) < 1e-7, "{square}");
        }
        assert_eq!(sphere_from_square(DVec2::splat(0.5)), DVec3::Y);
        assert_eq!(square_from_sphere(DVec3::Y), DVec2::splat(0.5));
        assert!(sphere_from_square(square_from_sphere(DVec3::NEG_Y)).distance(DVec3::NEG_Y) < 1e-7);
    }

    /// The moments of a uniform sphere: E[x] = E[xy] = 0, E[x^2] = 1/3, E[y^4] = 1/5.
    #[test]
    fn uniform_over_the_sphere() {
        let count = 1 << 14;
        let mut moments = [0.0; 8];
        for sample in 0..count {
            let p = sphere_from_square(Sampler::new(6, 0, 0, sample).next_2d().into());
            let found = [p.x, p.y, p.z, p.x * p.y, p.x * p.x, p.y * p.y, p.z * p.z, p.y.powi(4)];
            for (sum, value) in moments.iter_mut().zip(found) {
                *sum += value / f64::from(count);
            }
        }
        let third = 1.0 / 3.0;
        for (found, expected) in moments.into_iter().zip([0.0, 0.0, 0.0, 0.0, third, third, third, 0.2]) {
            assert!((found - expected).abs() < 2e-3, "{moments:?}");
        }
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
