//! All fog together, for points and rays. In go places, out come optical depths, densities and the range of
//! fog. Invariant: where banks overlap their coefficients add up, and so do their optical depths.

use super::beer_lambert::exp_minus;
use super::phase::{henyey_greenstein, scattered_before};
use super::{Emitter, FogBank};
use crate::color::Rgb;
use crate::light::LightPlace;
use crate::math::Ray;
use crate::scene::MOST_FOGS;
use glam::DVec3;

/// All fog of a scene at one time.
#[derive(Clone, Debug, Default)]
pub struct Medium {
    banks: Vec<FogBank>,
    pub(super) emitters: Vec<Emitter>,
}

impl Medium {
    /// Medium of several banks.
    pub fn new(banks: Vec<FogBank>) -> Self {
        debug_assert!(banks.len() <= MOST_FOGS, "a scene that exists has no more");
        Self { banks, emitters: Vec::new() }
    }

    /// Medium with emitters in it.
    pub fn with_emitters(self, emitters: Vec<Emitter>) -> Self {
        Self { emitters, ..self }
    }

    /// The banks.
    pub fn banks(&self) -> &[FogBank] {
        &self.banks
    }

    /// Whether some fog has no bounds.
    pub fn is_unbounded(&self) -> bool {
        self.banks.iter().any(|bank| !bank.is_bounded())
    }

    /// Whether there is no fog and no emission.
    pub fn is_empty(&self) -> bool {
        self.banks.is_empty() && self.emitters.is_empty()
    }

    /// Whether all fog is uniform.
    pub(super) fn is_even(&self) -> bool {
        self.banks.iter().all(FogBank::is_even)
    }

    /// Whether some fog has voxels.
    pub fn has_voxels(&self) -> bool {
        self.banks.iter().any(|fog| fog.voxels().is_some())
    }

    /// Sum of the maximum extinctions of all banks, in the channel where it is largest, 1/m.
    pub fn most_extinction_per_m(&self) -> f64 {
        self.banks.iter().map(|fog| fog.sigma_t.max_element()).sum()
    }

    /// The same over all time, however keys change densities.
    pub fn most_ever_per_m(&self) -> f64 {
        self.banks.iter().map(FogBank::most_ever_per_m).sum()
    }

    /// Bounds of all bounded banks, in relative space.
    pub fn all_bounds(&self) -> impl Iterator<Item = (DVec3, DVec3)> {
        let banks = self.banks.iter().filter_map(FogBank::bounds);
        banks.chain(self.emitters.iter().map(Emitter::bounds))
    }

    /// Whether some fog emits.
    pub fn emits(&self) -> bool {
        !self.emitters.is_empty()
    }

    /// Emission at a point in every direction, W m^-3 sr^-1.
    pub fn emission_at(&self, point: DVec3) -> Rgb {
        self.emitters.iter().map(|emitter| emitter.at(point)).sum()
    }

