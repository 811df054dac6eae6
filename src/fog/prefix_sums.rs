//! Prefix sums of fog at places on a ray. In go places in order, out come optical depths and unshadowed
//! scattering of a sun. Invariant: all fog has voxels, and depths are exact.

use super::beer_lambert::mean_transmittance_between;
use super::{FogBank, Medium};
use crate::color::Rgb;
use crate::light::LightPlace;
use crate::math::Ray;
use glam::DVec3;

/// A ray with the fog from the first of some places on it to each.
pub struct FogBefore<'a> {
    medium: &'a Medium,
    ray: &'a Ray,
    places: &'a [f64],
    /// Metres at maximum density, by bank and place.
    metres: Vec<Vec<f64>>,
}

impl Medium {
    /// Anisotropy that all fog shares; `None` if some fog has no voxels, or another anisotropy.
    pub fn anisotropy_of_voxels(&self) -> Option<f64> {
        let g = self.banks().first()?.g;
        self.banks().iter().all(|fog| fog.voxels().is_some() && fog.g == g).then_some(g)
    }

    /// Prefix sums at places on a ray, in order; the first is 0.
    pub fn before_each<'a>(&'a self, ray: &'a Ray, places: &'a [f64]) -> FogBefore<'a> {
        let voxels = self.banks().iter().filter_map(FogBank::voxels);
        let metres = voxels.map(|voxels| voxels.metres_before_each(ray, places)).collect();
        FogBefore { medium: self, ray, places, metres }
    }
}

impl FogBefore<'_> {
    /// Optical depths up to each place.
    pub fn depths(&self) -> Vec<Rgb> {
        self.sums(|fog| fog.sigma_t)
    }

    /// Single scattering of a sun up to each place, per unit of irradiance and of phase function. Between two
    /// places the optical depths count as linear, those to the eye in `depths` and those to the sun.
    pub fn sunlight(&self, to_light: DVec3, depths: &[Rgb]) -> Vec<Rgb> {
        let scattering = self.sums(|fog| fog.sigma_s);
        let mut all_depths = depths.to_vec();
        let last = self.places.len().saturating_sub(1);
        let counts = |place: usize| scattering[place.saturating_sub(1)] != scattering[last.min(place + 1)];
        for fog in self.medium.banks() {
            let known = fog.voxels().and_then(|voxels| voxels.towards_sun(self.ray, to_light));
            let walked = |t: f64| fog.metres_to(self.ray.at(t), LightPlace::Towards(to_light));
            for (place, depth) in all_depths.iter_mut().enumerate().filter(|(place, _)| counts(*place)) {
                let t = self.places[place];
                *depth += fog.sigma_t * known.as_ref().map_or_else(|| walked(t), |metres| metres.at(t));
            }
        }
        let mut sum = Rgb::ZERO;
        let sums = scattering.windows(2).zip(all_depths.windows(2)).map(|(scattering, depths)| {
            let here = scattering[1] - scattering[0];
            if here != Rgb::ZERO {
                sum += here * mean_transmittance_between(depths[0], depths[1]);
            }
            sum
        });
        std::iter::once(Rgb::ZERO).chain(sums).collect()
    }

    /// Sum over banks of the metres up to each place, times a value of the bank.
    fn sums(&self, per_metre: impl Fn(&FogBank) -> Rgb) -> Vec<Rgb> {
        let mut sums = vec![Rgb::ZERO; self.places.len()];
        for (fog, metres) in self.medium.banks().iter().zip(&self.metres) {
            for (sum, metres) in sums.iter_mut().zip(metres) {
                *sum += per_metre(fog) * *metres;
            }
        }
        sums
    }
}
