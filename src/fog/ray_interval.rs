//! A ray cut into intervals. In go a ray through fog and a light, out come parts on which the fog's
//! parameters are constant. Invariant: on an interval the optical depths to the eye and to the light are
//! smooth.

use super::foggy_ray::FoggyRay;
use super::phase::henyey_greenstein;
use super::{FogBank, Medium};
use crate::color::Rgb;
use crate::light::LightPlace;
use crate::math::Ray;

/// A part of a ray on which all functions are smooth.
#[derive(Clone, Copy)]
pub(super) struct RayInterval<'a> {
    pub(super) along: &'a FoggyRay<'a>,
    pub(super) medium: &'a Medium,
    pub(super) ray: &'a Ray,
    pub(super) light: LightPlace,
    /// Start and end, metres.
    pub(super) start: f64,
    pub(super) end: f64,
    /// Optical depth from the ray's origin to `start`.
    tau_at_start: Rgb,
    /// Extinction of the fog that is uniform on the interval, 1/m.
    even_per_m: Rgb,
    /// Bit `i` set: inside bank `i`.
    inside: u64,
    /// Bit `i` set: the density of bank `i` varies on the interval.
    changing: u64,
}

impl<'a> RayInterval<'a> {
    /// Cuts the foggy parts of the ray within `[0, t_max]` into smooth intervals, in order.
    pub(super) fn for_each(along: &'a FoggyRay<'a>, light: LightPlace, mut each: impl FnMut(Self)) {
        let FoggyRay { medium, ray, t_max, .. } = *along;
        let (mut tau, none) = (Rgb::ZERO, Rgb::ZERO);
        let spans: Vec<_> = medium.banks().iter().map(|fog| fog.visible_span(ray, t_max)).collect();
        for pair in cuts(along, light).windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let mut interval = Self {
                along,
                medium,
                ray,
                light,
                start,
                end,
                tau_at_start: tau,
                even_per_m: none,
                inside: 0,
                changing: 0,
            };
            let middle = interval.middle();
            for (index, fog) in medium.banks().iter().enumerate() {
                if spans[index].is_some_and(|(enter, leave)| enter < middle && middle < leave) {
                    interval.inside |= 1 << index;
                    match fog.changes_at(ray, middle) {
                        true => interval.changing |= 1 << index,
                        false => interval.even_per_m += fog.sigma_t,
                    }
                }
            }
            if interval.inside != 0 {
                tau = interval.tau_to_eye(end);
                each(interval);
            }
        }
    }

    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.start + self.end)
    }

    /// Whether it lies in a bank.
    pub(super) fn is_inside(&self, bank: usize) -> bool {
        self.inside >> bank & 1 == 1
    }

    /// Whether it lies in a cell of voxels.
    pub(super) fn is_in_a_cell(&self) -> bool {
        self.members(self.inside).any(|(number, _)| self.along.cells(number).is_some())
    }

    /// Whether it lies in one of some banks.
    pub(super) fn is_inside_of(&self, banks: u64) -> bool {
        self.inside & banks != 0
    }

    /// Whether some banks are as dense all over.
    pub(super) fn are_even(&self, banks: u64) -> bool {
        self.members(banks).all(|(_, fog)| fog.is_even())
    }

    /// Optical depth from the ray's origin over a `t` to the light.
    pub(super) fn tau(&self, t: f64) -> Rgb {
        self.tau_to_eye(t) + self.medium.known_depth_to(self.ray.at(t), self.light)
    }

    fn tau_to_eye(&self, t: f64) -> Rgb {
        let even = self.tau_at_start + self.even_per_m * (t - self.start);
        self.members(self.changing).fold(even, |sum, (number, fog)| {
            let metres = match self.along.cells(number) {
                Some(cells) => cells.metres(t) - cells.metres(self.start),
                None => fog.metres(self.ray, self.start, t),
            };
            sum + fog.sigma_t * metres
        })
    }

    /// Optical depth to eye and light and scattering, as [`Self::tau`] and [`Self::scattering`], of some of
    /// the banks alone; before the interval all of them count.
    pub(super) fn of_banks(&self, banks: u64, t: f64, cos_deflection: f64) -> (Rgb, Rgb) {
        let some = Self { inside: self.inside & banks, changing: self.changing & banks, ..*self };
        let point = self.ray.at(t);
        let to_light = |fog: &FogBank| fog.sigma_t * fog.metres_to(point, self.light);
        let tau = self.members(banks).fold(some.tau_to_eye(t), |tau, (_, fog)| tau + to_light(fog));
        (tau, some.scattering(t, cos_deflection))
    }

    /// Value at the interval's start and its growth per metre, where it is linear.
    pub(super) fn line(&self, value: impl Fn(f64) -> Rgb) -> (Rgb, Rgb) {
        // Just inside, so that a way that starts in a face is measured on this interval's side.
        let inset = 1e-3 * (self.end - self.start);
        let (a, b) = (self.start + inset, self.end - inset);
        let (at_a, at_b) = (value(a), value(b));
        let per_m = (at_b - at_a) / (b - a);
        (at_a - per_m * (a - self.start), per_m)
    }

    /// Light scattered per metre at a `t` towards the ray's origin per unit of irradiance:
    /// `sum(sigma_s * phase)`, 1/(m sr).
    pub(super) fn scattering(&self, t: f64, cos_deflection: f64) -> Rgb {
        let even = self.scattering_at_base(self.inside & !self.changing, cos_deflection);
        self.members(self.changing).fold(even, |sum, (number, fog)| {
            let cells = self.along.cells(number);
            let density = cells.map_or_else(|| fog.density_along(self.ray, t), |cells| cells.density(t));
            sum + fog.sigma_s * (henyey_greenstein(cos_deflection, fog.g) * density)
        })
    }

    /// Scattering with all its fog at maximum density.
    pub(super) fn densest_scattering(&self, cos_deflection: f64) -> Rgb {
        self.scattering_at_base(self.inside, cos_deflection)
    }

    fn scattering_at_base(&self, banks: u64, cos_deflection: f64) -> Rgb {
        self.members(banks).map(|(_, fog)| fog.sigma_s * henyey_greenstein(cos_deflection, fog.g)).sum()
    }

    /// Banks by a mask of their indices.
    fn members(&self, mask: u64) -> impl Iterator<Item = (usize, &'a FogBank)> {
        let banks = self.medium.banks().iter().enumerate();
        banks.filter(move |(index, _)| mask >> index & 1 == 1)
    }
}

