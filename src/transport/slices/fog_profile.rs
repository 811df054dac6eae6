//! Fog within one slice under a distant light. In go the banks of fog and the half plane, out come,
//! for any ray of it, transmittance and light scattered on the way. Invariant: everything that does
//! not depend on the ray is found once a slice.
//!
//! The light's way through a bank leads from one border of its section to another, the same two between breaks that are
//! known beforehand; so on every stretch of a ray between breaks all ways are smooth.

use super::depth_line::DepthLine;
use super::depth_series::DepthSeries;
use super::fog_section::{FogSection, LightWay, Line};
use super::lit_cells::LitCells;
use super::sweep::PlanarRay;
use super::thinning_fog::{Ascent, Column, ThinningFog};
use crate::accel::{Cut, HalfPlane};
use crate::color::Rgb;
use crate::math::{IntervalSet, Ray};
use crate::scattering::{FogBank, Medium, exp_minus, henyey_greenstein};

/// All fog of a slice.
#[derive(Debug, Default)]
pub(super) struct FogProfile {
    banks: Vec<BankProfile>,
    /// Reaches at which the light's way changes from one border of a bank to another, in order.
    breaks: Vec<f64>,
    /// The light's way between one break and the next: a row of all banks before the first break, one
    /// after each.
    ways: Vec<Option<LightWay>>,
    /// Whether all fog weakens all colours alike.
    is_grey: bool,
    /// Where the current ray's stretches begin and end.
    cuts: Vec<f64>,
    /// The current stretch.
    stretch: DepthSeries,
    /// What of the light the scene lets through.
    lit: LitCells,
}

/// A bank, or its part below its base or above it.
#[derive(Debug)]
struct BankProfile {
    bank: FogBank,
    section: FogSection,
    /// Reaches between which the current ray is inside.
    span: (f64, f64),
    /// Metres there, counted at the density of the base.
    metres: f64,
    /// Light scattered into the current ray there, per such metre and irradiance, 1/(m sr).
    scattering: Rgb,
}

/// What fog does along one ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// Of what lies behind.
    pub(super) transmittance: Rgb,
    /// Light scattered on the way, per unit of irradiance, 1/sr.
    pub(super) scattered: Rgb,
}

/// Cells for each optical depth of the way through all fog, to the eye and to the light: where they
/// are many each is soon done, where they are few many shadows lie in those that rays end in.
const CELLS_PER_DEPTH: f64 = 3.0;

/// So many scale heights from the base a double tells heights to 1e-10 of one.
const MOST_SCALE_HEIGHTS: f64 = 1e6;

/// Stands for the length of a way through fog that does not end: times 0 it is 0.
const ENDLESS_M: f64 = 1e200;

impl FogProfile {
    /// Starts over with another slice, in which everything is lit. `slope` is that of a ray like most; all shadows will
    /// be those of `cuts`. False, and no slice to follow rays in, where heights are too great to tell.
    pub(super) fn start(
        &mut self,
        medium: &Medium,
        half_plane: &HalfPlane,
        slope: f64,
        cuts: &[Cut],
    ) -> bool {
        let Self { banks, breaks, ways, lit, .. } = self;
        self.is_grey = medium.banks().iter().all(|fog| fog.sigma_t == Rgb::splat(fog.sigma_t.x));
        banks.clear();
        for bank in medium.banks() {
            FogSection::for_each(bank, half_plane, |section| banks.push(BankProfile::new(bank, section)));
        }
        breaks.clear();
        for profile in banks.iter() {
            profile.section.for_each_break(|reach| {
                if reach > 0.0 && reach.is_finite() {
                    breaks.push(reach);
                }
            });
        }
        breaks.sort_unstable_by(f64::total_cmp);
        ways.clear();
        for index in 0..=breaks.len() {
            let before = if index == 0 { 0.0 } else { breaks[index - 1] };
            let middle = breaks.get(index).map_or(before + 1.0, |after| 0.5 * (before + after));
            ways.extend(banks.iter().map(|profile| profile.section.light_way(middle)));
        }
        let depth_per_m: f64 = medium.banks().iter().map(|fog| fog.sigma_t.max_element()).sum();
        let ray = Line { at_axis: 0.0, growth: slope };
        let (mut scale_heights_per_reach, mut farthest) = (0.0_f64, 0.0_f64);
        for heights in banks.iter().filter_map(|profile| profile.section.scale_heights) {
            scale_heights_per_reach = scale_heights_per_reach.max(heights.along(&ray).growth.abs());
            farthest = farthest.max(heights.at_eye.abs());
        }
        // Where fog has no end, cells have one where shadows do.
        let is_bounded = medium.banks().iter().all(FogBank::is_bounded);
        let ends = if is_bounded { &[] } else { cuts }.iter().flat_map(|cut| cut.ends);
        let last_reach = ends.fold(0.0_f64, |last, end| last.max(end.x));
        lit.start(breaks, last_reach, CELLS_PER_DEPTH * depth_per_m + scale_heights_per_reach);
        farthest <= MOST_SCALE_HEIGHTS
    }

