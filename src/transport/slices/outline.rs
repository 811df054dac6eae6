//! Interpolation between slices. In go the pieces of a slice and the borders between them. Out come, for a
//! slice beside, its parts and the piece that represents each. Invariant: the parts cover all of that slice
//! that lies near this one, without overlap.
//!
//! Nearly every edge moves from slice to slice. If each piece represented an equal part of its neighbours,
//! each edge would be a staircase. Most edges are straight, and the course of a straight one is known
//! (`border.rs`).

use super::border::Border;
use super::slice::Slice;
use crate::scene::Size;
use std::ops::Range;

/// Maximum shift of an edge along a slice beside, pixels. Edges almost along the slice are not known far from
/// it, and a pixel must not depend on distant ones.
pub const FARTHEST_SHIFT_PX: f64 = 2.0;

/// Ratio of the distances of two edges from which they may belong to one outline, which ends where they meet.
const ONE_OUTLINE: f64 = 0.99;

/// Consecutive pieces of a slice in one region of the picture; they do not depend on others.
#[derive(Debug)]
struct Interval {
    /// Column and row of the region.
    region: (usize, usize),
    first_run: usize,
    /// Slopes of the rays at which its first piece begins and its last one ends.
    slopes: [f64; 2],
}

/// Consecutive pieces of a slice, in successive chords, without an edge between them.
#[derive(Debug)]
struct Run {
    first: usize,
    /// Slope of the ray at its end.
    slope: f64,
    /// Border at its end, if it is known.
    border: Option<Border>,
}

/// Part of a slice beside, in one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Strip {
    /// Number of the piece that represents it, in the order of its slice.
    pub piece: usize,
    /// Column and row of the full picture.
    pub pixel: (usize, usize),
    /// Picture area per radian of rotation, pixels^2.
    pub area_per_rad: f64,
}

/// The pieces of one slice, in their order.
#[derive(Debug)]
pub struct Outline {
    /// Regions of the picture are squares of so many pixels.
    region_side: usize,
    /// Slopes of the rays at which pieces end.
    slopes: Vec<f64>,
    intervals: Vec<Interval>,
    runs: Vec<Run>,
    /// Whether the next piece belongs to the last run.
    goes_on: bool,
    /// Ends of runs on a slice beside.
    ends: Vec<End>,
}

/// End of a run, on a slice beside.
#[derive(Clone, Copy, Debug)]
struct End {
    /// Length of the slice up to it, if its edge were to run across slices unmoved.
    unmoved: f64,
    /// Change of that length by the course of its edge: on this slice, and on the one rotated by as much the
    /// other way.
    shifts: [f64; 2],
    /// Share of the shift that is applied, 0 to 1.
    moved: f64,
    /// Distance from the eye to what makes the edge, metres.
    distance: f64,
    /// Length of the slice up to it, with the shift.
    length: f64,
}

impl Default for Outline {
    /// Without pieces; the whole picture is one region.
    fn default() -> Self {
        let (slopes, intervals, runs, ends) = Default::default();
        Self { region_side: usize::MAX, slopes, intervals, runs, goes_on: false, ends }
    }
}

impl Outline {
    /// Begins another slice. Regions are squares of so many pixels, counted from the picture's corner. Parts
    /// in a region depend only on the pieces in it.
    pub fn start(&mut self, region_side: usize) {
        self.region_side = region_side;
        self.slopes.clear();
        self.intervals.clear();
        self.runs.clear();
        self.goes_on = false;
    }

    /// Adds a piece in a pixel, with the slopes of its start and end. It joins the piece before unless that
    /// ended at an edge.
    pub(super) fn add(&mut self, pixel: (usize, usize), start: f64, end: f64) {
        let region = self.region(pixel);
        if self.intervals.last().is_none_or(|interval| interval.region != region) {
            self.intervals.push(Interval { region, first_run: self.runs.len(), slopes: [start; 2] });
            self.goes_on = false;
        }
        let is_next = self.slopes.last() == Some(&start);
        if !(self.goes_on && is_next) {
            self.runs.push(Run { first: self.slopes.len(), slope: end, border: None });
        }
        self.slopes.push(end);
        self.goes_on = true;
        if let (Some(interval), Some(run)) = (self.intervals.last_mut(), self.runs.last_mut()) {
            (interval.slopes[1], run.slope) = (end, end);
        }
    }

