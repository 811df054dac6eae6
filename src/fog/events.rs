//! Random collisions in fog and directions of scattering. In go rays, uniform numbers and weights of the
//! channels, out come places, directions and their densities. Invariant: optical depths are inverted and no
//! sample is rejected, so a sample takes a fixed count of numbers.
//!
//! Channels share their samples. One is chosen by its weight, and the density is the mean over all of them
//! with the same weights: the balance heuristic with one sample (Veach and Guibas 1995, section 3.3; for
//! channels Wilkie et al. 2014, "Hero wavelength spectral sampling", eq. 9). So weights of samples are
//! bounded.

use super::beer_lambert::exp_minus;
use super::foggy_ray::FoggyRay;
use super::phase::{henyey_greenstein, henyey_greenstein_pdf, sample_henyey_greenstein};
use super::{FogBank, Medium};
use crate::color::Rgb;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Tolerance in inverting optical depth, relative to the whole depth.
const DEPTH_TOLERANCE: f64 = 1e-10;
/// Maximum number of steps; bisection alone needs 34.
const MOST_STEPS: usize = 40;

/// Collisions of light on a range of a ray.
#[derive(Clone, Copy, Debug)]
pub struct Losses {
    range: (f64, f64),
    /// Weighted share of each channel that collides.
    lost: Rgb,
    depth: Rgb,
    /// Share of all light that collides, `0..=1`.
    pub chance: f64,
}

/// A sampled collision in fog.
#[derive(Clone, Copy, Debug)]
pub struct Loss {
    /// Distance along the ray, metres.
    pub t: f64,
    /// Transmittance to the collision over its probability density, m.
    pub through_per_density: Rgb,
}

impl Losses {
    /// The range of the ray.
    pub fn range(&self) -> (f64, f64) {
        self.range
    }
}

impl FoggyRay<'_> {
    /// Collisions of light with the weights of its channels, up to the ray's end; `None` if there are none.
    pub fn losses(&self, weights: Rgb) -> Option<Losses> {
        let range = self.medium.range(self.ray, self.t_max)?;
        let depth = self.optical_depth(range.1);
        let lost = weights * depth.map(|depth| -(-depth).exp_m1());
        let chance = lost.element_sum() / weights.element_sum();
        (chance > 0.0).then_some(Losses { range, lost, depth, chance })
    }

    /// Samples a collision by two uniform numbers.
    pub fn sample_loss(&self, weights: Rgb, losses: &Losses, [u, v]: [f64; 2]) -> Option<Loss> {
        let Losses { range, lost, depth, .. } = *losses;
        let channel = sample_discrete(lost.to_array(), u);
        let wanted = -(v * (-depth[channel]).exp_m1()).ln_1p();
        let t = self.place_at_depth(range, wanted, |color| color[channel]);
        let through = exp_minus(self.optical_depth(t));
        let per_m = self.pdf(weights, losses, t);
        (per_m > 0.0).then(|| Loss { t, through_per_density: through / per_m })
    }

    /// Probability density of [`Self::sample_loss`] at a distance, 1/m.
    pub fn pdf(&self, weights: Rgb, losses: &Losses, t: f64) -> f64 {
        let (start, end) = losses.range;
        if t < start || end < t {
            return 0.0;
        }
        let through = exp_minus(self.optical_depth(t));
        (weights * through * self.extinction(t)).element_sum() / losses.lost.element_sum()
    }

    /// Distance within a range of the ray at which `wanted` of the range's optical depth is reached. `of`
    /// reduces a colour to one number.
    pub fn place_at_depth(&self, (start, end): (f64, f64), wanted: f64, of: impl Fn(Rgb) -> f64) -> f64 {
        let depth_to = |t: f64| of(self.optical_depth(t));
        let all = depth_to(end);
        // Newton's method, bracketed by bisection: for a single uniform bank the first step is exact.
        let (mut low, mut high) = (start, end);
        let mut t = start + (end - start) * (wanted / all);
        for _ in 0..MOST_STEPS {
            let excess = depth_to(t) - wanted;
            if excess.abs() <= DEPTH_TOLERANCE * all {
                break;
            }
            if excess > 0.0 {
                high = t
            } else {
                low = t
            }
            let newton = t - excess / of(self.extinction(t));
            t = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
        }
        t
    }
}

impl Medium {
    /// Samples the direction in which fog at a point scatters light that travels along a unit vector, by
    /// three uniform numbers. Returns it with the scattering over its density, 1/m; `None` without
    /// scattering.
    pub fn sample_scattering(
        &self,
        point: DVec3,
        travel: DVec3,
        weights: Rgb,
        u: [f64; 3],
    ) -> Option<(DVec3, Rgb)> {
        let counts = |fog: &FogBank| (weights * fog.sigma_s).element_sum() * fog.density(point);
        let all: f64 = self.banks().iter().map(counts).sum();
        let mut left = u[0] * all;
        let sampled = self.banks().iter().filter(|fog| counts(fog) > 0.0).find(|fog| {
            left -= counts(fog);
            left < 0.0
        });
        // Rounding may leave a small rest after the last of them.
        let fog = sampled.or_else(|| self.banks().iter().rfind(|fog| counts(fog) > 0.0))?;
        let (cos, _) = sample_henyey_greenstein(fog.g, u[1]);
        let (right, up) = travel.any_orthonormal_pair();
        let across = DVec2::from_angle(TAU * u[2]) * (1.0 - cos * cos).max(0.0).sqrt();
        let direction = cos * travel + across.x * right + across.y * up;
        let (mut scattered, mut density) = (Rgb::ZERO, 0.0);
        for fog in self.banks() {
            scattered += fog.sigma_s * (fog.density(point) * henyey_greenstein(cos, fog.g));
            density += counts(fog) / all * henyey_greenstein_pdf(fog.g, cos);
        }
        (density > 0.0).then(|| (direction.normalize(), scattered / density))
    }
}

