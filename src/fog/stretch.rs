//! A ray cut into stretches. In go a ray through fog and a light, out come parts on which the
//! fog's parameters are constant. Invariant: on a stretch the optical depths to the eye and to
//! the light are smooth.

use super::phase::henyey_greenstein;
use super::{FogBank, Medium};
use crate::color::Rgb;
use crate::light::LightPlace;
use crate::math::Ray;

/// A part of a ray on which everything is smooth.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch<'a> {
    pub(super) medium: &'a Medium,
    pub(super) ray: &'a Ray,
    pub(super) light: LightPlace,
    /// Where it begins and ends, metres.
    pub(super) start: f64,
    pub(super) end: f64,
    /// Optical depth from the ray's origin to `start`.
    tau_at_start: Rgb,
    /// Growth of it per metre, in fog whose density does not change on the way.
    even_per_m: Rgb,
    /// Bit `i` set: inside bank `i`.
    inside: u64,
    /// Bit `i` set: and its density changes on the way.
    changing: u64,
}

impl<'a> Stretch<'a> {
    /// Cuts the foggy parts of the ray within `[0, t_max]` into smooth stretches, in order.
    pub(super) fn for_each(
        medium: &'a Medium,
        ray: &'a Ray,
        t_max: f64,
        light: LightPlace,
        mut each: impl FnMut(Self),
    ) {
        let (mut tau, none) = (Rgb::ZERO, Rgb::ZERO);
        let spans: Vec<_> = medium.banks().iter().map(|fog| fog.visible_span(ray, t_max)).collect();
        for pair in cuts(medium, ray, t_max, light).windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let mut stretch = Self {
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
            let middle = stretch.middle();
            for (index, fog) in medium.banks().iter().enumerate() {
                if spans[index].is_some_and(|(enter, leave)| enter < middle && middle < leave) {
                    stretch.inside |= 1 << index;
                    match fog.changes_at(ray, middle) {
                        true => stretch.changing |= 1 << index,
                        false => stretch.even_per_m += fog.sigma_t,
                    }
                }
            }
            if stretch.inside != 0 {
                tau = stretch.tau_to_eye(end);
                each(stretch);
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

    /// Optical depth from the ray's origin over a `t` to the light.
    pub(super) fn tau(&self, t: f64) -> Rgb {
        self.tau_to_eye(t) + self.medium.depth_in_fog_to(self.ray.at(t), self.light)
    }

    fn tau_to_eye(&self, t: f64) -> Rgb {
        let even = self.tau_at_start + self.even_per_m * (t - self.start);
        let changing = self.members(self.changing);
        changing.fold(even, |sum, fog| sum + fog.sigma_t * fog.metres(self.ray, self.start, t))
    }

    /// Light scattered per metre at a `t` towards the ray's origin per unit of irradiance:
    /// `sum(sigma_s * phase)`, 1/(m sr).
    pub(super) fn scattering(&self, t: f64, cos_deflection: f64) -> Rgb {
        let even = self.scattering_at_base(self.inside & !self.changing, cos_deflection);
        self.members(self.changing).fold(even, |sum, fog| {
            let density = fog.density_along(self.ray, t);
            sum + fog.sigma_s * (henyey_greenstein(cos_deflection, fog.g) * density)
        })
    }

    /// Its density as a cubic, with the bank, where that of one bank alone changes and voxels have it.
    pub(super) fn cubic(&self) -> Option<(&'a FogBank, Cubic)> {
        let mut changing = self.members(self.changing);
        let fog = changing.next().filter(|fog| fog.voxels().is_some() && changing.next().is_none())?;
        let length = self.end - self.start;
        let at = |share: f64| fog.density_along(self.ray, self.start + share * length);
        Some((fog, Cubic::through([at(0.0), at(1.0 / 3.0), at(2.0 / 3.0), at(1.0)], length)))
    }

    /// Optical depth and scattering at a `t` as [`Stretch::tau`] and [`Stretch::scattering`] have them, where
    /// the density of one bank alone changes, and is a cubic.
    pub(super) fn by_cubic(&self, t: f64, cos: f64, (fog, cubic): &(&FogBank, Cubic)) -> (Rgb, Rgb) {
        let from_start = t - self.start;
        let to_eye =
            self.tau_at_start + self.even_per_m * from_start + fog.sigma_t * cubic.integral(from_start);
        let even = self.scattering_at_base(self.inside & !self.changing, cos);
        let scattering = even + fog.sigma_s * (henyey_greenstein(cos, fog.g) * cubic.at(from_start));
        (to_eye + self.medium.depth_in_fog_to(self.ray.at(t), self.light), scattering)
    }

    /// The same where all its fog is as dense as at its base.
    pub(super) fn densest_scattering(&self, cos_deflection: f64) -> Rgb {
        self.scattering_at_base(self.inside, cos_deflection)
    }

    fn scattering_at_base(&self, banks: u64, cos_deflection: f64) -> Rgb {
        self.members(banks).map(|fog| fog.sigma_s * henyey_greenstein(cos_deflection, fog.g)).sum()
    }

    /// Banks by a mask of their numbers.
    fn members(&self, mask: u64) -> impl Iterator<Item = &'a FogBank> {
        let banks = self.medium.banks().iter().enumerate();
        banks.filter(move |(index, _)| mask >> index & 1 == 1).map(|(_, fog)| fog)
    }
}

/// A cubic from 0 to a length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cubic([f64; 4]);

impl Cubic {
    /// Through values at 0, a third, two thirds and all of the length.
    fn through([a, b, c, d]: [f64; 4], length: f64) -> Self {
        let per = if length > 0.0 { length.recip() } else { 0.0 };
        let first = (-11.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / 2.0;
        let second = (18.0 * a - 45.0 * b + 36.0 * c - 9.0 * d) / 2.0;
        let third = (-9.0 * a + 27.0 * b - 27.0 * c + 9.0 * d) / 2.0;
        Self([a, first * per, second * per * per, third * per * per * per])
    }

    fn at(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + x * (b + x * (c + x * d))
    }

    /// From 0 on.
    fn integral(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        x * (a + x * (b / 2.0 + x * (c / 3.0 + x * d / 4.0)))
    }
}

/// Where a stretch may begin or end, in order.
fn cuts(medium: &Medium, ray: &Ray, t_max: f64, light: LightPlace) -> Vec<f64> {
    let Some((first, last)) = medium.range(ray, t_max) else { return Vec::new() };
    let mut cuts = vec![first, last];
    let mut cut = |t: f64| {
        if t > first && t < last {
            cuts.push(t);
        }
    };
    for fog in medium.banks() {
        if let Some((enter, leave)) = fog.visible_span(ray, t_max) {
            cut(enter);
            cut(leave);
        }
        fog.for_each_kink(ray, light, &mut cut);
    }
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Within a stretch the optical depth to the sun is linear: the middle is the mean of the ends.
    #[test]
    fn depth_to_a_distant_light_is_linear_on_each_stretch() {
        let medium = Medium::new(vec![
            FogBank::between(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5),
            FogBank::between(DVec3::new(0.0, -1.0, -1.0), DVec3::new(3.0, 1.5, 1.0), 0.2),
        ]);
        let light = LightPlace::Towards(DVec3::new(0.3, 0.8, -0.4).normalize());
        let ray =
            Ray { origin: DVec3::new(-3.0, 0.2, 0.3), direction: DVec3::new(1.0, -0.1, -0.15).normalize() };
        let mut stretches = Vec::new();
        Stretch::for_each(&medium, &ray, 100.0, light, |stretch| stretches.push(stretch));
        assert!(stretches.len() >= 4);
        for stretch in &stretches {
            let tau = |t: f64| medium.optical_depth_to(ray.at(t), light).x;
            let inset = 1e-9 * (stretch.end - stretch.start);
            let mean = 0.5 * (tau(stretch.start + inset) + tau(stretch.end - inset));
            let middle = tau(0.5 * (stretch.start + stretch.end));
            assert!((middle - mean).abs() < 1e-8, "{stretch:?}: {middle} {mean}");
        }
        let last = stretches.last().expect("fog");
        let total = last.tau_to_eye(last.end);
        assert!((total - medium.optical_depth(ray.origin, ray.direction, 100.0)).length() < 1e-14);
    }
}
