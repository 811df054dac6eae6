//! What lies between slices. In go the pieces of a slice and the borders between them, out comes which piece stands for which part of a
//! slice beside it. Invariant: the parts of a slice beside are all of it that lies near the slice, and none is there twice.
//!
//! Nearly every edge changes from slice to slice. Were a piece to stand for as much of the slices beside, each of them would be a step; but most edges are straight,
//! and where a straight one goes on is known (`border.rs`).

use super::border::Border;
use super::fan::Slice;
use crate::scene::{Size, Window};

/// No edge moves farther than this along a slice beside, pixels: how far those that lie almost along the slice go on is not known, and
/// what a pixel shows must not depend on what lies far from it.
pub const FARTHEST_SHIFT_PX: f64 = 2.0;

/// Edges of which the nearer has this part of the other's distance and more may be of one outline, which ends where they meet.
const ONE_OUTLINE: f64 = 0.99;

/// The pieces of a slice between two borders: they go on from chord to chord without an edge.
#[derive(Debug)]
struct Run {
    /// The first of its pieces.
    first: usize,
    /// Of the ray at its end.
    slope: f64,
    /// What makes the edge there, if it is known.
    border: Option<Border>,
}

/// A part of a slice beside, in one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    /// Number of the piece that stands for it, in the order of its slice.
    pub piece: usize,
    /// Column and row of the full picture.
    pub pixel: (usize, usize),
    /// Picture area per radian of turn, pixels^2.
    pub area_per_rad: f64,
}

/// The pieces of one slice, in their order.
#[derive(Debug, Default)]
pub struct Outline {
    /// Of the ray at which the first piece begins.
    start_slope: f64,
    /// Of those at which pieces end.
    slopes: Vec<f64>,
    runs: Vec<Run>,
    /// Whether the next piece belongs to the last run.
    goes_on: bool,
    /// Where runs end on a slice beside.
    ends: Vec<End>,
}

/// Of a run, on a slice beside.
#[derive(Clone, Copy, Debug)]
struct End {
    /// How much of the slice lies before, in its length, if edges run along the slices.
    unmoved: f64,
    /// By how much more or less it is since its edge does not, there and on the slice that is turned as much the other way.
    shifts: [f64; 2],
    /// How much of that it moves, 0 to 1.
    moved: f64,
    /// Of what makes the edge, from the eye, metres.
    distance: f64,
    /// How much of the slice lies before, in its length.
    length: f64,
}

impl Outline {
    pub(super) fn clear(&mut self) {
        self.slopes.clear();
        self.runs.clear();
        self.goes_on = false;
    }

    /// Adds a piece that begins and ends at slopes, without an edge before unless the one before has ended.
    pub(super) fn add(&mut self, start: f64, end: f64) {
        if self.slopes.is_empty() {
            self.start_slope = start;
        }
        let is_next = self.slopes.last() == Some(&start);
        if !(self.goes_on && is_next) {
            self.runs.push(Run { first: self.slopes.len(), slope: end, border: None });
        }
        self.slopes.push(end);
        self.goes_on = true;
        if let Some(run) = self.runs.last_mut() {
            run.slope = end;
        }
    }

    /// The piece added last ends at an edge.
    pub(super) fn end(&mut self, border: Option<Border>) {
        self.goes_on = false;
        if let Some(run) = self.runs.last_mut() {
            run.border = border;
        }
    }

    /// Calls back with the parts of a slice that is turned by so much, not farther from the slice's ends than an edge may move, in pixels
    /// of a picture that are not said to be unwanted, as [`Slice::crossings`] is told.
    pub fn parts(
        &mut self,
        beside: &Slice,
        turned_rad: f64,
        size: Size,
        unwanted_around: impl Fn(usize, usize) -> Option<Window>,
        mut call: impl FnMut(Part),
    ) {
        self.move_ends(beside, turned_rad);
        let Self { start_slope, slopes, runs, ends, .. } = self;
        let Some((last_run, end_slope)) = runs.len().checked_sub(1).zip(slopes.last()) else { return };
        let farthest = beside.length_of_px(FARTHEST_SHIFT_PX);
        let [low, high] = [(*start_slope, -farthest), (*end_slope, farthest)]
            .map(|(slope, beyond)| beside.length_at_slope(slope) + beyond);
        let (mut run, mut piece) = (0, 0);
        for crossing in beside.crossings(size, unwanted_around) {
            let [from, to] = crossing.lengths;
            let (mut from, to) = (from.max(low), to.min(high));
            let mut passed = beside.area_at(from);
            while from < to {
                while run < last_run && ends[run].length <= from {
                    run += 1;
                }
                let until = if run < last_run { ends[run].length.min(to) } else { to };
                // Of the pieces of a run the one that lies beside.
                let last_piece = runs.get(run + 1).map_or(slopes.len(), |next| next.first) - 1;
                piece = piece.max(runs[run].first);
                if piece < last_piece {
                    let slope = beside.slope_at(0.5 * (from + until));
                    while piece < last_piece && slopes[piece] > slope {
                        piece += 1;
                    }
                }
                let area = beside.area_at(until);
                if area > passed {
                    call(Part { piece, pixel: crossing.pixel, area_per_rad: area - passed });
                }
                (from, passed) = (until, area);
            }
        }
    }

