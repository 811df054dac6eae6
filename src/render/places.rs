//! Which places slices of a fan have among all that any pass may ask for. In goes a slice's number, out come its place and where along it its samples lie. Invariant: slices of a pass lie half way
//! between those of the passes before, so all passes together are one lattice, as even as if it had been rendered at once.

use super::passes::SamplePass;

/// Of a single pass: places and phases are a lattice in two dimensions, and none of few points is more even.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// The phase from place to place in rows of [`FINEST`] places. It, its double and so on, which are those of rows of fewer, have been sought by a computer: with each the
/// lattice, in pixels of twice to eight times as many slices as places in a row, has no two points closer than 0.64 by the root of a point's share. The golden ratio has 0.89, its half 0.79, its
/// quarter 0.56.
const PHASE_STEP: f64 = 0.960_362_336_315_445_8;

/// See [`PHASE_STEP`].
const FINEST: f64 = 16384.0;

/// The places of a pass.
///
/// A *row* is what lies between a slice of the first pass and the next; all rows have as many places.
#[derive(Clone, Copy)]
pub(super) struct Places {
    /// A power of two.
    pub(super) per_row: usize,
    /// From slice to slice.
    pub(super) step: usize,
    first: usize,
}

impl Places {
    /// Of a fan that has all its slices in one pass.
    pub(super) const ALL: Self = Self { per_row: 1, step: 1, first: 0 };

    /// Those of a pass over a fan to which later passes come back.
    pub(super) fn of_pass(pass: &SamplePass) -> Self {
        // As many as the last pass wants.
        let per_row = 1 << pass.doublings;
        if pass.is_first() {
            return Self { per_row, step: per_row, first: 0 };
        }
        let first = per_row >> pass.number;
        Self { per_row, step: 2 * first, first }
    }

    /// The place of slice `number` of this pass.
    pub(super) fn of(&self, number: usize) -> usize {
        self.first + number * self.step
    }

    /// Where in its pieces the samples of a place's slice lie, `0..1`, but for a shift that is the same for all.
    pub(super) fn phase(&self, place: usize) -> f64 {
        let step = match self.per_row {
            1 => GOLDEN_RATIO,
            per_row => (PHASE_STEP * (FINEST / per_row as f64)).fract(),
        };
        (place as f64 * step).fract()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Mask;
    use crate::scene::Window;

    #[test]
    fn passes_put_their_slices_between_those_before() {
        let wanted = Mask::all(Window { x: 0, y: 0, width: 1, height: 1 });
        let mut all = Vec::new();
        for number in 0..4 {
            let samples = 8 << number.saturating_sub(1);
            let pass = SamplePass { number, doublings: 3, samples, wanted: &wanted };
            let places = Places::of_pass(&pass);
            assert_eq!(places.per_row, 8);
            all.extend((places.first..64).step_by(places.step));
            all.sort_unstable();
            let even: Vec<usize> = (0..64).step_by(8 >> number).collect();
            assert_eq!(all, even);
        }
    }

    #[test]
    fn a_single_pass_has_its_slices_in_their_order() {
        let wanted = Mask::all(Window { x: 0, y: 0, width: 1, height: 1 });
        let places = Places::of_pass(&SamplePass::only(8, &wanted));
        assert!((0..20).all(|number| places.of(number) == number));
    }

    /// The shortest distance between points of the lattice of places and phases, where a pixel sees so many slices, by the root of a point's share.
    fn evenness(places: &Places, slices: f64) -> f64 {
        let distance = |number: usize| {
            let phase = places.phase(number);
            (number as f64 / slices).hypot(phase.min(1.0 - phase)) * slices.sqrt()
        };
        (1..4 * slices as usize).map(distance).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn phases_are_even_whatever_passes_there_may_be() {
        let wanted = Mask::all(Window { x: 0, y: 0, width: 1, height: 1 });
        for doublings in 0..14 {
            let places = Places::of_pass(&SamplePass { doublings, ..SamplePass::only(8, &wanted) });
            for rows in [2, 4, 8] {
                let slices = (rows * places.per_row).min(512) as f64;
                let evenness = evenness(&places, slices);
                assert!(evenness > 0.6, "{doublings} doublings, {slices} slices: {evenness:.2}");
            }
        }
    }
}
