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
    /// How much of a slice beside lies before the end of each run, in its length.
    ends: Vec<f64>,
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
                while run < last_run && ends[run] <= from {
                    run += 1;
                }
                let until = if run < last_run { ends[run].min(to) } else { to };
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
        for run in runs.iter() {
            let unmoved = beside.length_at_slope(run.slope);
            let moved = run.border.and_then(|border| border.slope_beside(turn));
            let end = moved.map_or(unmoved, |slope| {
                beside.length_at_slope(slope).max(unmoved - farthest).min(unmoved + farthest)
            });
            // What grows narrower ends where its edges meet.
            let end = match ends.last_mut() {
                Some(before) if end < *before => {
                    *before = 0.5 * (*before + end);
                    *before
                }
                _ => end,
            };
            ends.push(end);
        }
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
    }
}
