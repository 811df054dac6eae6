//! Degrees 5 and 6 of radiance, for fog that scatters forward. In go moments of radiance, out comes their
//! part of the last scattering. Invariant: no other harmonic of the solution has these degrees.
//!
//! Between orders of scattering harmonics up to l = 2 suffice, with delta-M. The last scattering, towards the
//! camera, is that of radiance along each ordinate by the fog's full phase function: source function
//! integration (Stamnes & Swanson 1981, "A new look at the discrete ordinate method", section 4).

use super::grid::Corners;
use super::harmonic_basis;
use crate::color::Rgb;
use glam::DVec3;
use std::ops::Range;

/// The degrees. The quadrature integrates products of the last with light of degree 5 exactly.
const DEGREES: Range<usize> = 5..7;

/// Number of harmonics of the first degree, which change sign with the direction, and of both.
pub(crate) const HIGH_ODD: usize = 2 * DEGREES.start + 1;
pub(crate) const HIGH: usize = DEGREES.end * DEGREES.end - DEGREES.start * DEGREES.start;

/// Number of all degrees of the last scattering in fog.
pub(crate) const SEEN_DEGREES: usize = DEGREES.end;

/// Sums by channel, harmonic and node.
pub(crate) type HighSums = [[Vec<f32>; HIGH]; 3];

pub(crate) fn high_basis(direction: DVec3) -> [f64; HIGH] {
    let all = harmonic_basis(direction);
    std::array::from_fn(|index| all[DEGREES.start * DEGREES.start + index])
}

/// Moments of radiance by direction of travel, by node.
pub(crate) struct HighMoments(Vec<[f32; 3 * HIGH]>);

impl HighMoments {
    pub(crate) fn of(sums: &HighSums) -> Self {
        let of_channels = sums.as_flattened();
        let node = |node: usize| std::array::from_fn(|place| of_channels[place][node]);
        Self((0..of_channels[0].len()).map(node).collect())
    }

    /// Radiance that fog scatters into a direction, W m^-3 sr^-1 for coefficients in 1/m. The coefficients
    /// are given by degree, from 0, the direction by its basis functions.
    pub(crate) fn scattered(
        &self,
        corners: &Corners,
        towards: &[f64; HIGH],
        scattering: &[Rgb; SEEN_DEGREES],
    ) -> Rgb {
        let mut sums = [0.0; 3 * HIGH];
        for (&node, &weight) in corners.nodes.iter().zip(&corners.weights) {
            for (sum, value) in sums.iter_mut().zip(&self.0[node]) {
                *sum += weight as f32 * value;
            }
        }
        let of_channel = |channel: usize| -> f64 {
            let moments = &sums[channel * HIGH..][..HIGH];
            let product = |index: usize| towards[index] * f64::from(moments[index]);
            let (odd, even): (f64, f64) =
                ((0..HIGH_ODD).map(product).sum(), (HIGH_ODD..HIGH).map(product).sum());
            scattering[DEGREES.start][channel] * odd + scattering[DEGREES.start + 1][channel] * even
        };
        Rgb::new(of_channel(0), of_channel(1), of_channel(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The addition theorem: harmonics of one beam sum to `(2 l + 1) / 4 pi` times the Legendre polynomial of
    /// the cosine.
    #[test]
    fn a_beam_is_scattered_by_its_cosine() {
        let (travel, towards) = (DVec3::new(0.48, -0.6, 0.64), DVec3::new(-0.36, 0.8, 0.48));
        let sums: HighSums = [(); 3].map(|()| high_basis(travel).map(|value| vec![value as f32; 8]));
        let moments = HighMoments::of(&sums);
        let corners = Corners { nodes: std::array::from_fn(|node| node), weights: [0.125; 8] };
        let cos = travel.dot(towards);
        let fifth = (63.0 * cos.powi(5) - 70.0 * cos.powi(3) + 15.0 * cos) / 8.0;
        let sixth = (231.0 * cos.powi(6) - 315.0 * cos.powi(4) + 105.0 * cos.powi(2) - 5.0) / 16.0;
        for (degree, polynomial) in [(5, fifth), (6, sixth)] {
            let mut scattering = [Rgb::ZERO; SEEN_DEGREES];
            scattering[degree] = Rgb::ONE;
            let found = moments.scattered(&corners, &high_basis(towards), &scattering).x;
            let expected = (2.0 * degree as f64 + 1.0) / (4.0 * std::f64::consts::PI) * polynomial;
            assert!((found - expected).abs() < 1e-6, "{degree}: {found} {expected}");
        }
    }
}
