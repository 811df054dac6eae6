//! Footprints of the texels of an equirectangular image. In go indices of texels, out come integrals over the
//! sphere of their weights in bilinear interpolation. Invariant: solid angles add up to 4 pi; a texel's
//! integrals are exact up to the quadrature rule.

use crate::math::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Footprints of all texels of an image that wraps across its seam and ends at its poles.
pub(super) struct Footprints {
    width: usize,
    rows: Vec<Row>,
}

/// Integrals for a row of texels, over longitudes as well.
struct Row {
    /// Solid angle of one texel, sr.
    solid_angle: f64,
    /// Components of the integrated direction: away from the axis and along it.
    across: f64,
    up: f64,
}

impl Footprints {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let step = TAU / width as f64;
        // Integral of a hat function as wide as two texels, times a cosine: step sinc^2(step / 2).
        let half = 0.5 * step;
        let of_cosine = step * (half.sin() / half).powi(2);
        let row = |row: usize| {
            let [solid_angle, across, up] = down_a_hat(row, height);
            Row { solid_angle: step * solid_angle, across: of_cosine * across, up: step * up }
        };
        Self { width, rows: (0..height).map(row).collect() }
    }

    /// Solid angle of a texel's footprint, weighted by interpolation, sr.
    pub(super) fn solid_angle(&self, texel: usize) -> f64 {
        self.rows[texel / self.width].solid_angle
    }

    /// Integrated direction of a texel's footprint: the vector irradiance of a radiance of 1 there.
    pub(super) fn directions(&self, texel: usize) -> DVec3 {
        let Row { across, up, .. } = self.rows[texel / self.width];
        let (sin, cos) = (TAU * (((texel % self.width) as f64 + 0.5) / self.width as f64 - 0.5)).sin_cos();
        DVec3::new(across * sin, up, -across * cos)
    }
}

/// Integrals over the polar angle of a row's hat function times `sin`, `sin^2` and `cos sin`.
fn down_a_hat(row: usize, height: usize) -> [f64; 3] {
    const ORDER: usize = 8;
    let step = PI / height as f64;
    let middle = (row as f64 + 0.5) * step;
    // The hat reaches to the centres of adjacent rows; the first and last row extend to the poles.
    let halves = [(row == 0, -1.0), (row + 1 == height, 1.0)];
    let mut sums = [0.0; 3];
    for (is_last, side) in halves {
        let reach = if is_last { 0.5 * step } else { step };
        for (node, weight) in gauss_legendre(ORDER) {
            let away = 0.5 * (1.0 + node) * reach;
            let hat = if is_last { 1.0 } else { 1.0 - away / step };
            let (sin, cos) = (middle + side * away).sin_cos();
            let of_all = 0.5 * reach * weight * hat * sin;
            sums = [sums[0] + of_all, sums[1] + of_all * sin, sums[2] + of_all * cos];
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Together they are the sphere, whose directions cancel out.
    #[test]
    fn footprints_add_up_to_the_sphere() {
        for (width, height) in [(1, 1), (2, 1), (7, 3), (64, 32), (301, 150)] {
            let footprints = Footprints::new(width, height);
            let all: f64 = (0..width * height).map(|texel| footprints.solid_angle(texel)).sum();
            let directions: DVec3 = (0..width * height).map(|texel| footprints.directions(texel)).sum();
            assert!((all / (4.0 * PI) - 1.0).abs() < 1e-6, "{width} x {height}: {all}");
            assert!(directions.length() < 1e-6, "{width} x {height}: {directions}");
        }
    }
}
