//! Fog in a half plane, under a distant light. In go the half plane and its shadows as they grow. Out come
//! scattering and transmittance along any ray in it. Invariant: all that does not depend on the ray is
//! computed once a slice. Where it has no answer, the ray is left to [`Medium::passage`].
//!
//! The light's way through a bank leads from one border of its section (`section.rs`) to another. Between
//! breaks, known beforehand, both borders stay the same. So all ways are smooth on every interval of a ray
//! between breaks (`interval.rs`). The lit part there is given by its moments (`lit_cells.rs`), by which the
//! integrand's derivatives are multiplied. The derivatives are powers in uniform fog (`depth_line.rs`), and
//! series in fog that thins out with height (`depth_series.rs`, `thinning_fog.rs`).

mod depth_line;
mod depth_series;
mod interval;
mod lit_cells;
mod section;
mod thinning_fog;

use super::beer_lambert::exp_minus;
use super::falloff::ENDLESS_M;
use super::{FogBank, Medium, Passage};
use crate::accel::{Cut, HalfPlane};
use crate::color::Rgb;
use crate::light::FrozenLight;
use crate::math::{IntervalSet, PlanarRay, Ray};
use interval::{BankProfile, SliceInterval, above};
use lit_cells::{Lit, LitCells};
use section::{FogSection, LightWay, Line};
use thinning_fog::{Column, ThinningFog};

/// All fog of a slice.
#[derive(Debug, Default)]
pub struct FogSlice {
    /// Irradiance of the light on a plane at right angles, W/m^2; `None` if this slice has no answers.
    irradiance: Option<Rgb>,
    banks: Vec<BankProfile>,
    /// Reaches at which the light's way changes from one border of a bank to another, in order.
    breaks: Vec<f64>,
    /// The light's ways through all banks: one row before the first break, one after each.
    ways: Vec<Option<LightWay>>,
    /// Whether all fog is uniform.
    is_even: bool,
    /// Thinning fog of the current interval.
    thinning: Vec<ThinningFog>,
    /// Lit part of the light's rays.
    cells: LitCells,
}

/// Number of cells for each optical depth of all fog, to the eye and to the light together. More of them each
/// cost a little; with fewer, the cells at the ends of rays have many shadows.
const CELLS_PER_DEPTH: f64 = 3.0;

/// Maximum number of scale heights from the base: doubles resolve heights to 1e-10 scale heights up to there.
const MOST_SCALE_HEIGHTS: f64 = 1e6;

impl FogSlice {
    /// Starts anew with another slice, in which everything is lit. `slope` is that of a typical ray; `cuts`
    /// are the source of all later shadows.
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

    /// Computes the sections; `None` where a bank has none, or where heights are too large for doubles.
    fn find(&mut self, medium: &Medium, half_plane: &HalfPlane, slope: f64, cuts: &[Cut]) -> Option<()> {
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
        // In unbounded fog the cells end where shadows do.
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

    /// Shadows the light's rays between two reaches, which must have been lit.
    pub fn darken(&mut self, start: f64, end: f64) {
        if self.irradiance.is_some() {
            self.cells.darken(start, end);
        }
    }

    /// Scattering and transmittance of a ray up to a reach. The first `shadows` are those passed to
    /// [`FogSlice::darken`], the second those of this ray alone. `None` if the slice has no answers, or the
    /// fog changes too fast along the ray.
    pub fn follow(
        &mut self,
        planar: &PlanarRay,
        ray: &Ray,
        end: f64,
        shadows: (&IntervalSet, &IntervalSet),
    ) -> Option<Passage> {
        let irradiance = self.irradiance?;
        let Self { banks, breaks, ways, is_even, cells, thinning, .. } = self;
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
            let interval = SliceInterval { banks, ways, ray: planar, start, end };
            scattered += if *is_even { interval.even(&lit)? } else { interval.thinning(thinning, &lit)? };
            start = end;
        }
        // In full shadow rounding may leave a small value of either sign.
        let scattered = (scattered / planar.direction.x).max(Rgb::ZERO) * irradiance;
        Some(Passage { transmittance: exp_minus(tau), scattered })
    }

    /// Transmittance from the light to a place on a ray, given by its reach; `None` if the slice has no
    /// answers.
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