/// Borders of intervals, in order.
fn cuts(along: &FoggyRay, light: LightPlace) -> Vec<f64> {
    let FoggyRay { medium, ray, t_max, .. } = *along;
    let Some((first, last)) = medium.range(ray, t_max) else { return Vec::new() };
    let mut cuts = vec![first, last];
    let mut cut = |t: f64| {
        if t > first && t < last {
            cuts.push(t);
        }
    };
    for (number, fog) in medium.banks().iter().enumerate() {
        if let Some((enter, leave)) = fog.visible_span(ray, t_max) {
            cut(enter);
            cut(leave);
        }
        match (along.cells(number), light) {
            // Light of a near lamp is fitted, and has a kink at each cell.
            (Some(cells), LightPlace::At(_)) => cells.for_each_border(&mut cut),
            _ => fog.for_each_kink(ray, light, &mut cut),
        }
    }
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Within an interval the optical depth to the sun is linear: the middle is the mean of the ends.
    #[test]
    fn depth_to_a_distant_light_is_linear_on_each_interval() {
        let medium = Medium::new(vec![
            FogBank::between(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5),
            FogBank::between(DVec3::new(0.0, -1.0, -1.0), DVec3::new(3.0, 1.5, 1.0), 0.2),
        ]);
        let light = LightPlace::Towards(DVec3::new(0.3, 0.8, -0.4).normalize());
        let ray =
            Ray { origin: DVec3::new(-3.0, 0.2, 0.3), direction: DVec3::new(1.0, -0.1, -0.15).normalize() };
        let mut intervals = Vec::new();
        let along = medium.along(&ray, 100.0);
        RayInterval::for_each(&along, light, |interval| intervals.push(interval));
        assert!(intervals.len() >= 4);
        for interval in &intervals {
            let tau = |t: f64| medium.known_depth_to(ray.at(t), light).x;
            let inset = 1e-9 * (interval.end - interval.start);
            let mean = 0.5 * (tau(interval.start + inset) + tau(interval.end - inset));
            let middle = tau(0.5 * (interval.start + interval.end));
            assert!((middle - mean).abs() < 1e-8, "{} to {}: {middle} {mean}", interval.start, interval.end);
        }
        let last = intervals.last().expect("fog");
        let total = last.tau_to_eye(last.end);
        assert!((total - medium.optical_depth(ray.origin, ray.direction, 100.0)).length() < 1e-14);
    }
}
