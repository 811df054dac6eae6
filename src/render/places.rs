//! Which places slices have among all that any round may ask for. In goes a slice's number, out come its place and where along it its samples lie. Invariant: slices of a round lie half way
//! between those of the rounds before, so all rounds together are one lattice, as even as if it had been rendered at once.

use super::rounds::Round;

/// Of a single round: places and phases are a lattice in two dimensions, and none of few points is more even.
const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;

/// The phase from place to place in rows of [`FINEST`] places. It, its double and so on, which are those of rows of fewer, have been sought by a computer: with each the
/// lattice, in pixels of twice to eight times as many slices as places in a row, has no two points closer than 0.64 by the root of a point's share. The golden ratio has 0.89, its half 0.79, its
/// quarter 0.56.
const PHASE_STEP: f64 = 0.960_362_336_315_445_8;

/// See [`PHASE_STEP`].
const FINEST: f64 = 16384.0;

/// The places of a round.
///
/// A *row* is what lies between a slice of the first round and the next of the same turn; all rows have as many places.
#[derive(Clone, Copy)]
pub(super) struct Places {
    /// A power of two.
    pub(super) per_row: usize,
    /// From slice to slice.
    pub(super) step: usize,
    first: usize,
}

impl Places {
    /// Those of a round, if slices of the first take so many turns, a power of two.
    pub(super) fn new(round: &Round, turns: usize) -> Self {
        // As many as the last round wants.
        let per_turn = 1 << round.doublings;
        let per_row = turns * per_turn;
        if round.is_first() {
            return Self { per_row, step: per_turn, first: 0 };
        }
        let first = per_turn >> round.number;
        Self { per_row, step: 2 * first * turns, first }
    }

    /// The place of slice `number` of this round.
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

    /// The places of the first eight rows in a round, if three rounds come after the first.
    fn of_pass(number: u32, turns: usize) -> (Places, Vec<usize>) {
        let wanted = Mask::all(Window { x: 0, y: 0, width: 1, height: 1 });
        let round = Round { number, doublings: 3, samples: 8 << number.saturating_sub(1), wanted: &wanted };
        let places = Places::new(&round, turns);
        assert_eq!(places.per_row, 8 * turns);
        (places, (places.first..8 * places.per_row).step_by(places.step).collect())
    }

    #[test]
    fn passes_put_their_slices_between_those_before() {
        let mut all = Vec::new();
        for number in 0..4 {
            all.extend(of_pass(number, 1).1);
            all.sort_unstable();
            let even: Vec<usize> = (0..64).step_by(8 >> number).collect();
            assert_eq!(all, even);
        }
    }

    /// Slices of a turn are twice as far apart; those of later rounds serve the pixels of both turns.
    #[test]
    fn slices_in_turns_leave_their_places_to_others() {
        assert_eq!(of_pass(0, 2).1[..4], [0, 8, 16, 24]);
        assert_eq!(of_pass(1, 2).1[..4], [4, 20, 36, 52]);
        assert_eq!(of_pass(2, 2).1[..4], [2, 10, 18, 26]);
        assert_eq!(of_pass(3, 2).1[..4], [1, 5, 9, 13]);
    }

    #[test]
    fn a_single_pass_has_its_slices_in_their_order() {
        let wanted = Mask::all(Window { x: 0, y: 0, width: 1, height: 1 });
        let places = Places::new(&Round::only(8, &wanted), 1);
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
            for turns in [1, 2] {
                let places = Places::new(&Round { doublings, ..Round::only(8, &wanted) }, turns);
                for rows in [2, 4, 8] {
                    let slices = (rows * places.per_row).min(512) as f64;
                    let evenness = evenness(&places, slices);
                    assert!(
                        evenness > 0.6,
                        "{doublings} doublings, {turns} turns, {slices} slices: {evenness:.2}"
                    );
                }
            }
        }
    }
}
