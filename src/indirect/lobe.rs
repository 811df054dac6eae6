//! Lobes with which surfaces gather light. In goes a cosine or a specular lobe, out come factors for
//! harmonics of radiance up to degree 4. Invariant: uniform radiance gives pi times itself, for any lobe.

use crate::ordinates::harmonics::{
    COSINE_LOBE, COSINE_LOBE_4, COUNT, DEGREE, basis, fourth_basis, irradiance_lobe, third_basis,
};
use glam::DVec3;
use std::f64::consts::PI;

/// Directions from which a surface gathers light, and their weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    axis: DVec3,
    /// Factor of each degree.
    shares: [f64; 5],
    /// Part that is subtracted for directions below the surface.
    beneath: Option<Beneath>,
}

/// Half space below a surface, which truncated harmonics of a lobe reach into. Light from there is estimated
/// by the irradiance on the surface's back.
#[derive(Clone, Copy, Debug)]
struct Beneath {
    normal: DVec3,
    /// Share of uniform light from there that the lobe gathers, in units of that irradiance.
    share: f64,
}

impl Lobe {
    /// Cosine lobe of a Lambertian surface that faces `normal`. It has no degree 3.
    pub(super) fn cosine(normal: DVec3) -> Self {
        let [first, second, third] = COSINE_LOBE;
        Self { axis: normal, shares: [first, second, third, 0.0, COSINE_LOBE_4], beneath: None }
    }

    /// Specular lobe of microfacets with glTF's `alpha` about the mirror direction. It is as wide as a power
    /// of the cosine `s = (2 / alpha^2 - 2) / 4`, whose factor for degree l is `exp(-l^2 / 2 s)` (Ramamoorthi
    /// & Hanrahan 2002, "Frequency space environment map rendering", eq. 27), and at least that of a cosine.
    /// Uniform light from above a surface that faces `normal` gives pi times its radiance, light from below
    /// nothing.
    pub(super) fn glossy(mirrored: DVec3, normal: DVec3, alpha: f64) -> Self {
        let power = 0.5 * (1.0 / (alpha * alpha) - 1.0);
        let kept = |degree: f64| PI * (-0.5 * degree * degree / power).exp();
        let shares = [PI, kept(1.0).max(COSINE_LOBE[1]), kept(2.0).max(COSINE_LOBE[2]), kept(3.0), kept(4.0)];
        Self { axis: mirrored, shares, beneath: None }.above(normal)
    }

    /// Lobe with degrees up to 2 alone, for light without higher ones.
    pub(super) fn up_to_second(self) -> Self {
        let [first, second, third, ..] = self.shares;
        let cut = Self { shares: [first, second, third, 0.0, 0.0], ..self };
        self.beneath.map_or(cut, |beneath| cut.above(beneath.normal))
    }

    fn above(self, normal: DVec3) -> Self {
        let cos = self.axis.dot(normal).max(0.0);
        // A half sphere of uniform light is 1/2 + 3/4 P1 - 7/16 P3, without degrees 2 and 4.
        let third = 0.5 * cos * (5.0 * cos * cos - 3.0);
        let beneath =
            0.5 * self.shares[0] - 0.75 * self.shares[1] * cos + 7.0 / 16.0 * self.shares[3] * third;
        Self { beneath: Some(Beneath { normal, share: beneath / PI }), ..self }
    }

    /// Normal of the lobe's surface.
    pub(super) fn normal(&self) -> DVec3 {
        self.beneath.map_or(self.axis, |beneath| beneath.normal)
    }

    /// Factors of the moments of radiance by the direction of *travel*, up to degree 2.
    pub(super) fn of_travel(&self) -> [f64; COUNT] {
        let basis = basis(-self.axis);
        let all = std::array::from_fn(|index| self.shares[DEGREE[index]] * basis[index]);
        self.without_beneath(all, irradiance_lobe)
    }

    /// Whether the lobe has degree 3.
    pub(super) fn has_third(&self) -> bool {
        self.shares[3] != 0.0
    }

    /// Whether it is the cosine lobe of a surface that faces a direction.
    pub(super) fn is_cosine_of(&self, normal: DVec3) -> bool {
        const SAME: f64 = 1.0 - 1e-9;
        self.beneath.is_none() && self.axis.dot(normal) > SAME
    }

    /// Factors of degree 3, if the lobe has it.
    pub(super) fn of_third_of_travel(&self) -> Option<[f64; COUNT]> {
        let all = || third_basis(-self.axis).map(|value| self.shares[3] * value);
        self.has_third().then(|| self.without_beneath(all(), |_| [0.0; COUNT]))
    }