    /// The light's rays between two reaches, let through until now, are blocked from now on.
    pub(super) fn darken(&mut self, start: f64, end: f64) {
        self.lit.darken(start, end);
    }

    /// Follows a ray up to a reach. The `shadows` are those that [`FogProfile::darken`] was told of;
    /// `more_shadows` are this ray's own. `None` if the fog changes too fast along it.
    pub(super) fn follow(
        &mut self,
        planar: &PlanarRay,
        ray: &Ray,
        end: f64,
        shadows: &IntervalSet,
        more_shadows: &IntervalSet,
    ) -> Option<Passage> {
        let Self { banks, breaks, ways, is_grey, cuts, lit, stretch } = self;
        cuts.clear();
        let (mut first, mut last) = (f64::INFINITY, 0.0_f64);
        let mut tau = Rgb::ZERO;
        for profile in banks.iter_mut() {
            profile.enter(planar, ray, end);
            let (enter, leave) = profile.span;
            if enter < leave {
                (first, last) = (first.min(enter), last.max(leave));
                tau += profile.bank.sigma_t * profile.metres;
                cuts.push(enter);
                cuts.push(leave);
            }
        }
        let mut passage = Passage { transmittance: exp_minus(tau), scattered: Rgb::ZERO };
        if first >= last {
            return Some(passage);
        }
        let mut row = breaks.partition_point(|reach| *reach <= first);
        for &reach in breaks[row..].iter().take_while(|reach| **reach < last) {
            cuts.push(reach);
        }
        cuts.sort_unstable_by(f64::total_cmp);
        for index in 1..cuts.len() {
            let (start, end) = (cuts[index - 1], cuts[index]);
            if start < end {
                // Banks that share a face share breaks.
                while breaks.get(row).is_some_and(|reach| *reach <= start) {
                    row += 1;
                }
                let ways = &ways[row * banks.len()..][..banks.len()];
                if !set_stretch(stretch, banks, ways, planar, (start, end)) {
                    continue;
                }
                passage.scattered += if !stretch.thinning.is_empty() {
                    stretch.lit_integral(end, lit, shadows, more_shadows)?
                } else if *is_grey {
                    let line = depth_line::<1>(stretch);
                    stretch.scattering * line.lit_integral(start..end, lit, shadows, more_shadows)?
                } else {
                    let line = depth_line::<3>(stretch);
                    stretch.scattering * line.lit_integral(start..end, lit, shadows, more_shadows)?
                };
            }
        }
        // In full shadow rounding may leave a trace of either sign.
        passage.scattered = (passage.scattered / planar.direction.x).max(Rgb::ZERO);
        Some(passage)
    }