    /// Finds where runs end on a slice that is turned.
    fn move_ends(&mut self, beside: &Slice, turned_rad: f64) {
        let Self { runs, ends, .. } = self;
        let turn = turned_rad.sin_cos();
        let farthest = beside.length_of_px(FARTHEST_SHIFT_PX);
        ends.clear();
        ends.extend(runs.iter().map(|run| {
            let unmoved = beside.length_at_slope(run.slope);
            let shift = |slope: f64| {
                let shift = beside.length_at_slope(slope) - unmoved;
                if slope.is_finite() { shift.clamp(-farthest, farthest) } else { 0.0 }
            };
            let shifts = run.border.map_or([0.0; 2], |border| border.slopes_beside(turn).map(shift));
            let distance = run.border.map_or(f64::INFINITY, |border| border.distance());
            End { unmoved, shifts, moved: 1.0, distance, length: unmoved }
        }));
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
}

/// Two edges that move towards each other do so until they meet, or the farther until the nearer hides it. On the other side, where they part, they
/// move as far and no farther. So what slices beside gain and lose is the same in the mean over all slices, and the mean of many pictures is right.
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
        /// Whatever edges do between slices.
        #[test]
        fn parts_are_the_whole_slice_beside(
            to_light in prop::array::uniform3(-1.0..1.0_f64).prop_filter_map("a direction", |v| DVec3::from(v).try_normalize()),
            part in 0.05..0.95_f64,
            turned_rad in -0.02..0.02_f64,
            // After each piece: nothing, an edge of nothing known, or a border that leads anywhere.
            after in prop::collection::vec((0..3_u8, prop::array::uniform3(-1.0..1.0_f64)), 60),
        ) {
            let fan = Fan::of_pinhole(1.0, SIZE, to_light);
            let angle = fan.angles.0 + part * fan.angles.1;
            let slices = (fan.slice(angle, Ring::WHOLE), fan.slice(angle + turned_rad, Ring::WHOLE));
            let (Some(slice), Some(beside)) = slices else { return Ok(()) };
            let mut outline = Outline::default();
            let crossings: Vec<_> = slice.crossings(SIZE, |_, _| None).collect();
            for (crossing, (edge, along)) in crossings.iter().zip(&after) {
                let [start, end] = slice.slopes(crossing);
                outline.add(start, end);
                let border = Border::through(DVec3::new(1.0, end, 0.0), DVec3::from(*along));
                match edge {
                    0 => {}
                    1 => outline.end(None),
                    _ => outline.end(Some(border)),
                }
            }
            let pieces = crossings.len().min(after.len());
            let (mut at, mut passed) = (0, 0.0);
            outline.parts(&beside, turned_rad, SIZE, |_, _| None, |part| {
                assert!(at <= part.piece && part.piece < pieces, "{part:?} after {at}, of {pieces}");
                assert!(part.area_per_rad > 0.0, "{part:?}");
                (at, passed) = (part.piece, passed + part.area_per_rad);
            });
            // But for what lies beyond the slice's ends.
            let farthest = beside.length_of_px(FARTHEST_SHIFT_PX);
            let end = slice.slopes(&crossings[pieces - 1])[1];
            let [low, high] = [(slice.slopes(&crossings[0])[0], -farthest), (end, farthest)]
                .map(|(slope, beyond)| beside.area_at((beside.length_at_slope(slope) + beyond).clamp(0.0, beside.length)));
            prop_assert!((passed - (high - low)).abs() < 1e-9 * beside.area_per_rad, "{passed} {low} {high}");
        }

        /// Whether they meet beside the slice or not.
        #[test]
        fn what_lies_between_two_edges_has_its_length_in_the_mean(
            to_light in prop::array::uniform3(-1.0..1.0_f64).prop_filter_map("a direction", |v| DVec3::from(v).try_normalize()),
            part in 0.2..0.8_f64,
            along in prop::array::uniform2(prop::array::uniform2(-1.0..1.0_f64)),
            gap_per_rad in 0.05..1.0_f64,
        ) {
            let turned_rad = 1e-3;
            let fan = Fan::of_pinhole(1.0, SIZE, to_light);
            let angle = fan.angles.0 + part * fan.angles.1;
            let slice_at = |turn: f64| fan.slice(angle + turn, Ring::WHOLE);
            let (Some(own), Some(left), Some(right)) = (slice_at(0.0), slice_at(-turned_rad), slice_at(turned_rad)) else { return Ok(()) };
            let middle = own.slope_at(0.5 * own.length);
            let slopes = [middle, middle - gap_per_rad * turned_rad];
            let mut outline = Outline::default();
            for (slope, [x, y]) in slopes.into_iter().zip(along) {
                outline.add(slope + 1.0, slope);
                outline.end(Some(Border::through(DVec3::new(1.0, slope, 0.0), DVec3::new(x, y, 1.0))));
            }
            let gap = |ends: [f64; 2]| ends[1] - ends[0];
            let beside = [(left, -turned_rad), (right, turned_rad)].map(|(slice, turn)| {
                outline.move_ends(&slice, turn);
                gap([0, 1].map(|end| outline.ends[end].length))
            });
            let unmoved = gap(slopes.map(|slope| own.length_at_slope(slope)));
            prop_assert!((0.5 * (beside[0] + beside[1]) - unmoved).abs() < 0.05 * unmoved, "{beside:?} {unmoved}");
        }
    }
}
