//! All fog together: transmittance between two points, and a ray cut into stretches on which the
//! fog's parameters are constant and the light's way through it changes smoothly. Invariant: on a
//! stretch the optical depths to the eye and to a distant light are smooth, and [`Course`] says
//! where they are more than that.

use super::falloff::Climb;
use super::fog_bank::LightPlace;
use super::{FogBank, exp_minus, henyey_greenstein};
use crate::color::Rgb;
use crate::math::Ray;
use crate::scene::MOST_FOGS;
use glam::DVec3;

/// Banks of fog; where they overlap their coefficients add up.
#[derive(Clone, Debug, Default)]
pub struct Medium {
    banks: Vec<FogBank>,
}

/// A part of a ray on which everything is smooth.
#[derive(Clone, Copy, Debug)]
pub struct Stretch {
    /// Where it begins, metres.
    pub start: f64,
    /// Where it ends, metres.
    pub end: f64,
    /// Optical depth from the ray's origin to `start`.
    tau_at_start: Rgb,
    /// Growth of it per metre, in fog whose density does not change on the way.
    even_per_m: Rgb,
    /// Bit `i` set: inside bank `i`.
    inside: u64,
    /// Bit `i` set: and its density changes on the way.
    thinning: u64,
}

/// How the optical depth from the eye over the ray to a distant light changes on a stretch.
#[derive(Clone, Copy, Debug)]
pub enum Course {
    /// In proportion to distance.
    Even,
    /// In proportion to the metres of one bank, counted at its base density: there is no other fog.
    Thinning {
        /// Its heights along the ray.
        climb: Climb,
        /// Growth of the optical depth per such metre.
        tau_per_m: Rgb,
    },
    /// Smoothly.
    Mixed,
}

impl Medium {
    /// Fog of several banks.
    pub fn new(banks: Vec<FogBank>) -> Self {
        debug_assert!(banks.len() <= MOST_FOGS, "a scene that exists has no more");
        Self { banks }
    }

    /// The banks.
    pub fn banks(&self) -> &[FogBank] {
        &self.banks
    }

    /// True if there is no fog at all.
    pub fn is_empty(&self) -> bool {
        self.banks.is_empty()
    }

    /// True if no fog thins out with height.
    pub fn is_even(&self) -> bool {
        self.banks.iter().all(FogBank::is_even)
    }

