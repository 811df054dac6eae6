//! Discrete-to-moment and moment-to-discrete operators. In goes radiance along ordinates, out come harmonics,
//! and radiance of these along any direction. Invariant: phase functions conserve energy to rounding, as the
//! quadrature integrates all products of their harmonics exactly.

use super::double_gauss::{DoubleGauss, ORDINATES, STEPS, angle};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Number of Legendre degrees of phase functions; narrower peaks count as not scattered.
pub const DEGREES: usize = 12;
/// Number of azimuthal functions: cosines, and sines.
const WAVES: usize = 2 * DEGREES - 1;
/// Number of harmonics of all degrees.
pub const HARMONICS: usize = DEGREES * DEGREES;

/// Radiance by real spherical harmonics: by degree, then by order.
pub type Harmonics = [f64; HARMONICS];

/// Discrete-to-moment operator and its inverse.
pub(super) struct MomentOperators {
    /// Weight of each ring, and normalised associated Legendre functions.
    rings: Vec<(f64, [f64; HARMONICS])>,
    /// Value of each wave at each step.
    waves: [[f64; STEPS]; WAVES],
}

/// Index of the harmonic of a degree and an order, for its cosine or its sine.
fn place(degree: usize, order: usize, is_sine: bool) -> usize {
    let first = degree * degree;
    if order == 0 { first } else { first + 2 * order - 1 + usize::from(is_sine) }
}

impl MomentOperators {
    pub(super) fn new(ordinates: &DoubleGauss) -> Self {
        let ring = |(height, weight): (f64, f64)| (weight * TAU / STEPS as f64, associated(height));
        let wave = |wave: usize| std::array::from_fn(|step| wave_at(wave, angle(step)));
        Self { rings: ordinates.rings.map(ring).to_vec(), waves: std::array::from_fn(wave) }
    }

    /// The harmonics of radiance along the ordinates.
    pub(super) fn harmonics(&self, radiances: &[f64; ORDINATES]) -> Harmonics {
        let mut harmonics = [0.0; HARMONICS];
        for ((weight, functions), of_ring) in self.rings.iter().zip(radiances.chunks_exact(STEPS)) {
            for (number, wave) in self.waves.iter().enumerate() {
                let amount: f64 = wave.iter().zip(of_ring).map(|(wave, radiance)| wave * radiance).sum();
                for_each_degree(number, |place| harmonics[place] += weight * amount * functions[place]);
            }
        }
        harmonics
    }

    /// Radiance of harmonics along the ordinates.
    pub(super) fn radiances(&self, harmonics: &Harmonics) -> [f64; ORDINATES] {
        let mut radiances = [0.0; ORDINATES];
        for ((_, functions), of_ring) in self.rings.iter().zip(radiances.chunks_exact_mut(STEPS)) {
            for (number, wave) in self.waves.iter().enumerate() {
                let mut amount = 0.0;
                for_each_degree(number, |place| amount += harmonics[place] * functions[place]);
                of_ring.iter_mut().zip(wave).for_each(|(radiance, wave)| *radiance += amount * wave);
            }
        }
        radiances
    }
}

/// Harmonics of a single direction, a unit vector.
pub fn basis(direction: DVec3) -> Harmonics {
    let angle = direction.z.atan2(direction.x);
    let mut basis = associated(direction.y.clamp(-1.0, 1.0));
    for wave in 0..WAVES {
        let at = wave_at(wave, angle);
        for_each_degree(wave, |place| basis[place] *= at);
    }
    basis
}

/// Product of harmonics with coefficients by degree.
pub(super) fn by_degree(harmonics: &Harmonics, kept: impl Fn(usize) -> f64) -> Harmonics {
    let mut scattered = *harmonics;
    for degree in 0..DEGREES {
        let kept = kept(degree);
        scattered[degree * degree..(degree + 1) * (degree + 1)].iter_mut().for_each(|value| *value *= kept);
    }
    scattered
}

/// Value of an azimuthal function: cosines come first, then sines.
fn wave_at(wave: usize, angle: f64) -> f64 {
    if wave < DEGREES { (wave as f64 * angle).cos() } else { ((wave + 1 - DEGREES) as f64 * angle).sin() }
}

fn for_each_degree(wave: usize, mut of: impl FnMut(usize)) {
    let (order, is_sine) = if wave < DEGREES { (wave, false) } else { (wave + 1 - DEGREES, true) };
    (order..DEGREES).for_each(|degree| of(place(degree, order, is_sine)));
}

/// Associated Legendre functions, orthonormal over the sphere with their azimuthal functions, by recurrence
/// (Press et al., Numerical Recipes, 3rd edition, eq. 6.7.9).
fn associated(height: f64) -> [f64; HARMONICS] {
    let mut functions = [0.0; HARMONICS];
    let across = (1.0 - height * height).max(0.0).sqrt();
    let mut first = (0.25 / PI).sqrt();
    for order in 0..DEGREES {
        if order > 0 {
            let order = order as f64;
            first *= across * ((2.0 * order + 1.0) / (2.0 * order)).sqrt();
        }
        let (mut before, mut here) = (0.0, first);
        let factor = if order == 0 { 1.0 } else { 2.0_f64.sqrt() };
        for degree in order..DEGREES {
            for is_sine in [false, true] {
                functions[place(degree, order, is_sine)] = factor * here;
            }
            let (l, m) = ((degree + 1) as f64, order as f64);
            let along = ((4.0 * l * l - 1.0) / (l * l - m * m)).sqrt();
            let back =
                (((l - 1.0) * (l - 1.0) - m * m) / (4.0 * (l - 1.0) * (l - 1.0) - 1.0)).max(0.0).sqrt();
            (before, here) = (here, along * (height * here - back * before));
        }
    }
    functions
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_orthonormal_by_the_ordinates() {
        let ordinates = DoubleGauss::default();
        let operator = MomentOperators::new(&ordinates);
        for place in 0..HARMONICS {
            let mut one = [0.0; HARMONICS];
            one[place] = 1.0;
            let radiances = operator.radiances(&one);
            for (direction, radiance) in ordinates.directions.iter().zip(radiances).step_by(37) {
                assert!((basis(*direction)[place] - radiance).abs() < 1e-12, "{place}");
            }
            let back = operator.harmonics(&radiances);
            for (other, value) in back.iter().enumerate() {
                let expected = f64::from(u8::from(other == place));
                assert!((value - expected).abs() < 1e-12, "{place} {other}: {value}");
            }
        }
    }

    /// The addition theorem: a beam's harmonics, each degree times `g^l`, are its phase function.
    #[test]
    fn henyey_greenstein_is_a_power_by_degree() {
        let (a, b) = (DVec3::new(0.48, -0.6, 0.64), DVec3::new(-0.36, 0.8, 0.48));
        let g: f64 = 0.25;
        let scattered = by_degree(&basis(a), |degree| g.powi(degree as i32));
        let found: f64 = scattered.iter().zip(basis(b)).map(|(a, b)| a * b).sum();
        let cos = a.dot(b);
        let expected = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos).powf(1.5));
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}
