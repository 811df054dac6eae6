//! Real spherical harmonics up to l = 2: how radiance at a point differs by direction. In go directions, out
//! come nine numbers. Invariant: the basis is orthonormal over the sphere.

use crate::color::Rgb;
use glam::DVec3;
use std::f64::consts::PI;

/// Coefficients up to l = 2.
pub(super) const COUNT: usize = 9;

/// The degree of each coefficient.
pub(super) const DEGREE: [usize; COUNT] = [0, 1, 1, 1, 2, 2, 2, 2, 2];

/// What a clamped cosine makes of each degree (Ramamoorthi & Hanrahan 2001, "An efficient representation for
/// irradiance environment maps", eq. 8).
const COSINE_LOBE: [f64; 3] = [PI, 2.0 * PI / 3.0, PI / 4.0];

/// All basis functions of a direction.
pub(super) fn basis(direction: DVec3) -> [f64; COUNT] {
    const Y0: f64 = 0.282_094_791_773_878_14;
    const Y1: f64 = 0.488_602_511_902_919_9;
    const Y2: f64 = 1.092_548_430_592_079_2;
    const Y20: f64 = 0.315_391_565_252_520_05;
    const Y22: f64 = 0.546_274_215_296_039_6;
    let DVec3 { x, y, z } = direction;
    [
        Y0,
        Y1 * y,
        Y1 * z,
        Y1 * x,
        Y2 * x * y,
        Y2 * y * z,
        Y20 * (3.0 * z * z - 1.0),
        Y2 * x * z,
        Y22 * (x * x - y * y),
    ]
}

/// What a surface that scatters evenly, and faces `normal`, sends out per unit of its
/// radiosity times its area.
pub(super) fn cosine_lobe(normal: DVec3) -> [f64; COUNT] {
    let basis = basis(normal);
    std::array::from_fn(|index| COSINE_LOBE[DEGREE[index]] * basis[index])
}

/// What irradiance on a surface that faces `normal` is of the moments of radiance by the
/// direction of *travel*.
pub(super) fn irradiance_lobe(normal: DVec3) -> [f64; COUNT] {
    cosine_lobe(-normal)
}

/// From where a surface gathers light, and how evenly.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    /// The direction about which it does.
    pub(super) axis: DVec3,
    /// What it makes of each degree; of even light pi times its radiance.
    shares: [f64; 3],
}

impl Lobe {
    /// By the cosine: what a matte surface that faces `normal` gathers.
    pub(super) fn cosine(normal: DVec3) -> Self {
        Self { axis: normal, shares: COSINE_LOBE }
    }

    /// As microfacets of glTF's `alpha` reflect what comes about the mirrored direction. About it they
    /// are as wide as a power of the cosine `s = (2 / alpha^2 - 2) / 4`, of which degree l keeps
    /// `exp(-l^2 / 2 s)` (Ramamoorthi & Hanrahan 2002, "Frequency space environment map rendering", eq.
    /// 27); never less than of a cosine.
    pub(super) fn glossy(mirrored: DVec3, alpha: f64) -> Self {
        let power = 0.5 * (1.0 / (alpha * alpha) - 1.0);
        let kept = |degree: f64| (-0.5 * degree * degree / power).exp();
        let shares = [PI, (PI * kept(1.0)).max(COSINE_LOBE[1]), (PI * kept(2.0)).max(COSINE_LOBE[2])];
        Self { axis: mirrored, shares }
    }

    /// Of the moments of radiance by the direction of *travel*.
    pub(super) fn of_travel(&self) -> [f64; COUNT] {
        let basis = basis(-self.axis);
        std::array::from_fn(|index| self.shares[DEGREE[index]] * basis[index])
    }
}

/// What a lobe gathers of moments, by channel; nothing where harmonics cut short would have less.
#[inline]
pub(super) fn by_lobe(lobe: &[f64; COUNT], moments: &[[f32; COUNT]; 3]) -> Rgb {
    let lobe = lobe.map(|value| value as f32);
    let of_channel =
        |channel: usize| -> f32 { (0..COUNT).map(|index| lobe[index] * moments[channel][index]).sum() };
    Rgb::new(f64::from(of_channel(0)), f64::from(of_channel(1)), f64::from(of_channel(2))).max(Rgb::ZERO)
}

#[cfg(test)]
mod tests {
    use super::super::ordinates::Ordinates;
    use super::*;

    #[test]
    fn the_basis_is_orthonormal_by_the_ordinates() {
        let ordinates = Ordinates::new();
        for i in 0..COUNT {
            for j in 0..COUNT {
                let product: f64 = ordinates
                    .iter()
                    .map(|ordinate| {
                        ordinate.weight * basis(ordinate.direction)[i] * basis(ordinate.direction)[j]
                    })
                    .sum();
                let expected = f64::from(u8::from(i == j));
                assert!((product - expected).abs() < 1e-12, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn even_light_gives_pi_times_its_radiance() {
        let moments = Ordinates::new().iter().fold([0.0; COUNT], |sum: [f64; COUNT], ordinate| {
            std::array::from_fn(|index| sum[index] + ordinate.weight * basis(ordinate.direction)[index])
        });
        let lobe = irradiance_lobe(DVec3::new(0.48, -0.6, 0.64));
        let irradiance: f64 = (0..COUNT).map(|index| lobe[index] * moments[index]).sum();
        assert!((irradiance - PI).abs() < 1e-12, "{irradiance}");
    }
}