    /// Factors of degree 4, if the lobe has it.
    pub(super) fn of_fourth_of_travel(&self) -> Option<[f64; COUNT]> {
        let of = |axis: DVec3, share: f64| fourth_basis(-axis).map(|value| share * value);
        let all = || of(self.axis, self.shares[4]);
        (self.shares[4] != 0.0).then(|| self.without_beneath(all(), |back| of(back, COSINE_LOBE_4)))
    }

    /// Subtracts the light from below; `on` returns factors of the irradiance on a surface that faces a
    /// direction.
    fn without_beneath(&self, all: [f64; COUNT], on: impl Fn(DVec3) -> [f64; COUNT]) -> [f64; COUNT] {
        let Some(Beneath { normal, share }) = self.beneath else { return all };
        let on_back = on(-normal);
        std::array::from_fn(|index| (all[index] - share * on_back[index]) / (1.0 - share))
    }

    /// Weight of parallel light along `travel`, relative to its irradiance on a plane at right angles.
    pub(super) fn of_peak(&self, travel: DVec3) -> f64 {
        (-travel.dot(self.axis)).max(0.0)
    }

    /// Whether it belongs to the side of a leaf that faces `normal`, and not to the other.
    pub(super) fn is_of_side(&self, normal: DVec3) -> bool {
        self.axis.dot(normal) >= 0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ordinates::harmonics::product;
    use crate::ordinates::quadrature::Quadrature;

    /// Light from a band above the horizon: degree 4 removes most of the other degrees' error.
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

    /// Harmonics of radiance that is uniform over a half sphere, by degree, integrated by small pieces.
    #[test]
    fn shine_sees_what_is_above_its_surface_alone() {
        let normal = DVec3::new(0.48, 0.6, -0.64);
        let (across, _) = normal.any_orthonormal_pair();
        let gathered = |lobe: &Lobe, is_from_above: bool| -> f64 {
            let (rings, steps) = (200, 400);
            let of_piece = |number: usize| {
                let height = -1.0 + (2 * (number / steps) + 1) as f64 / rings as f64;
                let (sin, cos) = (2.0 * PI * (number % steps) as f64 / steps as f64).sin_cos();
                let travel = DVec3::new(cos, sin, 0.0) * (1.0 - height * height).sqrt() + height * DVec3::Z;
                if (travel.dot(normal) < 0.0) != is_from_above {
                    return 0.0;
                }
                let none = || [0.0; COUNT];
                let degrees = [
                    (lobe.of_travel(), basis(travel)),
                    (lobe.of_third_of_travel().unwrap_or_else(none), third_basis(travel)),
                    (lobe.of_fourth_of_travel().unwrap_or_else(none), fourth_basis(travel)),
                ];
                let products = degrees.iter().flat_map(|(lobe, basis)| lobe.iter().zip(basis));
                products.map(|(a, b)| a * b).sum::<f64>() * 4.0 * PI / (rings * steps) as f64
            };
            (0..rings * steps).map(of_piece).sum()
        };
        for (alpha, slope) in [(0.1, 0.0), (0.25, 0.4), (0.6, 3.0), (1.0, 20.0)] {
            let lobe = Lobe::glossy((normal + slope * across).normalize(), normal, alpha);
            for lobe in [lobe, lobe.up_to_second()] {
                let [above, beneath] = [true, false].map(|is_from_above| gathered(&lobe, is_from_above));
                assert!((above / PI - 1.0).abs() < 0.005, "{alpha} {slope}: {above}");
                assert!((beneath / PI).abs() < 0.005, "{alpha} {slope}: {beneath}");
            }
        }
    }

    /// Upward light, as of the ground, is irradiance on a surface that faces it, and none on one that faces
    /// away.
    #[test]
    fn ordinates_share_out_halves_of_the_sphere() {
        let ordinates = Quadrature::new();
        for normal in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 0.0, 1.0), DVec3::new(0.0, -1.0, 1.0)] {
            let normal = normal.normalize();
            let (mut moments, mut fourth) = ([0.0; COUNT], [0.0; COUNT]);
            for ordinate in ordinates.iter().filter(|ordinate| ordinate.direction.dot(normal) > 0.0) {
                let bases = [basis(ordinate.direction), fourth_basis(ordinate.direction)];
                for (sums, basis) in [&mut moments, &mut fourth].into_iter().zip(bases) {
                    sums.iter_mut().zip(basis).for_each(|(sum, basis)| *sum += ordinate.weight * basis);
                }
            }
            for (facing, expected) in [(-normal, PI), (normal, 0.0)] {
                let lobe = Lobe::cosine(facing);
                let products = lobe.of_travel().into_iter().zip(moments);
                let of_fourth = lobe.of_fourth_of_travel().expect("it has").into_iter().zip(fourth);
                let irradiance: f64 = products.chain(of_fourth).map(|(lobe, moment)| lobe * moment).sum();
                assert!((irradiance - expected).abs() < 0.003 * PI, "{normal} {facing}: {irradiance}");
            }
        }
    }
}
