//! Quadrature for layers over ground. Out come ordinates in rings around the vertical.
//! Invariant: no ordinate is horizontal. Half spheres are integrated apart, so radiance may jump at the
//! horizon.
//!
//! The rule is double Gauss in the cosine, with equal steps of azimuth (Sykes 1951, "Approximate integration
//! of the equation of transfer"). Section 2 of Stamnes, Tsay, Wiscombe & Jayaweera 1988 has the reasons.

use crate::math::gauss_legendre;
use glam::DVec3;
use std::f64::consts::TAU;

/// Number of rings of each half sphere, and of directions of each ring.
pub(super) const RINGS: usize = 12;
pub(super) const STEPS: usize = 24;
/// Number of all rings; upward ones come first.
pub(super) const ALL_RINGS: usize = 2 * RINGS;
pub(super) const ORDINATES: usize = ALL_RINGS * STEPS;

/// The directions, +Y up.
pub(super) struct DoubleGauss {
    /// Height of each ring's unit vectors, and its share of the heights of a half sphere.
    pub(super) rings: [(f64, f64); ALL_RINGS],
    /// Unit vectors of travel.
    pub(super) directions: Vec<DVec3>,
}

impl Default for DoubleGauss {
    fn default() -> Self {
        let half = gauss_legendre(RINGS);
        let ring = |number: usize| {
            let (place, weight) = half[number % RINGS];
            let height = 0.5 * (place + 1.0);
            (if number < RINGS { height } else { -height }, 0.5 * weight)
        };
        let rings = std::array::from_fn(ring);
        let direction = |(height, step): (f64, usize)| {
            let (sin, cos) = angle(step).sin_cos();
            let across = (1.0 - height * height).sqrt();
            DVec3::new(across * cos, height, across * sin)
        };
        let directions =
            rings.iter().flat_map(|(height, _)| (0..STEPS).map(move |step| direction((*height, step))));
        Self { directions: directions.collect(), rings }
    }
}

/// Azimuth of a direction of a ring.
pub(super) fn angle(step: usize) -> f64 {
    TAU * (step as f64 + 0.5) / STEPS as f64
}

impl DoubleGauss {
    /// Numbers of the downward directions.
    pub(super) fn downward() -> std::ops::Range<usize> {
        RINGS * STEPS..ORDINATES
    }

    /// Directions that are spread evenly over the solid angle of an ordinate.
    pub(super) fn spread(&self, ordinate: usize) -> impl Iterator<Item = DVec3> {
        const SIDE: usize = 6;
        let ring = ordinate / STEPS;
        // Rings of a half sphere are in order from the highest.
        let first = ring - ring % RINGS;
        let before: f64 = (first..ring).map(|ring| self.rings[ring].1).sum();
        let sign = self.rings[ring].0.signum();
        (0..SIDE * SIDE).map(move |number| {
            let within = |place: usize| (place as f64 + 0.5) / SIDE as f64;
            let height = sign * (1.0 - before - within(number / SIDE) * self.rings[ring].1);
            let (sin, cos) =
                (angle(ordinate % STEPS) + (within(number % SIDE) - 0.5) * TAU / STEPS as f64).sin_cos();
            let across = (1.0 - height * height).max(0.0).sqrt();
            DVec3::new(across * cos, height, across * sin)
        })
    }

    /// Solid angle of an ordinate, sr.
    pub(super) fn weight(&self, ordinate: usize) -> f64 {
        self.rings[ordinate / STEPS].1 * TAU / STEPS as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn they_share_out_each_half_of_the_sphere() {
        let ordinates = DoubleGauss::default();
        let sum = |of: &dyn Fn(DVec3) -> f64, numbers: std::ops::Range<usize>| -> f64 {
            numbers.map(|number| ordinates.weight(number) * of(ordinates.directions[number])).sum()
        };
        assert!((sum(&|_| 1.0, 0..ORDINATES) - 4.0 * PI).abs() < 1e-12);
        assert!((sum(&|direction| -direction.y, DoubleGauss::downward()) - PI).abs() < 1e-12);
        // Mean of x^4 y^4 z^2 over the sphere: 3!! 3!! 1!! / 11!!.
        let even = sum(&|d| d.x.powi(4) * d.y.powi(4) * d.z.powi(2), 0..ORDINATES) / (4.0 * PI);
        assert!((even - 9.0 / 10395.0).abs() < 1e-12, "{even}");
    }
}
