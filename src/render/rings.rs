//! Rings around the axis in which slices are laid out, and their densities. In go the fan of the light's
//! centre, the deviation of others and the segments of slices. Out come rings. Invariant: the choice is that
//! of the whole picture, for any wanted part.
//!
//! A slice with a draw of its own passes through its place half way across its ring. Away from there it
//! leaves its place, and the number of slices varies from pixel to pixel. In narrow rings all slices stay in
//! order, but each ring gathers its slices' segments anew.
//!
//! Slices that share a fan are always in order, but lie close together near its epipole. Most of them are
//! redundant there, so there are fewer.

use crate::transport::slices::{Fan, Ring, Separation, Slice};
use std::f64::consts::PI;

/// Possible numbers of rings: 16 are hardly better than 8.
const COUNTS: [u32; 4] = [1, 2, 4, 8];

/// Cost of a sample, in segments that a slice gathers, from the time that rings add to leaves500.
const SEGMENTS_PER_SAMPLE: f64 = 5.0;

/// Displacement of slices, in places, at which no order is left. In `title` at its full size they are off by
/// hundreds, and 8 rings, in the same time, err by a quarter more than one.
const MOST_PASSED: f64 = 20.0;

/// Number of slices of a ring whose segments are counted.
const PROBES: u32 = 3;

/// Part of the way from a fan's axis to its widest spacing within which slices that share the fan are too
/// dense. With the sun amid leaves500 a ninth of the time is spent there, on a hundredth of the square of the
/// error.
const NEAR_EPIPOLE: f64 = 0.1;

/// Density of such slices at the rim of that part, over that at the widest spacing. With all of them it would
/// be ten times, so a quarter are left.
const CLOSER_AT_RIM: f64 = 2.5;

/// Facts that decide on rings, beside the fan.
pub(super) struct RingFacts<'a> {
    /// Whether slices have draws of their own.
    pub(super) is_drawn: bool,
    /// Maximum deviation of fans.
    pub(super) deviation_rad: f64,
    /// Samples a pixel.
    pub(super) samples: f64,
    /// Number of slices in the width of a pixel.
    pub(super) slices_per_px: f64,
    /// Number of segments that a slice gathers.
    pub(super) segments: &'a dyn Fn(&Slice) -> usize,
}