    /// Ends the piece added last at an edge.
    pub(super) fn end(&mut self, border: Option<Border>) {
        self.goes_on = false;
        if let Some(run) = self.runs.last_mut() {
            run.border = border;
        }
    }

    fn region(&self, (x, y): (usize, usize)) -> (usize, usize) {
        (x / self.region_side, y / self.region_side)
    }

    fn runs_of(&self, interval: usize) -> Range<usize> {
        let end = self.intervals.get(interval + 1).map_or(self.runs.len(), |next| next.first_run);
        self.intervals[interval].first_run..end
    }

    fn pieces_of(&self, run: usize) -> Range<usize> {
        let end = self.runs.get(run + 1).map_or(self.slopes.len(), |next| next.first);
        self.runs[run].first..end
    }

    /// Calls back with the parts of a slice that is rotated by an angle. In each region they lie within the
    /// slice's pieces there, or at most as far from their ends as an edge may move. Unwanted pixels are
    /// left out.
    pub fn parts(
        &mut self,
        beside: &Slice,
        rotated_rad: f64,
        size: Size,
        is_wanted: impl Fn(usize, usize) -> bool,
        mut call: impl FnMut(Strip),
    ) {
        self.move_ends(beside, rotated_rad);
        let farthest = beside.length_of_px(FARTHEST_SHIFT_PX);
        // The interval in the current region, its runs that are still to come, and its bounds.
        let (mut interval, mut runs, mut low, mut high) = (None, 0..0, 0.0, 0.0);
        let mut piece = 0;
        for crossing in beside.crossings(size, is_wanted) {
            let region = self.region(crossing.pixel);
            if interval.is_none_or(|interval: usize| self.intervals[interval].region != region) {
                // Neighbouring slices meet regions in the same order, but for corners that one of them
                // misses.
                let next = interval.map_or(0, |interval| interval + 1);
                let Some(skipped) =
                    self.intervals[next..].iter().position(|interval| interval.region == region)
                else {
                    continue;
                };
                let found = next + skipped;
                let [start, end] = self.intervals[found].slopes.map(|slope| beside.length_at_slope(slope));
                // Fog's light is unbounded near the light's image: a piece in a region's corner there, far
                // smaller than a pixel, must not represent whole pixels.
                (interval, runs, low, high) =
                    (Some(found), self.runs_of(found), start - farthest, end + farthest.min(end));
            }
            let [from, to] = crossing.lengths;
            let (mut from, to) = (from.max(low), to.min(high));
            let mut passed = beside.area_at(from);
            while from < to {
                while runs.len() > 1 && self.ends[runs.start].length <= from {
                    runs.start += 1;
                }
                let run = runs.start;
                let until = if runs.len() > 1 { self.ends[run].length.min(to) } else { to };
                // The piece of a run that lies beside.
                let pieces = self.pieces_of(run);
                piece = piece.max(pieces.start);
                if piece + 1 < pieces.end {
                    let slope = beside.slope_at(0.5 * (from + until));
                    while piece + 1 < pieces.end && self.slopes[piece] > slope {
                        piece += 1;
                    }
                }
                let area = beside.area_at(until);
                if area > passed {
                    call(Strip { piece, pixel: crossing.pixel, area_per_rad: area - passed });
                }
                (from, passed) = (until, area);
            }
        }
    }

    /// Computes the ends of runs on a rotated slice.
    fn move_ends(&mut self, beside: &Slice, rotated_rad: f64) {
        let rotation = rotated_rad.sin_cos();
        let farthest = beside.length_of_px(FARTHEST_SHIFT_PX);
        self.ends.clear();
        self.ends.extend(self.runs.iter().map(|run| {
            let unmoved = beside.length_at_slope(run.slope);
            let shift = |slope: f64| {
                let shift = beside.length_at_slope(slope) - unmoved;
                if slope.is_finite() { shift.clamp(-farthest, farthest) } else { 0.0 }
            };
            let shifts = run.border.map_or([0.0; 2], |border| border.slopes_beside(rotation).map(shift));
            let distance = run.border.map_or(f64::INFINITY, |border| border.distance());
            End { unmoved, shifts, moved: 1.0, distance, length: unmoved }
        }));
        for interval in 0..self.intervals.len() {
            let runs = self.runs_of(interval);
            put_in_order(&mut self.ends[runs]);
        }
    }
}

