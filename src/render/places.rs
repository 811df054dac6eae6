//! Places of slices among those of all rounds. In goes a slice's number, out come its place and the phase of
//! its samples. Invariant: slices of a round lie half way between those of the rounds before. So all rounds
//! together are one lattice, as well distributed as a single round.

use super::rounds::{Round, Schedule};

/// Phase step from place to place in a single round. Places and phases are a lattice in two dimensions; no
/// other lattice of few points is better distributed.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// Phase step from place to place in rows of [`FINEST`] places. Shorter rows have its double, its fourfold
/// and so on. It was found by computer search: with each, in pixels that see two to eight times as many
/// slices as a row has places, no two points are closer than 0.64 by the root of a point's share. The golden
/// ratio has 0.89, its half 0.79, its quarter 0.56.
const PHASE_STEP: f64 = 0.960_362_336_315_445_8;

/// See [`PHASE_STEP`].
const FINEST: f64 = 16384.0;

/// The places of a round. A *row* has the places from one slice of the first round to the next; all rows have
/// the same number.
#[derive(Clone, Copy)]
pub(super) struct Places {
    /// Step from slice to slice, in places.
    pub(super) step: usize,
    first: usize,
}

/// Places in a row, a power of two: as many as the last round needs.
pub(super) fn per_row(schedule: Schedule) -> usize {
    1 << schedule.doublings
}

impl Places {
    pub(super) fn of_round(round: &Round) -> Self {
        let per_row = per_row(round.schedule);
        if round.is_first() {
            return Self { step: per_row, first: 0 };
        }
        let first = per_row >> round.number;
        Self { step: 2 * first, first }
    }

    /// The place of slice `number` of this round.
    pub(super) fn of(&self, number: usize) -> usize {
        self.first + number * self.step
    }
}

/// Phase of the samples of a place's slice in its pieces, `0..1`, without the shift that all slices share.
pub(super) fn phase(place: usize, per_row: usize) -> f64 {
    let step = match per_row {
        1 => GOLDEN_RATIO,
        per_row => (PHASE_STEP * (FINEST / per_row as f64)).fract(),
    };
    (place as f64 * step).fract()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::Mask;
    use crate::scene::Window;

    fn wanted() -> Mask {
        Mask::all(Window { x: 0, y: 0, width: 1, height: 1 })
    }

    #[test]
    fn rounds_put_their_slices_between_those_before() {
        let (wanted, schedule) = (wanted(), Schedule { first: 8, doublings: 3 });
        let mut all = Vec::new();
        for number in 0..4 {
            let places = Places::of_round(&schedule.round(number, &wanted).expect("not the last"));
            all.extend((places.first..64).step_by(places.step));
            all.sort_unstable();
            let even: Vec<usize> = (0..64).step_by(8 >> number).collect();
            assert_eq!(all, even);
        }
    }

    #[test]
    fn a_single_round_has_its_slices_in_their_order() {
        let (wanted, schedule) = (wanted(), Schedule { first: 8, doublings: 0 });
        let places = Places::of_round(&schedule.round(0, &wanted).expect("the first"));
        assert!((0..20).all(|number| places.of(number) == number));
    }

    /// Shortest distance between points of the lattice of places and phases, where a pixel sees so many
    /// slices, by the root of a point's share.
    fn evenness(per_row: usize, slices: f64) -> f64 {
        let distance = |number: usize| {
            let phase = phase(number, per_row);
            (number as f64 / slices).hypot(phase.min(1.0 - phase)) * slices.sqrt()
        };
        (1..4 * slices as usize).map(distance).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn phases_are_even_whatever_rounds_there_may_be() {
        for doublings in 0..14 {
            let per_row = per_row(Schedule { first: 8, doublings });
            for rows in [2, 4, 8] {
                let slices = (rows * per_row).min(512) as f64;
                let evenness = evenness(per_row, slices);
                assert!(evenness > 0.6, "{doublings} doublings, {slices} slices: {evenness:.2}");
            }
        }
    }
}
