//! Real spherical harmonics up to l = 2, for radiance by direction. In go directions, out come nine numbers.
//! Invariant: the basis is orthonormal over the sphere.

use crate::color::Rgb;
use glam::DVec3;
use std::f64::consts::PI;

/// Coefficients up to l = 2.
pub(crate) const COUNT: usize = 9;

pub(crate) const DEGREE: [usize; COUNT] = [0, 1, 1, 1, 2, 2, 2, 2, 2];

/// Clamped cosine by degree (Ramamoorthi & Hanrahan 2001, "An efficient representation for
/// irradiance environment maps", eq. 8).
pub(crate) const COSINE_LOBE: [f64; 3] = [PI, 2.0 * PI / 3.0, PI / 4.0];
pub(crate) const COSINE_LOBE_4: f64 = -PI / 24.0;

pub(crate) fn basis(direction: DVec3) -> [f64; COUNT] {
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

/// Basis functions of degree 3: seven, and two zeros.
pub(crate) fn third_basis(direction: DVec3) -> [f64; COUNT] {
    const Y33: f64 = 0.590_043_589_926_643_5;
    const Y32: f64 = 2.890_611_442_640_554;
    const Y31: f64 = 0.457_045_799_464_465_8;
    const Y30: f64 = 0.373_176_332_590_115_4;
    let DVec3 { x, y, z } = direction;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        Y33 * y * (3.0 * xx - yy),
        Y32 * x * y * z,
        Y31 * y * (5.0 * zz - 1.0),
        Y30 * z * (5.0 * zz - 3.0),
        Y31 * x * (5.0 * zz - 1.0),
        0.5 * Y32 * z * (xx - yy),
        Y33 * x * (xx - 3.0 * yy),
        0.0,
        0.0,
    ]
}

/// Basis functions of degree 4.
pub(crate) fn fourth_basis(direction: DVec3) -> [f64; COUNT] {
    const Y4: f64 = 2.503_342_941_796_704_6;
    const Y43: f64 = 1.770_130_769_779_930_4;
    const Y42: f64 = 0.946_174_695_757_56;
    const Y41: f64 = 0.669_046_543_557_289_2;
    const Y40: f64 = 0.105_785_546_915_204_3;
    const Y44: f64 = 0.625_835_735_449_176_1;
    let DVec3 { x, y, z } = direction;
    let (xx, yy, zz) = (x * x, y * y, z * z);
    [
        Y4 * x * y * (xx - yy),
        Y43 * y * z * (3.0 * xx - yy),
        Y42 * x * y * (7.0 * zz - 1.0),
        Y41 * y * z * (7.0 * zz - 3.0),
        Y40 * (35.0 * zz * zz - 30.0 * zz + 3.0),
        Y41 * x * z * (7.0 * zz - 3.0),
        0.5 * Y42 * (xx - yy) * (7.0 * zz - 1.0),
        Y43 * x * z * (xx - 3.0 * yy),
        Y44 * (xx * xx - 6.0 * xx * yy + yy * yy),
    ]
}

/// Harmonics of the emission of a Lambertian surface that faces `normal`, per unit of its radiosity times its
/// area.
pub(crate) fn cosine_lobe(normal: DVec3) -> [f64; COUNT] {
    let basis = basis(normal);
    std::array::from_fn(|index| COSINE_LOBE[DEGREE[index]] * basis[index])
}

/// Lobe for the irradiance on a surface that faces `normal`, from moments of radiance by the direction of
/// *travel*.
pub(crate) fn irradiance_lobe(normal: DVec3) -> [f64; COUNT] {
    cosine_lobe(-normal)
}

/// Lobe for the flux through a surface that faces `normal`, from moments of radiance by the direction of
/// travel, if all light comes from above the surface.
pub(crate) fn flux_lobe(normal: DVec3) -> [f64; COUNT] {
    const SHARES: [f64; 3] = [0.0, 4.0 * PI / 3.0, 0.0];
    let basis = basis(-normal);
    std::array::from_fn(|index| SHARES[DEGREE[index]] * basis[index])
}

/// Product of a lobe and moments, by channel, clamped to 0, as truncated harmonics may be negative.
#[inline]
pub(crate) fn by_lobe(lobe: &[f64; COUNT], moments: &[[f32; COUNT]; 3]) -> Rgb {
    product(lobe, moments).max(Rgb::ZERO)
}

/// The sum of each product, by channel.
#[inline]
pub(crate) fn product(lobe: &[f64; COUNT], moments: &[[f32; COUNT]; 3]) -> Rgb {
    let lobe = lobe.map(|value| value as f32);
    let of_channel =
        |channel: usize| -> f32 { (0..COUNT).map(|index| lobe[index] * moments[channel][index]).sum() };
    Rgb::new(f64::from(of_channel(0)), f64::from(of_channel(1)), f64::from(of_channel(2)))
}

#[cfg(test)]
mod tests {
    use super::super::quadrature::Quadrature;
    use super::*;

    #[test]
    fn the_basis_is_orthonormal_by_the_ordinates() {
        let quadrature = Quadrature::new();
        let third = |direction: DVec3| third_basis(direction)[..7].to_vec();
        let all = |direction| {
            [basis(direction).to_vec(), third(direction), fourth_basis(direction).to_vec()].concat()
        };
        for i in 0..25 {
            for j in 0..25 {
                let product: f64 = quadrature
                    .iter()
                    .map(|ordinate| {
                        let all = all(ordinate.direction);
                        ordinate.weight * all[i] * all[j]
                    })
                    .sum();
                let expected = f64::from(u8::from(i == j));
                assert!((product - expected).abs() < 1e-12, "{i} {j}: {product}");
            }
        }
    }

    #[test]
    fn even_light_gives_pi_times_its_radiance() {
        let moments = Quadrature::new().iter().fold([0.0; COUNT], |sum: [f64; COUNT], ordinate| {
            std::array::from_fn(|index| sum[index] + ordinate.weight * basis(ordinate.direction)[index])
        });
        let lobe = irradiance_lobe(DVec3::new(0.48, -0.6, 0.64));
        let irradiance: f64 = (0..COUNT).map(|index| lobe[index] * moments[index]).sum();
        assert!((irradiance - PI).abs() < 1e-12, "{irradiance}");
    }
}