/// Orders the ends of a interval's runs: they stop where they meet, and occlude those behind.
fn put_in_order(ends: &mut [End]) {
    for end in 1..ends.len() {
        let (before, after) = ends.split_at_mut(end);
        if let (Some(before), Some(after)) = (before.last_mut(), after.first_mut()) {
            stop_where_they_meet(before, after);
        }
    }
    for end in 0..ends.len() {
        let (before, after) = ends.split_at_mut(end);
        let Some(own) = after.first_mut() else { break };
        own.length = own.unmoved + own.moved * own.shifts[0];
        let Some(last) = before.last() else { continue };
        if own.distance < last.distance {
            for hidden in before.iter_mut().rev().take_while(|hidden| hidden.length > own.length) {
                hidden.length = own.length;
            }
        } else {
            own.length = own.length.max(last.length);
        }
    }
}

/// Stops two edges that move towards each other where they meet, or stops the farther one where the nearer
/// occludes it. On the other side, where they part, they move by the same amount. So gains and losses of
/// neighbouring slices cancel in the mean over all slices, and the mean of many pictures is right.
fn stop_where_they_meet(before: &mut End, after: &mut End) {
    let gap = after.unmoved - before.unmoved;
    let closing = [0, 1].map(|side| before.shifts[side] - after.shifts[side]);
    let most = closing[0].max(closing[1]);
    if most <= gap {
        return;
    }
    let moved = (gap / most).max(0.0);
    if before.distance >= ONE_OUTLINE * after.distance {
        before.moved = before.moved.min(moved);
    }
    if after.distance >= ONE_OUTLINE * before.distance {
        after.moved = after.moved.min(moved);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::slices::{Fan, Ring};
    use glam::DVec3;
    use proptest::prelude::*;

    const SIZE: Size = Size { width: 19, height: 12 };

    proptest! {
        /// For any course of the edges between slices.
        #[test]
        fn parts_are_the_whole_slice_beside(
            to_light in prop::array::uniform3(-1.0..1.0_f64).prop_filter_map("a direction", |v| DVec3::from(v).try_normalize()),
            part in 0.05..0.95_f64,
            rotated_rad in -0.02..0.02_f64,
            // After each piece: no edge, an edge without a border, or a border of any course.
            after in prop::collection::vec((0..3_u8, prop::array::uniform3(-1.0..1.0_f64)), 60),
        ) {
            let fan = Fan::of_pinhole(1.0, SIZE, to_light);
            let angle = fan.angles.0 + part * fan.angles.1;
            let slices = (fan.slice(angle, Ring::WHOLE), fan.slice(angle + rotated_rad, Ring::WHOLE));
            let (Some(slice), Some(beside)) = slices else { return Ok(()) };
            let mut outline = Outline::default();
            let crossings: Vec<_> = slice.crossings(SIZE, |_, _| true).collect();
            for (crossing, (edge, along)) in crossings.iter().zip(&after) {
                let [start, end] = slice.slopes(crossing);
                outline.add(crossing.pixel, start, end);
                let border = Border::through(DVec3::new(1.0, end, 0.0), DVec3::from(*along));
                match edge {
                    0 => {}
                    1 => outline.end(None),
                    _ => outline.end(Some(border)),
                }
            }
            let pieces = crossings.len().min(after.len());
            let (mut at, mut passed) = (0, 0.0);
            outline.parts(&beside, rotated_rad, SIZE, |_, _| true, |part| {
                assert!(at <= part.piece && part.piece < pieces, "{part:?} after {at}, of {pieces}");
                assert!(part.area_per_rad > 0.0, "{part:?}");
                (at, passed) = (part.piece, passed + part.area_per_rad);
            });
            // Except beyond the slice's ends.
            let farthest = beside.length_of_px(FARTHEST_SHIFT_PX);
            let end = slice.slopes(&crossings[pieces - 1])[1];
            let most = farthest.min(beside.length_at_slope(end));
            let [low, high] = [(slice.slopes(&crossings[0])[0], -farthest), (end, most)]
                .map(|(slope, beyond)| beside.area_at((beside.length_at_slope(slope) + beyond).clamp(0.0, beside.length)));
            prop_assert!((passed - (high - low)).abs() < 1e-9 * beside.area_per_rad, "{passed} {low} {high}");
        }

        /// With or without the pieces in every other region, as in a crop, and in a pass with fewer pixels.
        #[test]
        fn parts_depend_on_nothing_beyond_their_region(
            to_light in prop::array::uniform3(-1.0..1.0_f64).prop_filter_map("a direction", |v| DVec3::from(v).try_normalize()),
            part in 0.05..0.95_f64,
            rotated_rad in -0.02..0.02_f64,
            after in prop::collection::vec(prop::option::of(prop::array::uniform3(-1.0..1.0_f64)), 60),
        ) {
            let fan = Fan::of_pinhole(1.0, SIZE, to_light);
            let angle = fan.angles.0 + part * fan.angles.1;
            let slices = (fan.slice(angle, Ring::WHOLE), fan.slice(angle + rotated_rad, Ring::WHOLE));
            let (Some(slice), Some(beside)) = slices else { return Ok(()) };
            let is_kept = |(x, y): (usize, usize)| (x / 4 + y / 4) % 2 == 0;
            let parts = |only_kept: bool| {
                let mut outline = Outline::default();
                outline.start(4);
                let mut of_piece = Vec::new();
                for (crossing, along) in slice.crossings(SIZE, |_, _| true).zip(&after) {
                    if only_kept && !is_kept(crossing.pixel) {
                        continue;
                    }
                    let [start, end] = slice.slopes(&crossing);
                    outline.add(crossing.pixel, start, end);
                    if let Some(along) = along {
                        outline.end(Some(Border::through(DVec3::new(1.0, end, 0.0), DVec3::from(*along))));
                    }
                    of_piece.push(crossing.pixel);
                }
                let mut parts = Vec::new();
                outline.parts(&beside, rotated_rad, SIZE, |_, _| true, |part| {
                    if is_kept(part.pixel) {
                        parts.push((of_piece[part.piece], part.pixel, part.area_per_rad));
                    }
                });
                parts
            };
            let whole = parts(false);
            prop_assert!(whole.iter().all(|((x, y), pixel, _)| (x / 4, y / 4) == (pixel.0 / 4, pixel.1 / 4)));
            prop_assert_eq!(whole, parts(true));
        }

        /// Whether they meet beside the slice or not.
        #[test]
        fn what_lies_between_two_edges_has_its_length_in_the_mean(
            to_light in prop::array::uniform3(-1.0..1.0_f64).prop_filter_map("a direction", |v| DVec3::from(v).try_normalize()),
            part in 0.2..0.8_f64,
            along in prop::array::uniform2(prop::array::uniform2(-1.0..1.0_f64)),
            gap_per_rad in 0.05..1.0_f64,
        ) {
            let rotated_rad = 1e-3;
            let fan = Fan::of_pinhole(1.0, SIZE, to_light);
            let angle = fan.angles.0 + part * fan.angles.1;
            let slice_at = |rotation: f64| fan.slice(angle + rotation, Ring::WHOLE);
            let (Some(own), Some(left), Some(right)) = (slice_at(0.0), slice_at(-rotated_rad), slice_at(rotated_rad)) else { return Ok(()) };
            let middle = own.slope_at(0.5 * own.length);
            let slopes = [middle, middle - gap_per_rad * rotated_rad];
            let mut outline = Outline::default();
            for (slope, [x, y]) in slopes.into_iter().zip(along) {
                outline.add((0, 0), slope + 1.0, slope);
                outline.end(Some(Border::through(DVec3::new(1.0, slope, 0.0), DVec3::new(x, y, 1.0))));
            }
            let gap = |ends: [f64; 2]| ends[1] - ends[0];
            let beside = [(left, -rotated_rad), (right, rotated_rad)].map(|(slice, rotation)| {
                outline.move_ends(&slice, rotation);
                gap([0, 1].map(|end| outline.ends[end].length))
            });
            let unmoved = gap(slopes.map(|slope| own.length_at_slope(slope)));
            prop_assert!((0.5 * (beside[0] + beside[1]) - unmoved).abs() < 0.05 * unmoved, "{beside:?} {unmoved}");
        }
    }
}