    /// Optical depth of `origin + t * direction`, `0 < t < t_max`, for a unit direction.
    pub fn optical_depth(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_t * fog.length(origin, direction, t_max)).sum()
    }

    /// Transmittance (Beer-Lambert).
    pub fn transmittance(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Rgb {
        if self.is_empty() {
            return Rgb::ONE;
        }
        exp_minus(self.optical_depth(origin, direction, t_max))
    }

    /// Optical depth of a ray up to a distance, with averaged voxels: accurate enough for grids of light.
    pub fn rough_optical_depth(&self, ray: &Ray, t_max: f64) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_t * fog.rough_length(ray, t_max)).sum()
    }

    /// Range of a ray's line inside each bank.
    pub fn spans(&self, ray: &Ray) -> Vec<Option<(f64, f64)>> {
        self.banks.iter().map(|fog| fog.span(ray)).collect()
    }

    /// Optical depth between two places on a ray that are near each other, with its spans. Voxels count with
    /// their density halfway.
    pub fn optical_depth_between(
        &self,
        (ray, spans): (&Ray, &[Option<(f64, f64)>]),
        start: f64,
        end: f64,
    ) -> Rgb {
        let metres = |fog: &FogBank, span: Option<(f64, f64)>| match (fog.voxels(), span) {
            (Some(_), _) => (end - start) * fog.density(ray.at(0.5 * (start + end))),
            (None, Some((enter, leave))) => fog.metres(ray, enter.max(start), leave.min(end)),
            (None, None) => 0.0,
        };
        self.banks.iter().zip(spans).map(|(fog, span)| fog.sigma_t * metres(fog, *span)).sum()
    }

    /// Approximate optical depth of a ray up to the sky, for one of many random directions.
    pub fn optical_depth_to_sky(&self, ray: &Ray) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_t * fog.length_to_sky(ray)).sum()
    }

    /// Transmittance from a light to a point, given by direction and distance; for suns from depths that
    /// voxels have precomputed.
    pub fn transmittance_from(&self, point: DVec3, to_light: DVec3, distance: f64) -> Rgb {
        let metres = |fog: &FogBank| {
            let known = if distance == f64::INFINITY { fog.metres_to_sun(point, to_light) } else { None };
            known.unwrap_or_else(|| fog.length(point, to_light, distance))
        };
        exp_minus(self.banks.iter().map(|fog| fog.sigma_t * metres(fog)).sum())
    }

    /// Shortest length of a voxel along a ray, metres; `None` without voxels.
    pub fn voxel_m(&self, ray: &Ray) -> Option<f64> {
        self.banks.iter().filter_map(|fog| Some(fog.voxels()?.voxel_m(ray))).reduce(f64::min)
    }

    /// Whether both consist of the same voxels alone.
    pub fn is_same_voxels(&self, other: &Self) -> bool {
        let pairs = self.banks.iter().zip(&other.banks);
        self.banks.len() == other.banks.len()
            && pairs.into_iter().all(|(own, others)| own.is_same_voxels(others))
    }

    /// Optical depth from a point to the light; for a lamp from lattices of voxels where there are some.
    pub(super) fn known_depth_to(&self, point: DVec3, light: LightPlace) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_t * fog.known_metres_to(point, light)).sum()
    }

    /// Medium with precomputed optical depths to lights at these places.
    pub fn lit_by(self, lights: &[LightPlace]) -> Self {
        Self { banks: self.banks.into_iter().map(|bank| bank.lit_by(lights)).collect(), ..self }
    }

    /// Range of the ray within `[0, t_max]` that has visible fog; `None` if there is none. It is finite, even
    /// for infinite rays and fog.
    pub fn range(&self, ray: &Ray, t_max: f64) -> Option<(f64, f64)> {
        let spans = self.banks.iter().filter_map(|fog| fog.visible_span(ray, t_max));
        spans.reduce(|(a, b), (enter, leave)| (a.min(enter), b.max(leave)))
    }

    /// Light scattered per metre at a point, per unit of irradiance and steradian:
    /// `sum(sigma_s * phase)`, 1/(m sr).
    pub fn scattering_at(&self, point: DVec3, cos_deflection: f64) -> Rgb {
        self.scattering_by(point, |g| henyey_greenstein(cos_deflection, g))
    }

    /// Scattering as in [`Self::scattering_at`], of light that forward peaks have scattered `times` before;
    /// see [`scattered_before`].
    pub fn scattering_again_at(&self, point: DVec3, cos_deflection: f64, times: f64) -> Rgb {
        self.scattering_by(point, |g| scattered_before(cos_deflection, g, times))
    }

    fn scattering_by(&self, point: DVec3, phase: impl Fn(f64) -> f64) -> Rgb {
        self.banks
            .iter()
            .map(|fog| (fog, fog.density(point)))
            .filter(|(_, density)| *density > 0.0)
            .map(|(fog, density)| fog.sigma_s * (density * phase(fog.g)))
            .sum()
    }

    /// Extinction at a point, and the scattering coefficient of each degree, 1/m: `sum(sigma_s g^degree)`.
    pub fn coefficients_at<const DEGREES: usize>(&self, point: DVec3) -> (Rgb, [Rgb; DEGREES]) {
        let (mut extinction, mut scattering) = (Rgb::ZERO, [Rgb::ZERO; DEGREES]);
        for fog in &self.banks {
            let density = fog.density(point);
            extinction += density * fog.sigma_t;
            let mut sent_on = density * fog.sigma_s;
            for of_degree in &mut scattering {
                *of_degree += sent_on;
                sent_on *= fog.g;
            }
        }
        (extinction, scattering)
    }

    /// Forward peak of scattering, 1/m: the part that harmonics below a degree cannot tell from
    /// unscattered light, `sum(sigma_s g^degree)`.
    pub fn peak_at(&self, point: DVec3, degree: i32) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_s * (fog.density(point) * fog.forward_peak(degree))).sum()
    }

    /// Delta-M scaled medium: light of that peak counts as unscattered.
    pub fn without_peaks(&self, degree: i32) -> Self {
        Self::new(self.banks.iter().map(|bank| bank.without_peak(degree)).collect())
    }

    /// Fog that differs with height alone, and all other fog. The former are unbounded banks, or slabs where
    /// there are none; `ground` has the bounds of all ground as wide as its argument.
    pub fn layers_and_rest(&self, ground: &dyn Fn(f64) -> Option<(DVec3, DVec3)>) -> (Self, Self) {
        let (mut layers, mut rest) = (Vec::new(), Vec::new());
        for bank in &self.banks {
            let layer = match self.is_unbounded() {
                true => (!bank.is_bounded()).then(|| bank.clone()),
                false => bank.without_sides(ground),
            };
            match layer {
                Some(layer) => layers.push(layer),
                None => rest.push(bank.clone()),
            }
        }
        (Self::new(layers), Self::new(rest).with_emitters(self.emitters.clone()))
    }

    /// Each bank by itself.
    pub fn each(&self) -> impl Iterator<Item = Self> {
        self.banks.iter().map(|bank| Self::new(vec![bank.clone()]))
    }

    /// Extinction at a point, 1/m.
    pub fn extinction_at(&self, point: DVec3) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_t * fog.density(point)).sum()
    }

    /// Henyey-Greenstein g of the fog at a point: the mean over banks, weighted by scattering.
    pub fn anisotropy_at(&self, point: DVec3) -> f64 {
        let (mut weighted, mut all) = (0.0, 0.0);
        for fog in &self.banks {
            let scatters = fog.sigma_s.element_sum() * fog.density(point);
            weighted += scatters * fog.g;
            all += scatters;
        }
        if all > 0.0 { weighted / all } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beer_lambert_through_two_overlapping_boxes() {
        let medium = Medium::new(vec![
            FogBank::between(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5),
            FogBank::between(DVec3::new(0.0, -1.0, -1.0), DVec3::new(3.0, 1.0, 1.0), 0.2),
        ]);
        let through = medium.transmittance(DVec3::new(-5.0, 0.0, 0.0), DVec3::X, f64::INFINITY);
        assert!((through.x - (-(2.0 * 0.5 + 3.0 * 0.2_f64)).exp()).abs() < 1e-15);
        let part = medium.transmittance(DVec3::ZERO, DVec3::X, 0.5);
        assert!((part.x - (-(0.5 * 0.7_f64)).exp()).abs() < 1e-15);
    }

    #[test]
    fn a_ray_in_a_face_counts_as_inside() {
        let fog = FogBank::between(DVec3::splat(-1.0), DVec3::splat(1.0), 1.0);
        assert_eq!(fog.length(DVec3::new(-2.0, 1.0, 0.0), DVec3::X, f64::INFINITY), 2.0);
        assert_eq!(fog.length(DVec3::new(-2.0, 1.0 + 1e-12, 0.0), DVec3::X, f64::INFINITY), 0.0);
    }

    /// For points inside and outside, across faces, corners and edges.
    #[test]
    fn between_two_points_lies_as_much_as_along_the_ray() {
        let fog = FogBank::between(DVec3::new(-1.0, -2.0, 0.0), DVec3::new(3.0, 1.5, 1.0), 0.2);
        let numbers = [-4.0, -1.0, -0.3, 0.0, 0.4, 1.0, 1.5, 3.0, 5.0];
        let point = |index: usize| {
            DVec3::new(numbers[index % 9], numbers[index / 9 % 9] - 0.1, numbers[index / 81] + 0.05)
        };
        let mut crossings = 0;
        for index in 0..729 {
            let (from, to) = (point(index), point((index * 311 + 17) % 729));
            let (way, found) = (to - from, fog.length_between(from, to));
            let expected = fog.length(from, way.normalize_or_zero(), way.length());
            assert!((found - expected).abs() < 1e-12, "{from} to {to}: {found} {expected}");
            crossings += usize::from(found > 0.0 && found < way.length());
        }
        assert!(crossings > 100, "{crossings}");
    }
}
