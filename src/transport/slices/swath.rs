//! The swath of the picture that a slice stands for: all that lies nearer to it than to the next slices. In go where a piece of a
//! slice lies and how far those are, out come the pixels that its swath reaches into. Invariant: what lies in the piece's pixel and in
//! the two beside it is the whole swath.
//!
//! Were a pixel the mean of those slices alone that cross it, whatever changes from slice to slice, as nearly every edge does, would err by as much
//! as these slices lie off the pixel's middle. Swaths leave no gap between them and count no place twice, so what changes evenly comes out right. The price is a filter
//! that is wider than the pixel by a swath.

use glam::DVec2;

/// That of a slice in one pixel. It is measured across the rows if the slice runs rather along these, otherwise across the columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Swath {
    is_across_rows: bool,
    /// How far into the pixel's row, or column, the slice enters it, and how much farther it leaves it, pixels.
    enter_px: f64,
    growth_px: f64,
    /// From the slice to the swath's borders, pixels.
    half_px: f64,
}

/// A pixel, and how much of a swath lies in it.
pub type Share = ((usize, usize), f64);

impl Swath {
    /// Of a slice that crosses a pixel from one end to the other, in the direction `along`, a unit vector, with the next slices so many pixels away on
    /// either side. `None` if its swath lies in the pixel.
    pub(super) fn new(
        (x, y): (usize, usize),
        ends_px: [DVec2; 2],
        along: DVec2,
        separation_px: f64,
    ) -> Option<Self> {
        let along = along.abs();
        let is_across_rows = along.x >= along.y;
        let [enter, leave] =
            ends_px.map(|end| if is_across_rows { end.y - y as f64 } else { end.x - x as f64 });
        // Slices that lie so far apart that swaths reach beyond the next pixel are not even anyway.
        let half_px = (0.5 * separation_px / along.max_element()).clamp(f64::MIN_POSITIVE, 1.0);
        let is_within = enter.min(leave) >= half_px && enter.max(leave) <= 1.0 - half_px;
        (!is_within).then_some(Self { is_across_rows, enter_px: enter, growth_px: leave - enter, half_px })
    }

    /// Of the swath of a piece in a `range` of its chord, `0..=1`: which pixels before and after the chord's own hold a part of it, and how much, `0..=1`. Before the
    /// first row and column lies `usize::MAX`.
    pub fn shares_beside(&self, (x, y): (usize, usize), range: [f64; 2]) -> [Share; 2] {
        let Self { is_across_rows, enter_px, growth_px, half_px } = *self;
        let [start, end] = range.map(|part| enter_px + part * growth_px);
        let part = |start: f64, end: f64| 0.5 * mean_of_positive(start, end) / half_px;
        let before = part(half_px - start, half_px - end);
        let after = part(half_px + start - 1.0, half_px + end - 1.0);
        if is_across_rows {
            [((x, y.wrapping_sub(1)), before), ((x, y + 1), after)]
        } else {
            [((x.wrapping_sub(1), y), before), ((x + 1, y), after)]
        }
    }
}

/// The mean of what is positive of a quantity that goes evenly from `a` to `b`.
fn mean_of_positive(a: f64, b: f64) -> f64 {
    let (low, high) = (a.min(b), a.max(b));
    if low >= 0.0 {
        0.5 * (low + high)
    } else if high <= 0.0 {
        0.0
    } else {
        0.5 * high * high / (high - low)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const PIXEL: (usize, usize) = (7, 4);

    proptest! {
        /// Against so many points of the swath, each in the pixel that it lies in.
        #[test]
        fn shares_are_what_lies_in_each_pixel(
            angle in 0.0..std::f64::consts::TAU,
            separation_px in 1e-6..1.4_f64,
            (start, end) in (prop::array::uniform2(0.0..1.0_f64), prop::array::uniform2(0.0..1.0_f64)),
        ) {
            let corner = DVec2::new(PIXEL.0 as f64, PIXEL.1 as f64);
            let along = DVec2::from_angle(angle);
            // Some way along the slice within the pixel.
            let from = DVec2::from(start);
            let length = [0, 1].map(|axis| {
                let room = if along[axis] > 0.0 { 1.0 - from[axis] } else { from[axis] };
                room / along[axis].abs().max(1e-12)
            });
            let length = length[0].min(length[1]) * end[0];
            let ends = [from, from + length * along].map(|end| corner + end);
            let swath = Swath::new(PIXEL, ends, along, separation_px);
            let found = swath.map_or([(PIXEL, 0.0); 2], |swath| swath.shares_beside(PIXEL, [0.25, 0.75]));

            let steps = 200;
            let middles = (0..steps).map(|step| (f64::from(step) + 0.5) / f64::from(steps));
            // A swath between parallel lines is as wide across rows, or columns, wherever it is cut.
            let across = if along.x.abs() >= along.y.abs() { DVec2::Y } else { DVec2::X };
            let width_px = separation_px / along.abs().max_element();
            let mut counts = std::collections::HashMap::new();
            for t in middles.clone() {
                for u in middles.clone() {
                    let point = ends[0].lerp(ends[1], 0.25 + 0.5 * t) + (u - 0.5) * width_px * across;
                    *counts.entry((point.x.floor() as usize, point.y.floor() as usize)).or_insert(0) += 1;
                }
            }
            for (pixel, share) in found {
                let counted = counts.remove(&pixel).filter(|_| share > 0.0).unwrap_or(0);
                let counted = f64::from(counted) / f64::from(steps * steps);
                prop_assert!((share - counted).abs() < 0.01, "{pixel:?}: {share} {counted}");
            }
            let own = counts.remove(&PIXEL).unwrap_or(0);
            let rest: i32 = counts.values().sum();
            prop_assert!(f64::from(rest) < 0.01 * f64::from(steps * steps), "{rest} of {own} elsewhere");
        }
    }

    #[test]
    fn a_slice_in_the_middle_of_its_pixel_keeps_a_narrow_swath() {
        let swath = |y: f64| Swath::new(PIXEL, [7.2, 7.9].map(|x| DVec2::new(x, y)), DVec2::X, 0.5);
        assert_eq!(swath(4.5), None);
        let at_the_border = swath(5.0).unwrap().shares_beside(PIXEL, [0.0, 1.0]);
        assert_eq!(at_the_border, [((7, 3), 0.0), ((7, 5), 0.5)]);
    }
}
