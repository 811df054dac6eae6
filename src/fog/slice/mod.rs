//! Fog in a half plane, under a distant light. In go the half plane and its shadows as they grow. Out comes,
//! for any ray in it, what fog does on the way. Invariant: what does not depend on the ray is found once a
//! slice. Where there is no answer the ray is left to [`Medium::passage`].
//!
//! The light's way through a bank leads from one border of its section (`section.rs`) to another. Between
//! breaks that are known beforehand the two stay the same. So all ways are smooth on every stretch of a ray
//! between breaks (`stretch.rs`). What is lit there is known by its moments (`lit_cells.rs`), which the
//! integrand's derivatives are multiplied with. Where fog is even these are powers (`depth_line.rs`). Where
//! it thins out with height they are series (`depth_series.rs`, `thinning_fog.rs`).

mod depth_line;
mod depth_series;
mod lit_cells;
mod section;
mod stretch;
mod thinning_fog;

use super::beer_lambert::exp_minus;
use super::falloff::ENDLESS_M;
use super::{FogBank, Medium, Passage};
use crate::accel::{Cut, HalfPlane};
use crate::color::Rgb;
use crate::light::FrozenLight;
use crate::math::{IntervalSet, PlanarRay, Ray};
use lit_cells::{Lit, LitCells};
use section::{FogSection, LightWay, Line};
use stretch::{BankProfile, SliceStretch, above};
use thinning_fog::{Column, ThinningFog};

/// All fog of a slice.
#[derive(Debug, Default)]
pub struct FogSlice {
    /// Irradiance of the light on a plane across its way, W/m^2; `None` if nothing is known of this slice.
    irradiance: Option<Rgb>,
    banks: Vec<BankProfile>,
    /// Reaches at which the light's way changes from one border of a bank to another, in order.
    breaks: Vec<f64>,
    /// The light's way between one break and the next: a row of all banks before the first break, one
    /// after each.
    ways: Vec<Option<LightWay>>,
    /// Whether all fog weakens all colours alike.
    is_grey: bool,
    /// Whether no fog thins out with height.
    is_even: bool,
    /// Thinning fog of the current stretch.
    thinning: Vec<ThinningFog>,
    /// Lit part of the light's rays.
    cells: LitCells,
}

/// Cells for each optical depth of the way through all fog, to the eye and to the light: where they
/// are many each is soon done, where they are few many shadows lie in those that rays end in.
const CELLS_PER_DEPTH: f64 = 3.0;

/// Scale heights from the base up to which a double tells heights to 1e-10 of one.
const MOST_SCALE_HEIGHTS: f64 = 1e6;

impl FogSlice {
    /// Starts over with another slice, in which everything is lit. `slope` is that of a typical ray; all
    /// shadows will be those of `cuts`.
    pub fn start(
        &mut self,
        medium: &Medium,
        light: &FrozenLight,
        half_plane: &HalfPlane,
        slope: f64,
        cuts: &[Cut],
    ) {
        self.irradiance = match *light {
            FrozenLight::Sun { irradiance, .. } => {
                self.find(medium, half_plane, slope, cuts).map(|()| irradiance)
            }
            FrozenLight::Point { .. } => None,
        };
    }

