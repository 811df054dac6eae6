//! A ray's way through fog, between two breaks of the light's way. In go the sections of banks, by slice and
//! ray, out comes in-scattered light. Invariant: the optical depth to the eye and to the light together is
//! smooth.

use super::depth_line::DepthLine;
use super::depth_series::DepthSeries;
use super::lit_cells::Lit;
use super::section::{FogSection, LightWay, Line};
use super::thinning_fog::{Ascent, Column, ThinningFog};
use crate::color::Rgb;
use crate::fog::falloff::ENDLESS_M;
use crate::fog::{FogBank, henyey_greenstein};
use crate::math::{PlanarRay, Ray};

/// A bank, or its part below or above its base.
#[derive(Debug)]
pub(super) struct BankProfile {
    pub(super) bank: FogBank,
    pub(super) section: FogSection,
    /// Range of reaches in which the current ray is inside.
    pub(super) span: (f64, f64),
    /// Metres there, at the density of the base.
    pub(super) metres: f64,
    /// Scattering into the current ray there, per such metre and irradiance, 1/(m sr).
    scattering: Rgb,
}

/// Part of the light's way above a ray; `None` if there is none.
pub(super) fn above(way: LightWay, ray: &PlanarRay, reach: f64) -> Option<LightWay> {
    let ray = Line { at_axis: 0.0, growth: ray.slope };
    let lower = if way.lower.at(reach) < ray.at(reach) { ray } else { way.lower };
    (lower.at(reach) < way.upper.at(reach)).then_some(LightWay { lower, ..way })
}

/// A range of a ray on which all borders stay the same.
pub(super) struct SliceInterval<'a> {
    pub(super) banks: &'a [BankProfile],
    /// The light's way through each bank.
    pub(super) ways: &'a [Option<LightWay>],
    pub(super) ray: &'a PlanarRay,
    pub(super) start: f64,
    pub(super) end: f64,
}

impl SliceInterval<'_> {
    /// Light scattered on its lit parts, where all fog is uniform.
    #[inline(always)]
    pub(super) fn even(&self, lit: &Lit) -> Option<Rgb> {
        let (mut line, mut scattering) = (DepthLine::new(self.start), Rgb::ZERO);
        for (profile, way) in self.banks.iter().zip(self.ways) {
            self.add_even(profile, way, &mut line, &mut scattering);
        }
        if scattering == Rgb::ZERO {
            return Some(Rgb::ZERO);
        }
        Some(scattering * line.lit_integral(self.start..self.end, lit)?)
    }

    /// Light scattered on its lit parts, where some fog thins out.
    pub(super) fn thinning(&self, thinning: &mut Vec<ThinningFog>, lit: &Lit) -> Option<Rgb> {
        let (mut even, mut scattering) = (DepthLine::new(self.start), Rgb::ZERO);
        thinning.clear();
        let mut thinning_scatters = false;
        for (profile, way) in self.banks.iter().zip(self.ways) {
            let Some(heights) = profile.section.scale_heights else {
                self.add_even(profile, way, &mut even, &mut scattering);
                continue;
            };
            let BankProfile { bank: FogBank { sigma_t, .. }, scattering, .. } = *profile;
            let (is_inside, metres_before) = self.along_ray(profile);
            thinning_scatters |= is_inside && scattering != Rgb::ZERO;
            even.add(sigma_t, metres_before, 0.0);
            let way = way.and_then(|way| above(way, self.ray, self.middle()));
            let to_light = way.and_then(|way| Column::new(way, heights));
            if way.is_some() && to_light.is_none() {
                even.add(sigma_t, ENDLESS_M, 0.0);
            }
            let along_ray = is_inside.then(|| Ascent::new(&heights, self.ray, self.start));
            if to_light.is_some() || along_ray.is_some() {
                thinning.push(ThinningFog { sigma_t, scattering, along_ray, to_light });
            }
        }
        if !thinning_scatters && scattering == Rgb::ZERO {
            return Some(Rgb::ZERO);
        }
        if thinning.is_empty() {
            return Some(scattering * even.lit_integral(self.start..self.end, lit)?);
        }
        DepthSeries { even, scattering, thinning }.lit_integral(self.end, lit)
    }

    /// Adds the optical depth of a uniform bank, to the eye and to the light together, and its scattering per
    /// metre.
    #[inline(always)]
    fn add_even(
        &self,
        profile: &BankProfile,
        way: &Option<LightWay>,
        line: &mut DepthLine,
        scattering: &mut Rgb,
    ) {
        let (is_inside, mut at_start) = self.along_ray(profile);
        let mut per_reach = 0.0;
        if is_inside {
            per_reach = 1.0 / self.ray.direction.x;
            *scattering += profile.scattering;
        }
        if let Some(LightWay { upper, lower }) = way.and_then(|way| above(way, self.ray, self.middle())) {
            at_start += (upper.at(self.start) - lower.at(self.start)).min(ENDLESS_M);
            per_reach += upper.growth - lower.growth;
        }
        line.add(profile.bank.sigma_t, at_start, per_reach);
    }

    fn middle(&self) -> f64 {
        0.5 * (self.start + self.end)
    }

    /// Whether the ray is inside a bank, and the metres of the bank before the interval.
    #[inline(always)]
    fn along_ray(&self, profile: &BankProfile) -> (bool, f64) {
        let (enter, leave) = profile.span;
        let middle = self.middle();
        if enter < middle && middle < leave {
            (true, profile.metres_between(self.ray, self.start))
        } else if enter < leave && leave <= middle {
            (false, profile.metres)
        } else {
            (false, 0.0)
        }
    }
}

impl BankProfile {
    pub(super) fn new(bank: &FogBank, section: FogSection) -> Self {
        Self { bank: bank.clone(), section, span: (0.0, 0.0), metres: 0.0, scattering: Rgb::ZERO }
    }

    /// Computes the range inside of a ray that ends at a reach.
    pub(super) fn enter(&mut self, planar: &PlanarRay, ray: &Ray, end: f64) {
        let range = if self.bank.is_even() {
            (0.0, end)
        } else {
            let metres_per_reach = 1.0 / planar.direction.x;
            let span = self.bank.visible_span(ray, end * metres_per_reach);
            span.map_or((0.0, 0.0), |(enter, leave)| (enter / metres_per_reach, leave / metres_per_reach))
        };
        self.span = self.section.span_of(planar.slope, range);
        let (enter, leave) = self.span;
        if enter < leave {
            self.metres = self.metres_between(planar, leave);
            self.scattering = self.bank.sigma_s * henyey_greenstein(planar.direction.y, self.bank.g);
        }
    }

    /// Metres of this fog on the current ray up to a reach inside, at the density of the base.
    fn metres_between(&self, ray: &PlanarRay, reach: f64) -> f64 {
        let (enter, _) = self.span;
        match self.section.scale_heights {
            None => (reach - enter) / ray.direction.x,
            Some(heights) => Ascent::new(&heights, ray, enter).metres_and_density(reach - enter).0,
        }
    }
}
