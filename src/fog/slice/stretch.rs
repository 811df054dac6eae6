//! A ray's way through fog, between two places where the way of the light through it changes. In go the banks as the slice
//! and the ray cut them, out comes the light that is scattered on the way. Invariant: the optical depth of a stretch,
//! to the eye and to the light together, is smooth.

use super::depth_line::DepthLine;
use super::depth_series::DepthSeries;
use super::lit_cells::Lit;
use super::section::{FogSection, LightWay, Line};
use super::thinning_fog::{Ascent, Column, ThinningFog};
use crate::color::Rgb;
use crate::fog::falloff::ENDLESS_M;
use crate::fog::{FogBank, henyey_greenstein};
use crate::math::{PlanarRay, Ray};

/// A bank, or its part below its base or above it.
#[derive(Debug)]
pub(super) struct BankProfile {
    pub(super) bank: FogBank,
    pub(super) section: FogSection,
    /// Reaches between which the current ray is inside.
    pub(super) span: (f64, f64),
    /// Metres there, counted at the density of the base.
    pub(super) metres: f64,
    /// Light scattered into the current ray there, per such metre and irradiance, 1/(m sr).
    scattering: Rgb,
}

/// What of the light's way lies above a ray; `None` if nothing does.
pub(super) fn above(way: LightWay, ray: &PlanarRay, reach: f64) -> Option<LightWay> {
    let ray = Line { at_axis: 0.0, growth: ray.slope };
    let lower = if way.lower.at(reach) < ray.at(reach) { ray } else { way.lower };
    (lower.at(reach) < way.upper.at(reach)).then_some(LightWay { lower, ..way })
}

/// A part of a ray on which nothing but distances changes.
pub(super) struct Stretch<'a> {
    pub(super) banks: &'a [BankProfile],
    /// The light's way through each bank.
    pub(super) ways: &'a [Option<LightWay>],
    pub(super) ray: &'a PlanarRay,
    pub(super) start: f64,
    pub(super) end: f64,
}

impl Stretch<'_> {
    /// Light scattered on what is lit of it, where all fog is even.
    #[inline(always)]
    pub(super) fn even<const LANES: usize>(&self, lit: &Lit) -> Option<Rgb> {
        let mut scattering = Rgb::ZERO;
        let mut line = DepthLine { start: self.start, at_start: [0.0; LANES], per_reach: [0.0; LANES] };
        for (profile, way) in self.banks.iter().zip(self.ways) {
            let metres = self.metres(profile, way);
            for lane in 0..LANES {
                line.at_start[lane] += profile.bank.sigma_t[lane] * metres.at_start;
                line.per_reach[lane] += profile.bank.sigma_t[lane] * metres.per_reach;
            }
            if metres.is_inside {
                scattering += profile.scattering;
            }
        }
        if scattering == Rgb::ZERO {
            return Some(Rgb::ZERO);
        }
        Some(scattering * line.lit_integral(self.start..self.end, lit)?)
    }

    /// The same where some fog thins out.
    pub(super) fn thinning(&self, series: &mut DepthSeries, lit: &Lit) -> Option<Rgb> {
        let mut scatters = false;
        series.clear(self.start);
        for (profile, way) in self.banks.iter().zip(self.ways) {
            let sigma_t = profile.bank.sigma_t;
            let Some(heights) = profile.section.scale_heights else {
                let metres = self.metres(profile, way);
                series.tau_at_start += sigma_t * metres.at_start;
                series.tau_per_reach += sigma_t * metres.per_reach;
                if metres.is_inside {
                    series.scattering += profile.scattering;
                    scatters |= profile.scattering != Rgb::ZERO;
                }
                continue;
            };
            let (is_inside, metres_before) = self.along_ray(profile);
            scatters |= is_inside && profile.scattering != Rgb::ZERO;
            series.tau_at_start += sigma_t * metres_before;
            let way = way.and_then(|way| above(way, self.ray, self.middle()));
            let to_light = way.and_then(|way| Column::new(way, heights));
            if way.is_some() && to_light.is_none() {
                series.tau_at_start += sigma_t * ENDLESS_M;
            }
            let along_ray = is_inside.then(|| Ascent::new(&heights, self.ray, self.start));
            if to_light.is_some() || along_ray.is_some() {
                let scattering = profile.scattering;
                series.thinning.push(ThinningFog { sigma_t, scattering, along_ray, to_light });
            }
        }
        if !scatters {
            return Some(Rgb::ZERO);
        }
        if series.thinning.is_empty() {
            let (at_start, per_reach) = (series.tau_at_start.to_array(), series.tau_per_reach.to_array());
            let line = DepthLine::<3> { start: self.start, at_start, per_reach };
            return Some(series.scattering * line.lit_integral(self.start..self.end, lit)?);
        }
        series.lit_integral(self.end, lit)
    }

    fn middle(&self) -> f64 {
        0.5 * (self.start + self.end)
    }

    /// Whether the ray is inside a bank, and the metres of it that lie before.
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

    /// Metres of an even bank, to the eye and to the light together.
    #[inline(always)]
    fn metres(&self, profile: &BankProfile, way: &Option<LightWay>) -> Metres {
        let (is_inside, metres_before) = self.along_ray(profile);
        let mut metres = Metres { is_inside, at_start: metres_before, per_reach: 0.0 };
        if is_inside {
            metres.per_reach = 1.0 / self.ray.direction.x;
        }
        if let Some(LightWay { upper, lower }) = way.and_then(|way| above(way, self.ray, self.middle())) {
            metres.at_start += (upper.at(self.start) - lower.at(self.start)).min(ENDLESS_M);
            metres.per_reach += upper.growth - lower.growth;
        }
        metres
    }
}

/// Metres of a bank on the way of eye and light, `at_start + per_reach * (reach - start)`.
struct Metres {
    is_inside: bool,
    at_start: f64,
    per_reach: f64,
}

impl BankProfile {
    pub(super) fn new(bank: &FogBank, section: FogSection) -> Self {
        Self { bank: *bank, section, span: (0.0, 0.0), metres: 0.0, scattering: Rgb::ZERO }
    }

    /// Finds where a ray that ends at a reach is inside.
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

    /// Metres of this fog on the current ray up to a reach at which it is inside, counted at the density of the base.
    fn metres_between(&self, ray: &PlanarRay, reach: f64) -> f64 {
        let (enter, _) = self.span;
        match self.section.scale_heights {
            None => (reach - enter) / ray.direction.x,
            Some(heights) => Ascent::new(&heights, ray, enter).metres_and_density(reach - enter).0,
        }
    }
}