    /// `None` where a bank has no sections, or where heights are too great to tell.
    fn find(&mut self, medium: &Medium, half_plane: &HalfPlane, slope: f64, cuts: &[Cut]) -> Option<()> {
        self.is_grey = medium.banks().iter().all(|fog| fog.sigma_t == Rgb::splat(fog.sigma_t.x));
        self.banks.clear();
        for bank in medium.banks() {
            let add = |section| self.banks.push(BankProfile::new(bank, section));
            FogSection::for_each(bank, half_plane, add)?;
        }
        self.is_even = self.banks.iter().all(|profile| profile.section.scale_heights.is_none());
        self.find_ways();
        let ray = Line { at_axis: 0.0, growth: slope };
        let (mut scale_heights_per_reach, mut farthest) = (0.0_f64, 0.0_f64);
        for heights in self.banks.iter().filter_map(|profile| profile.section.scale_heights) {
            scale_heights_per_reach = scale_heights_per_reach.max(heights.along(&ray).growth.abs());
            farthest = farthest.max(heights.at_eye.abs());
        }
        // Where fog has no end, cells have one where shadows do.
        let is_bounded = medium.banks().iter().all(FogBank::is_bounded);
        let ends = if is_bounded { &[] } else { cuts }.iter().flat_map(|cut| cut.ends);
        let last_reach = ends.fold(0.0_f64, |last, end| last.max(end.x));
        let cells_per_reach = CELLS_PER_DEPTH * medium.most_extinction_per_m() + scale_heights_per_reach;
        self.cells.start(&self.breaks, last_reach, cells_per_reach);
        (farthest <= MOST_SCALE_HEIGHTS).then_some(())
    }

    /// The light's ways through all banks, between one break and the next.
    fn find_ways(&mut self) {
        let Self { banks, breaks, ways, .. } = self;
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
    }

    /// The light's rays between two reaches, let through until now, are blocked from now on.
    pub fn darken(&mut self, start: f64, end: f64) {
        if self.irradiance.is_some() {
            self.cells.darken(start, end);
        }
    }

    /// Follows a ray up to a reach. The first `shadows` are those that [`FogSlice::darken`] was
    /// told of, the second this ray's own. `None` if nothing is known of the slice, or the fog
    /// changes too fast along the ray.
    pub fn follow(
        &mut self,
        planar: &PlanarRay,
        ray: &Ray,
        end: f64,
        shadows: (&IntervalSet, &IntervalSet),
    ) -> Option<Passage> {
        let irradiance = self.irradiance?;
        let Self { banks, breaks, ways, is_grey, is_even, cells, thinning, .. } = self;
        let lit = Lit { cells, shadows: shadows.0, more_shadows: shadows.1 };
        let (mut first, mut last) = (f64::INFINITY, 0.0_f64);
        let mut tau = Rgb::ZERO;
        for profile in banks.iter_mut() {
            profile.enter(planar, ray, end);
            let (enter, leave) = profile.span;
            if enter < leave {
                (first, last) = (first.min(enter), last.max(leave));
                tau += profile.bank.sigma_t * profile.metres;
            }
        }
        let mut scattered = Rgb::ZERO;
        let mut row = breaks.partition_point(|reach| *reach <= first);
        let mut start = first;
        while start < last {
            // Banks that share a face share breaks.
            while breaks.get(row).is_some_and(|reach| *reach <= start) {
                row += 1;
            }
            let mut end = breaks.get(row).map_or(last, |reach| reach.min(last));
            for (enter, leave) in banks.iter().map(|profile| profile.span) {
                end = if enter > start { end.min(enter) } else { end };
                end = if leave > start { end.min(leave) } else { end };
            }
            let ways = &ways[row * banks.len()..][..banks.len()];
            let stretch = SliceStretch { banks, ways, ray: planar, start, end };
            scattered += match (*is_even, *is_grey) {
                (true, true) => stretch.even::<1>(&lit)?,
                (true, false) => stretch.even::<3>(&lit)?,
                (false, _) => stretch.thinning(thinning, &lit)?,
            };
            start = end;
        }
        // In full shadow rounding may leave a trace of either sign.
        let scattered = (scattered / planar.direction.x).max(Rgb::ZERO) * irradiance;
        Some(Passage { transmittance: exp_minus(tau), scattered })
    }

    /// The share of the light that gets through to the place on a ray at a reach, if that is known.
    pub fn transmittance_to_light(&self, ray: &PlanarRay, reach: f64) -> Option<Rgb> {
        self.irradiance?;
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
        Some(exp_minus(self.banks.iter().zip(ways).map(depth_in).sum()))
    }
}