    /// The share of the light that gets through to the place on a ray at a reach.
    pub(super) fn transmittance_to_light(&self, ray: &PlanarRay, reach: f64) -> Rgb {
        let row = self.breaks.partition_point(|before| *before <= reach);
        let ways = &self.ways[row * self.banks.len()..][..self.banks.len()];
        let depth_in = |(profile, way): (&BankProfile, &Option<LightWay>)| {
            let Some(way) = way.and_then(|way| above(way, ray, reach)) else { return Rgb::ZERO };
            let metres = match profile.section.scale_heights {
                None => way.upper.at(reach) - way.lower.at(reach),
                Some(heights) => Column::new(way, heights).map_or(ENDLESS_M, |column| column.metres(reach)),
            };
            profile.bank.sigma_t * metres.clamp(0.0, ENDLESS_M)
        };
        exp_minus(self.banks.iter().zip(ways).map(depth_in).sum())
    }
}

/// What of the light's way lies above a ray; `None` if nothing does.
fn above(way: LightWay, ray: &PlanarRay, reach: f64) -> Option<LightWay> {
    let ray = Line { at_axis: 0.0, growth: ray.slope };
    let lower = if way.lower.at(reach) < ray.at(reach) { ray } else { way.lower };
    (lower.at(reach) < way.upper.at(reach)).then_some(LightWay { lower, ..way })
}

/// Sets a part of a ray on which nothing but distances changes; false if no light is scattered there.
fn set_stretch(
    stretch: &mut DepthSeries,
    banks: &[BankProfile],
    ways: &[Option<LightWay>],
    ray: &PlanarRay,
    (start, end): (f64, f64),
) -> bool {
    let middle = 0.5 * (start + end);
    let metres_per_reach = 1.0 / ray.direction.x;
    let mut scatters = false;
    stretch.clear(start);
    for (profile, way) in banks.iter().zip(ways) {
        let (enter, leave) = profile.span;
        let is_inside = enter < middle && middle < leave;
        scatters |= is_inside && profile.scattering != Rgb::ZERO;
        let metres_before = if is_inside {
            profile.metres_between(ray, start)
        } else if enter < leave && leave <= middle {
            profile.metres
        } else {
            0.0
        };
        let way = way.and_then(|way| above(way, ray, middle));
        let sigma_t = profile.bank.sigma_t;
        stretch.tau_at_start += sigma_t * metres_before;
        if is_inside && profile.section.scale_heights.is_none() {
            stretch.scattering += profile.scattering;
            stretch.tau_per_reach += sigma_t * metres_per_reach;
        }
        match (profile.section.scale_heights, way) {
            (None, None) => {}
            (None, Some(LightWay { upper, lower })) => {
                stretch.tau_at_start += sigma_t * (upper.at(start) - lower.at(start)).min(ENDLESS_M);
                stretch.tau_per_reach += sigma_t * (upper.growth - lower.growth);
            }
            (Some(heights), way) => {
                let to_light = way.and_then(|way| Column::new(way, heights));
                if way.is_some() && to_light.is_none() {
                    stretch.tau_at_start += sigma_t * ENDLESS_M;
                }
                let along_ray = is_inside.then(|| Ascent::new(&heights, ray, start));
                if to_light.is_some() || along_ray.is_some() {
                    let scattering = profile.scattering;
                    stretch.thinning.push(ThinningFog { sigma_t, scattering, along_ray, to_light });
                }
            }
        }
    }
    scatters
}

fn depth_line<const LANES: usize>(stretch: &DepthSeries) -> DepthLine<LANES> {
    let lanes = |of: Rgb| std::array::from_fn(|lane| of[lane]);
    let (at_start, per_reach) = (lanes(stretch.tau_at_start), lanes(stretch.tau_per_reach));
    DepthLine { start: stretch.start, at_start, per_reach }
}

impl BankProfile {
    fn new(bank: &FogBank, section: FogSection) -> Self {
        Self { bank: *bank, section, span: (0.0, 0.0), metres: 0.0, scattering: Rgb::ZERO }
    }

    /// Finds where a ray that ends at a reach is inside.
    fn enter(&mut self, planar: &PlanarRay, ray: &Ray, end: f64) {
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
