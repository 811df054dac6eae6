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
const COSINE_LOBE_4: f64 = -PI / 24.0;

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

/// Basis functions of degree 4.
pub(super) fn fourth_basis(direction: DVec3) -> [f64; COUNT] {
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
    /// And of degree 4; a cosine makes nothing of degree 3, and little of others.
    of_fourth: f64,
    /// What is taken away lest it sees what the surface hides.
    beneath: Option<Beneath>,
}

/// Half of all directions, which a surface hides from a lobe that harmonics up to l = 2 make too wide. Light
/// from there is known by its irradiance on the surface's back.
#[derive(Clone, Copy, Debug)]
struct Beneath {
    /// Of the surface.
    normal: DVec3,
    /// What the lobe makes of even light from there, in units of that irradiance.
    share: f64,
}

impl Lobe {
    /// By the cosine: what a matte surface that faces `normal` gathers.
    pub(super) fn cosine(normal: DVec3) -> Self {
        Self { axis: normal, shares: COSINE_LOBE, of_fourth: COSINE_LOBE_4, beneath: None }
    }

    /// As microfacets of glTF's `alpha` reflect what comes about the mirrored direction. About it they
    /// are as wide as a power of the cosine `s = (2 / alpha^2 - 2) / 4`, of which degree l keeps
    /// `exp(-l^2 / 2 s)` (Ramamoorthi & Hanrahan 2002, "Frequency space environment map rendering", eq.
    /// 27); never less than of a cosine. Even light from above a surface that faces `normal` gives pi times
    /// its radiance, from beneath nothing.
    pub(super) fn glossy(mirrored: DVec3, normal: DVec3, alpha: f64) -> Self {
        let power = 0.5 * (1.0 / (alpha * alpha) - 1.0);
        let kept = |degree: f64| (-0.5 * degree * degree / power).exp();
        let shares = [PI, (PI * kept(1.0)).max(COSINE_LOBE[1]), (PI * kept(2.0)).max(COSINE_LOBE[2])];
        // Half a sphere of even light is 1/2 + 3/4 cos + 0 up to l = 2.
        let beneath = 0.5 * shares[0] - 0.75 * shares[1] * mirrored.dot(normal).max(0.0);
        let beneath = Some(Beneath { normal, share: beneath / PI });
        Self { axis: mirrored, shares, of_fourth: 0.0, beneath }
    }

    /// Which way the surface faces that it is of.
    pub(super) fn normal(&self) -> DVec3 {
        self.beneath.map_or(self.axis, |beneath| beneath.normal)
    }

    /// Of the moments of radiance by the direction of *travel*.
    pub(super) fn of_travel(&self) -> [f64; COUNT] {
        let basis = basis(-self.axis);
        let all = std::array::from_fn(|index| self.shares[DEGREE[index]] * basis[index]);
        let Some(Beneath { normal, share }) = self.beneath else { return all };
        let on_back = irradiance_lobe(-normal);
        std::array::from_fn(|index| (all[index] - share * on_back[index]) / (1.0 - share))
    }

    /// Of those of degree 4, if any.
    pub(super) fn of_fourth_of_travel(&self) -> Option<[f64; COUNT]> {
        (self.of_fourth != 0.0).then(|| fourth_basis(-self.axis).map(|value| self.of_fourth * value))
    }
}

/// What a lobe gathers of moments, by channel; nothing where harmonics cut short would have less.
#[inline]
pub(super) fn by_lobe(lobe: &[f64; COUNT], moments: &[[f32; COUNT]; 3]) -> Rgb {
    product(lobe, moments).max(Rgb::ZERO)
}

/// The sum of each product, by channel.
#[inline]
pub(super) fn product(lobe: &[f64; COUNT], moments: &[[f32; COUNT]; 3]) -> Rgb {
    let lobe = lobe.map(|value| value as f32);
    let of_channel =
        |channel: usize| -> f32 { (0..COUNT).map(|index| lobe[index] * moments[channel][index]).sum() };
    Rgb::new(f64::from(of_channel(0)), f64::from(of_channel(1)), f64::from(of_channel(2)))
}

#[cfg(test)]
mod tests {
    use super::super::ordinates::Ordinates;
    use super::*;

    #[test]
    fn the_basis_is_orthonormal_by_the_ordinates() {
        let ordinates = Ordinates::new();
        let all = |direction: DVec3| [basis(direction), fourth_basis(direction)].concat();
        for i in 0..2 * COUNT {
            for j in 0..2 * COUNT {
                let product: f64 = ordinates
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

    /// Light that comes from low above a horizon only: degree 4 takes most of what the others err by.
    #[test]
    fn degree_four_tells_low_light_from_light_all_over() {
        let low = |direction: DVec3| f64::from(u8::from((0.0..0.35).contains(&-direction.y)));
        let (mut moments, mut fourth) = ([[0.0; COUNT]; 3], [[0.0; COUNT]; 3]);
        let (rings, steps) = (2000, 64);
        for number in 0..rings * steps {
            let y = -1.0 + (f64::from(number / steps) + 0.5) * 2.0 / f64::from(rings);
            let angle = (f64::from(number % steps) + 0.5) * 2.0 * PI / f64::from(steps);
            let away = (1.0 - y * y).sqrt();
            let direction = DVec3::new(away * angle.cos(), y, away * angle.sin());
            let radiance = low(direction) * 4.0 * PI / f64::from(rings * steps);
            let bases = [basis(direction), fourth_basis(direction)];
            for (sums, basis) in [&mut moments, &mut fourth].into_iter().zip(bases) {
                for index in 0..COUNT {
                    sums[0][index] += (radiance * basis[index]) as f32;
                }
            }
        }
        for (normal, expected) in [(DVec3::Y, PI * 0.35 * 0.35), (-DVec3::Y, 0.0)] {
            let lobe = Lobe::cosine(normal);
            let without = product(&lobe.of_travel(), &moments).x;
            let with = without + product(&lobe.of_fourth_of_travel().expect("it has"), &fourth).x;
            let [without, with] = [without, with].map(|found| (found - expected).abs());
            assert!(with < 0.2 * without, "{normal}: {with} {without}");
        }
    }

    #[test]
    fn shine_sees_what_is_above_its_surface_alone() {
        let normal = DVec3::new(0.48, 0.6, -0.64);
        let (across, _) = normal.any_orthonormal_pair();
        // Of even light that travels down, and up: 1/2 and 3/4 of the first two degrees.
        let half = |travel: DVec3| {
            let (own, of_travel) = (basis(DVec3::Z)[0], basis(travel));
            let l1 = 0.75 / basis(DVec3::Z)[2].powi(2);
            let moments = std::array::from_fn(|index| match DEGREE[index] {
                0 => (0.5 / own) as f32,
                1 => (l1 * of_travel[index]) as f32,
                _ => 0.0,
            });
            [moments; 3]
        };
        for (alpha, slope) in [(0.1, 0.0), (0.25, 0.4), (0.6, 3.0), (1.0, 20.0)] {
            let lobe = Lobe::glossy((normal + slope * across).normalize(), normal, alpha).of_travel();
            let [above, beneath] = [-normal, normal].map(|travel| product(&lobe, &half(travel)).x);
            assert!((above - PI).abs() < 1e-6 && beneath.abs() < 1e-6, "{alpha} {slope}: {above} {beneath}");
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