    /// Optical depth of `origin + t * direction`, `0 < t < t_max`, for a unit direction.
    pub fn optical_depth(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_t * fog.length(origin, direction, t_max)).sum()
    }

    /// The share of light that gets through (Beer-Lambert).
    pub fn transmittance(&self, origin: DVec3, direction: DVec3, t_max: f64) -> Rgb {
        if self.is_empty() {
            return Rgb::ONE;
        }
        exp_minus(self.optical_depth(origin, direction, t_max))
    }

    /// Optical depth from a point to the light.
    pub fn optical_depth_to(&self, point: DVec3, light: LightPlace) -> Rgb {
        match light {
            LightPlace::Towards(to_light) => self.optical_depth(point, to_light, f64::INFINITY),
            LightPlace::At(position) => {
                self.banks.iter().map(|fog| fog.sigma_t * fog.length_between(point, position)).sum()
            }
        }
    }

    /// First and last fog to be seen on the ray within `[0, t_max]`; `None` if there is none. Finite, also
    /// where ray and fog are not.
    pub fn range(&self, ray: &Ray, t_max: f64) -> Option<(f64, f64)> {
        let spans = self.banks.iter().filter_map(|fog| fog.visible_span(ray, t_max));
        spans.reduce(|(a, b), (enter, leave)| (a.min(enter), b.max(leave)))
    }

    /// Cuts the foggy parts of the ray within `[0, t_max]` into smooth stretches, in order.
    pub fn stretches(
        &self,
        ray: &Ray,
        t_max: f64,
        light: LightPlace,
        scratch: &mut Vec<f64>,
        out: &mut Vec<Stretch>,
    ) {
        out.clear();
        let Some((first, last)) = self.range(ray, t_max) else { return };
        let cuts = scratch;
        cuts.clear();
        cuts.extend([first, last]);
        let mut cut = |t: f64| {
            if t > first && t < last {
                cuts.push(t);
            }
        };
        for fog in &self.banks {
            if let Some((enter, leave)) = fog.visible_span(ray, t_max) {
                cut(enter);
                cut(leave);
            }
            fog.for_each_kink(ray, light, &mut cut);
        }
        cuts.sort_unstable_by(f64::total_cmp);
        cuts.dedup();
        let mut tau = Rgb::ZERO;
        for pair in cuts.windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let middle = 0.5 * (start + end);
            let mut stretch =
                Stretch { start, end, tau_at_start: tau, even_per_m: Rgb::ZERO, inside: 0, thinning: 0 };
            for (index, fog) in self.banks.iter().enumerate() {
                if fog.visible_span(ray, t_max).is_some_and(|(enter, leave)| enter < middle && middle < leave)
                {
                    stretch.inside |= 1 << index;
                    match fog.climb(ray).filter(|climb| climb.height(middle) > 0.0) {
                        Some(_) => stretch.thinning |= 1 << index,
                        None => stretch.even_per_m += fog.sigma_t,
                    }
                }
            }
            if stretch.inside != 0 {
                tau = self.tau_to_eye(&stretch, ray, end);
                out.push(stretch);
            }
        }
    }

    /// Optical depth from the ray's origin to a `t` on a stretch of it.
    pub fn tau_to_eye(&self, stretch: &Stretch, ray: &Ray, t: f64) -> Rgb {
        let even = stretch.tau_at_start + stretch.even_per_m * (t - stretch.start);
        let thinning = self
            .members(stretch.thinning)
            .filter_map(|fog| Some(fog.sigma_t * fog.climb(ray)?.metres_at_base_density(stretch.start, t)));
        thinning.fold(even, |sum, tau| sum + tau)
    }

    /// Light scattered per metre at a `t` of a stretch towards the ray's origin per unit of irradiance:
    /// `sum(sigma_s * phase)`, 1/(m sr).
    pub fn scattering(&self, stretch: &Stretch, ray: &Ray, t: f64, cos_deflection: f64) -> Rgb {
        let even = self.scattering_at_base(stretch.inside & !stretch.thinning, cos_deflection);
        let thinning = self.members(stretch.thinning).filter_map(|fog| {
            Some(fog.sigma_s * (henyey_greenstein(cos_deflection, fog.g) * fog.climb(ray)?.density(t)))
        });
        thinning.fold(even, |sum, scattering| sum + scattering)
    }

    /// The same where all fog of the stretch is as dense as at its base.
    pub fn densest_scattering(&self, stretch: &Stretch, cos_deflection: f64) -> Rgb {
        self.scattering_at_base(stretch.inside, cos_deflection)
    }

    fn scattering_at_base(&self, banks: u64, cos_deflection: f64) -> Rgb {
        self.members(banks).map(|fog| fog.sigma_s * henyey_greenstein(cos_deflection, fog.g)).sum()
    }

    /// As [`Medium::scattering`], at a point that need not lie on a stretch.
    pub fn scattering_at(&self, point: DVec3, cos_deflection: f64) -> Rgb {
        self.banks
            .iter()
            .map(|fog| (fog, fog.density(point)))
            .filter(|(_, density)| *density > 0.0)
            .map(|(fog, density)| fog.sigma_s * (density * henyey_greenstein(cos_deflection, fog.g)))
            .sum()
    }

    /// Extinction at a point, 1/m.
    pub fn extinction_at(&self, point: DVec3) -> Rgb {
        self.banks.iter().map(|fog| fog.sigma_t * fog.density(point)).sum()
    }

    /// Henyey-Greenstein g of the fog at a point, as the mean of its banks by how much they scatter.
    pub fn anisotropy_at(&self, point: DVec3) -> f64 {
        let (mut weighted, mut all) = (0.0, 0.0);
        for fog in &self.banks {
            let scatters = fog.sigma_s.element_sum() * fog.density(point);
            weighted += scatters * fog.g;
            all += scatters;
        }
        if all > 0.0 { weighted / all } else { 0.0 }
    }

    /// How the optical depth changes on a stretch under a distant light.
    pub fn course(&self, stretch: &Stretch, ray: &Ray, to_light: DVec3) -> Course {
        let middle = 0.5 * (stretch.start + stretch.end);
        let mut course = Course::Even;
        let mut count = 0;
        for (index, fog) in self.banks.iter().enumerate() {
            let is_inside = stretch.inside >> index & 1 == 1;
            if !is_inside && fog.length(ray.at(middle), to_light, f64::INFINITY) == 0.0 {
                continue;
            }
            count += 1;
            let Some(climb) = fog.climb(ray) else { continue };
            if fog.is_bounded() {
                return Course::Mixed;
            }
            // Below the base it is as dense everywhere, and the column above weighs the same.
            if climb.height(middle) <= 0.0 {
                continue;
            }
            // At height u the way to a light at the elevation k' weighs exp(-u) / k', and per metre
            // at base density u grows by k exp(u): the two exponentials cancel.
            let light_per_m = fog.climb(&Ray { origin: DVec3::ZERO, direction: to_light });
            let light_per_m = light_per_m.map_or(0.0, |climb| climb.per_m);
            course = match light_per_m > 0.0 && is_inside {
                true => {
                    Course::Thinning { climb, tau_per_m: fog.sigma_t * (1.0 - climb.per_m / light_per_m) }
                }
                false => return Course::Mixed,
            };
        }
        if count > 1 && matches!(course, Course::Thinning { .. }) { Course::Mixed } else { course }
    }

    /// Banks by a mask of their numbers.
    fn members(&self, mut mask: u64) -> impl Iterator<Item = &FogBank> {
        std::iter::from_fn(move || {
            let fog = self.banks.get(mask.trailing_zeros() as usize)?;
            mask &= mask - 1;
            Some(fog)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;

    fn fog_between(low: DVec3, high: DVec3, sigma_t: f64) -> FogBank {
        let relative_from_cube =
            DAffine3::from_translation(0.5 * (low + high)) * DAffine3::from_scale(0.5 * (high - low));
        FogBank::in_box(relative_from_cube, Rgb::splat(sigma_t), Rgb::splat(0.5), 0.3).expect("a real box")
    }

    #[test]
    fn beer_lambert_through_two_overlapping_boxes() {
        let medium = Medium::new(vec![
            fog_between(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5),
            fog_between(DVec3::new(0.0, -1.0, -1.0), DVec3::new(3.0, 1.0, 1.0), 0.2),
        ]);
        let through = medium.transmittance(DVec3::new(-5.0, 0.0, 0.0), DVec3::X, f64::INFINITY);
        assert!((through.x - (-(2.0 * 0.5 + 3.0 * 0.2_f64)).exp()).abs() < 1e-15);
        let part = medium.transmittance(DVec3::ZERO, DVec3::X, 0.5);
        assert!((part.x - (-(0.5 * 0.7_f64)).exp()).abs() < 1e-15);
    }

    #[test]
    fn a_ray_in_a_face_counts_as_inside() {
        let fog = fog_between(DVec3::splat(-1.0), DVec3::splat(1.0), 1.0);
        assert_eq!(fog.length(DVec3::new(-2.0, 1.0, 0.0), DVec3::X, f64::INFINITY), 2.0);
        assert_eq!(fog.length(DVec3::new(-2.0, 1.0 + 1e-12, 0.0), DVec3::X, f64::INFINITY), 0.0);
    }

    /// Inside and outside, across faces, corners and edges.
    #[test]
    fn between_two_points_lies_as_much_as_along_the_ray() {
        let fog = fog_between(DVec3::new(-1.0, -2.0, 0.0), DVec3::new(3.0, 1.5, 1.0), 0.2);
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

    /// Within a stretch the optical depth to the sun is linear: the middle is the mean of the ends.
    #[test]
    fn depth_to_a_distant_light_is_linear_on_each_stretch() {
        let medium = Medium::new(vec![
            fog_between(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5),
            fog_between(DVec3::new(0.0, -1.0, -1.0), DVec3::new(3.0, 1.5, 1.0), 0.2),
        ]);
        let light = LightPlace::Towards(DVec3::new(0.3, 0.8, -0.4).normalize());
        let ray =
            Ray { origin: DVec3::new(-3.0, 0.2, 0.3), direction: DVec3::new(1.0, -0.1, -0.15).normalize() };
        let (mut scratch, mut stretches) = (Vec::new(), Vec::new());
        medium.stretches(&ray, 100.0, light, &mut scratch, &mut stretches);
        assert!(stretches.len() >= 4);
        for stretch in &stretches {
            let tau = |t: f64| medium.optical_depth_to(ray.at(t), light).x;
            let inset = 1e-9 * (stretch.end - stretch.start);
            let mean = 0.5 * (tau(stretch.start + inset) + tau(stretch.end - inset));
            let middle = tau(0.5 * (stretch.start + stretch.end));
            assert!((middle - mean).abs() < 1e-8, "{stretch:?}: {middle} {mean}");
        }
        let last = stretches.last().expect("fog");
        let total = medium.tau_to_eye(last, &ray, last.end);
        assert!((total - medium.optical_depth(ray.origin, ray.direction, 100.0)).length() < 1e-14);
    }
}