/// Index of one of three, with probabilities in proportion to `counts`, for a uniform number.
fn sample_discrete(counts: [f64; 3], u: f64) -> usize {
    let mut left = u * (counts[0] + counts[1] + counts[2]);
    for (channel, count) in counts.into_iter().enumerate() {
        left -= count;
        if left < 0.0 {
            return channel;
        }
    }
    if counts[2] > 0.0 {
        2
    } else if counts[1] > 0.0 {
        1
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fog::Falloff;
    use crate::math::Ray;
    use glam::DAffine3;

    /// Coloured fog in a box, within fog that thins out with height.
    fn two_fogs() -> Medium {
        let falloff = Falloff::new(DAffine3::IDENTITY, 0.0, 2.0).expect("a real space");
        let layer = FogBank::everywhere(falloff, Rgb::new(0.3, 0.1, 0.05), Rgb::new(0.5, 0.9, 1.0), -0.3);
        let mut bank = FogBank::between(DVec3::new(1.0, -1.0, -1.0), DVec3::new(2.5, 3.0, 1.0), 1.5);
        bank.sigma_t *= Rgb::new(1.0, 0.2, 2.0);
        bank.sigma_s = bank.sigma_t * Rgb::new(0.9, 0.4, 0.7);
        bank.g = 0.8;
        Medium::new(vec![layer.expect("there is fog"), bank])
    }

    fn even(index: usize, count: usize) -> f64 {
        (index as f64 + 0.5) / count as f64
    }

    /// The mean of `f / density` over sampled places is the integral of `f`, for extinction times
    /// transmittance and its first moment.
    #[test]
    fn places_are_picked_as_densely_as_is_said() {
        let medium = two_fogs();
        let ray = Ray { origin: DVec3::ZERO, direction: DVec3::new(2.0, 1.0, 0.1).normalize() };
        for (distance, weights) in [(1.5, Rgb::ONE), (f64::INFINITY, Rgb::new(0.2, 1.0, 0.7))] {
            let along = medium.along(&ray, distance);
            let losses = along.losses(weights).expect("there is fog");
            let (mut lost, count) = (Rgb::ZERO, 300);
            for index in 0..count * count {
                let u = [even(index / count, count), even(index % count, count)];
                let loss = along.sample_loss(weights, &losses, u).expect("a place");
                assert!(loss.t >= losses.range.0 && loss.t <= losses.range.1);
                let here = loss.through_per_density * medium.extinction_at(ray.at(loss.t));
                // As the module's head says: no weight exceeds the sum of all.
                assert!((here * weights).max_element() <= (losses.lost.element_sum()) * (1.0 + 1e-9));
                lost += here / (count * count) as f64;
            }
            let expected = Rgb::ONE - medium.transmittance(ray.origin, ray.direction, losses.range.1);
            assert!((lost - expected).abs().max_element() < 2e-3, "{lost} {expected}");
        }
    }

    /// Directions are distributed by the sum of both phase functions.
    #[test]
    fn directions_are_picked_as_densely_as_is_said() {
        let medium = two_fogs();
        let (point, travel) = (DVec3::new(1.5, 0.5, 0.0), DVec3::new(0.3, -0.4, 0.2).normalize());
        let (mut scattered, mut forward) = (Rgb::ZERO, Rgb::ZERO);
        // Many numbers to choose the fog by, as one fog is chosen rarely.
        let counts = [1000, 80, 4];
        let all = counts.iter().product::<usize>();
        for index in 0..all {
            let u = [
                even(index % counts[0], counts[0]),
                even(index / counts[0] % counts[1], counts[1]),
                even(index / counts[0] / counts[1], counts[2]),
            ];
            let (direction, weight) =
                medium.sample_scattering(point, travel, Rgb::new(1.0, 0.1, 0.5), u).expect("there is fog");
            scattered += weight / all as f64;
            forward += direction.dot(travel) * weight / all as f64;
        }
        let (_, of_degrees) = medium.coefficients_at::<2>(point);
        for (found, expected) in [scattered, forward].into_iter().zip(of_degrees) {
            assert!((found / expected - 1.0).abs().max_element() < 1e-2, "{found} {expected}");
        }
    }

    #[test]
    fn where_there_is_no_fog_nothing_is_lost() {
        let medium = two_fogs();
        let up = Ray { origin: DVec3::new(0.0, 1e4, 0.0), direction: DVec3::Y };
        assert!(medium.along(&up, f64::INFINITY).losses(Rgb::ONE).is_none());
        assert!(Medium::default().along(&up, 1.0).losses(Rgb::ONE).is_none());
        assert!(medium.sample_scattering(up.origin, DVec3::X, Rgb::ONE, [0.5; 3]).is_none());
    }
}