impl RingFacts<'_> {
    /// Number of rings, and whether slices mostly keep their order in them.
    pub(super) fn choose(&self, base: &Fan) -> (u32, bool) {
        let count = self.count(base);
        let areas = self.cut(base, count).into_iter().map(|ring| {
            let area_px = base.separation(ring).area_px;
            (area_px, if self.passed(base, ring) < 1.0 { area_px } else { 0.0 })
        });
        let (all_px, ordered_px) = areas.fold((0.0, 0.0), |sums, area| (sums.0 + area.0, sums.1 + area.1));
        (count, ordered_px >= 0.5 * all_px)
    }

    /// Number of rings that takes the least time for the same error.
    fn count(&self, base: &Fan) -> u32 {
        let cost = |count| self.cut(base, count).into_iter().map(|ring| self.cost(base, ring)).sum::<f64>();
        // Where little can be gained, no segments are counted.
        let is_ordered = self.cut(base, 1).into_iter().all(|ring| self.disorder(base, ring) < 1.1);
        if is_ordered {
            return 1;
        }
        let costs = COUNTS.map(|count| (count, cost(count)));
        costs.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(1, |(count, _)| count)
    }

    /// The picture in so many rings, with further rings around the axis and the opposite direction: there
    /// slices deviate too far to keep any place, or lie too close.
    pub(super) fn cut(&self, base: &Fan, count: u32) -> Vec<Ring> {
        let extent = base.extent();
        let about_axis_rad = match self.is_drawn {
            true => 2.0 * self.deviation_rad,
            // Within this angle slices that share a fan lie close together.
            false => {
                let greatest_px = base.separation(Ring::WHOLE).greatest_px;
                (NEAR_EPIPOLE * greatest_px / base.px_per_rad()).min(1.0).asin()
            }
        };
        let (low, high) = (about_axis_rad, PI - about_axis_rad);
        let (from, to) = (extent.0.max(low), extent.1.min(high));
        let mut borders = Vec::new();
        if about_axis_rad > 0.0 && from < to {
            let between = |part: u32| from + (to - from) * f64::from(part) / f64::from(count);
            borders.extend((extent.0 < low).then_some(low));
            borders.extend((1..count).map(between));
            borders.extend((high < extent.1).then_some(high));
        }
        borders.push(PI);
        let starts = std::iter::once(0.0).chain(borders.iter().copied());
        starts.zip(&borders).map(|(from, &to)| Ring(from, to)).collect()
    }

    /// Number of slices in a radian of a ring.
    pub(super) fn slices_per_rad(&self, base: &Fan, ring: Ring) -> f64 {
        let (whole, own) = (base.separation(Ring::WHOLE), base.separation(ring));
        let Separation { mean_px, greatest_px, .. } = if own.area_px > 0.0 { own } else { whole };
        let px = if self.is_drawn { mean_px } else { whole.greatest_px.min(CLOSER_AT_RIM * greatest_px) };
        self.slices_per_px * px
    }

    /// Cost of a ring for a fixed error, in segments: those of its slices, and its samples.
    fn cost(&self, base: &Fan, ring: Ring) -> f64 {
        let separation = base.separation(ring);
        let angle = |probe: u32| base.angles.0 + base.angles.1 * (f64::from(probe) + 0.5) / f64::from(PROBES);
        let slices = (0..PROBES).filter_map(|probe| base.slice(angle(probe), ring));
        let segments = slices.map(|slice| (self.segments)(&slice)).sum::<usize>() as f64 / f64::from(PROBES);
        let gathered = base.angles.1 * self.slices_per_px * separation.mean_px * segments;
        let samples = self.samples * separation.area_px * self.disorder(base, ring);
        gathered + SEGMENTS_PER_SAMPLE * samples
    }

    /// Factor on the samples of ordered slices that a ring needs for the same error. Under a sun of 0.53
    /// degrees the error of leaves500 in 1 to 16 rings goes as (1 + 6 passed)^(1/4) / samples, where slices
    /// are displaced by `passed` places at the ring's borders. As `passed` itself grows with the samples, the
    /// factor is (1 + 6 passed)^(1/3).
    fn disorder(&self, base: &Fan, ring: Ring) -> f64 {
        (1.0 + 6.0 * self.passed(base, ring).min(MOST_PASSED)).cbrt()
    }

    /// Displacement of slices at a ring's borders, in places.
    fn passed(&self, base: &Fan, ring: Ring) -> f64 {
        let extent = base.extent();
        let (from, to) = (ring.0.max(extent.0), ring.1.min(extent.1));
        let rotated_rad = self.deviation_rad * 0.5 * (to - from) / (0.5 * (from + to)).sin();
        rotated_rad * base.px_per_rad() * self.slices_per_px
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Size;
    use glam::DVec3;

    const SIZE: Size = Size { width: 480, height: 270 };

    /// Fan of a pinhole's picture along -z, with a sun at an elevation.
    fn fan(elevation_deg: f64) -> Fan {
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        Fan::of_pinhole(0.7, SIZE, DVec3::new(0.0, sin, -cos))
    }

    /// With the sun beside the picture, in it, behind the camera, and at right angles.
    fn fans() -> [Fan; 4] {
        [50.0, 5.0, 175.0, 90.0].map(fan)
    }

    fn facts(deviation_deg: f64, segments: &dyn Fn(&Slice) -> usize) -> RingFacts<'_> {
        let is_drawn = deviation_deg > 0.0;
        RingFacts {
            is_drawn,
            deviation_rad: deviation_deg.to_radians(),
            samples: 16.0,
            slices_per_px: 8.0,
            segments,
        }
    }

    #[test]
    fn slices_that_share_a_fan_are_not_cut() {
        let asked = |_: &Slice| -> usize { panic!("nothing is asked of the scene") };
        for fan in fans() {
            // A pinhole at an instant under a parallel sun, and under one that hardly deviates.
            for deviation_deg in [0.0, 1e-6] {
                assert_eq!(facts(deviation_deg, &asked).count(&fan), 1);
            }
        }
    }

    #[test]
    fn a_disc_is_worth_several_rings_where_gathering_is_cheap_and_one_where_it_is_dear() {
        for fan in fans() {
            let counts = [0, 1, 1_000_000].map(|segments| facts(0.27, &move |_| segments).count(&fan));
            assert!(counts[0] == 8 && counts[1] > 1 && counts[2] == 1, "{counts:?}");
        }
    }

    /// With more slices each is displaced by more places: rings are worth as much with many samples as with
    /// few.
    #[test]
    fn many_samples_are_worth_as_many_rings_as_few() {
        for samples in [4.0, 16.0, 64.0] {
            let facts = RingFacts { samples, slices_per_px: 0.5 * samples, ..facts(0.27, &|_| 100) };
            assert!(facts.count(&fan(50.0)) >= 4, "{samples}");
        }
    }

    /// As in `title`, whose sun and lens deviate by more than rings could mend.
    #[test]
    fn what_deviates_too_far_is_not_cut() {
        assert_eq!(
            RingFacts { samples: 24.0, slices_per_px: 1000.0, ..facts(0.9, &|_| 1000) }.count(&fan(50.0)),
            1
        );
    }

    /// Slices of a small disc keep their order in rings; those of one that deviates far are independent.
    #[test]
    fn what_deviates_far_is_not_ordered() {
        for (deviation_deg, ordered) in [(0.0, true), (0.27, true), (0.9, false), (6.0, false)] {
            assert_eq!(facts(deviation_deg, &|_| 1).choose(&fan(50.0)).1, ordered, "{deviation_deg}");
        }
    }

    /// If the epipole, or the opposite direction, is in the picture.
    #[test]
    fn slices_near_the_epipole_are_thinned() {
        let facts = facts(0.0, &|_| 1);
        for (elevation_deg, near_epipole) in [(50.0, None), (5.0, Some(0)), (175.0, Some(1)), (90.0, None)] {
            let fan = fan(elevation_deg);
            let all_per_rad = facts.slices_per_px * fan.separation(Ring::WHOLE).greatest_px;
            let rings = facts.cut(&fan, 1);
            assert_eq!(rings.len(), if near_epipole.is_some() { 2 } else { 1 }, "{rings:?}");
            for (number, &ring) in rings.iter().enumerate() {
                let share = facts.slices_per_rad(&fan, ring) / all_per_rad;
                let expected = if near_epipole == Some(number) { 0.25 } else { 1.0 };
                assert!((share / expected - 1.0).abs() < 0.15, "{elevation_deg}: {share} in {ring:?}");
            }
        }
    }

    #[test]
    fn rings_are_fewer_the_dearer_gathering_is() {
        let counts = [1, 3, 10, 30, 100, 300, 1000, 10_000]
            .map(|segments| facts(0.27, &move |_| segments).count(&fan(50.0)));
        assert!(counts.is_sorted_by(|a, b| a >= b) && counts[0] > counts[7], "{counts:?}");
    }

    #[test]
    fn rings_cover_the_picture_once() {
        for fan in fans() {
            for deviation_deg in [0.0, 0.27, 3.0] {
                for count in COUNTS {
                    let rings = facts(deviation_deg, &|_| 1).cut(&fan, count);
                    assert!(rings[0].0 == 0.0 && rings[rings.len() - 1].1 == PI, "{rings:?}");
                    assert!(rings.windows(2).all(|pair| pair[0].1 == pair[1].0), "{rings:?}");
                    assert!(rings.iter().all(|ring| ring.0 < ring.1), "{rings:?}");
                    let area_px: f64 = rings.iter().map(|&ring| fan.separation(ring).area_px).sum();
                    let whole_px = fan.separation(Ring::WHOLE).area_px;
                    assert!((area_px / whole_px - 1.0).abs() < 1e-9, "{area_px} {whole_px}");
                    let pixels = (SIZE.width * SIZE.height) as f64;
                    assert!((whole_px / pixels - 1.0).abs() < 0.02, "{whole_px} {pixels}");
                }
            }
        }
    }
}
