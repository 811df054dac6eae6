//! Fog before each of some places on a ray. In go places in order, out come optical depths and what a sun
//! scatters where nothing is in its way. Invariant: fog is by voxels alone, and depths are exact.

use super::beer_lambert::mean_transmittance_between;
use super::{FogBank, Medium};
use crate::color::Rgb;
use crate::light::LightPlace;
use crate::math::Ray;
use glam::DVec3;

/// A ray and the fog from the first of some places on it to each.
pub struct FogBefore<'a> {
    medium: &'a Medium,
    ray: &'a Ray,
    places: &'a [f64],
    /// Metres of densest fog, by bank and place.
    metres: Vec<Vec<f64>>,
}

impl Medium {
    /// The anisotropy that all of it shares; `None` if some of it is not by voxels, or differs in that.
    pub fn anisotropy_of_voxels(&self) -> Option<f64> {
        let g = self.banks().first()?.g;
        self.banks().iter().all(|fog| fog.voxels().is_some() && fog.g == g).then_some(g)
    }

    /// Fog before places on a ray, which are in order; nothing is before the first.
    pub fn before_each<'a>(&'a self, ray: &'a Ray, places: &'a [f64]) -> FogBefore<'a> {
        let voxels = self.banks().iter().filter_map(FogBank::voxels);
        let metres = voxels.map(|voxels| voxels.metres_before_each(ray, places)).collect();
        FogBefore { medium: self, ray, places, metres }
    }
}

impl FogBefore<'_> {
    /// Optical depths before each place.
    pub fn depths(&self) -> Vec<Rgb> {
        self.sums(|fog| fog.sigma_t)
    }

    /// Single scattering of a sun before each place, per unit of irradiance and of phase function. Between
    /// two places the optical depths, those to the eye in `depths` and those to the sun, count as linear.
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

    /// Metres before each place, times what a bank says.
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
