//! Low-discrepancy points with given places in an order. In goes a place, out come coordinates. Invariant:
//! together with the place they are a Sobol sequence. So the points of every aligned run of places are well
//! distributed, and so are those of rounds that each halve the distance of places.

use super::sampler::mix;
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev, u32_to_f32_norm};

/// Steps from row to row of a point in its stratum: powers of the inverse of the root of x^6 = x + 1, an
/// additive recurrence in five dimensions (Roberts 2018, "The unreasonable effectiveness of quasirandom
/// sequences").
const ROW_STEPS: [f64; 5] = [
    0.881_271_461_633_569_6,
    0.776_639_389_089_768_3,
    0.684_430_129_585_342_7,
    0.603_168_740_685_728_3,
    0.531_555_397_715_791_4,
];

/// Number of places that share a sequence, as a power of two: the library uses sixteen bits of a point's
/// index.
const SEQUENCE_BITS: u32 = 16;

/// Coordinates of a place.
///
/// The first coordinate of a Sobol sequence is its van der Corput sequence: a point's index is its first
/// coordinate with the binary digits reversed. With that coordinate as the place, all others are known, in
/// any order of places. Each has an Owen scrambling of its own.
pub struct PlacedPoints {
    /// The place, as a binary fraction.
    place: u32,
    seed: u32,
    next_dimension: u32,
    strata: Option<Strata>,
}

/// Strata with one point each, repeated row after row.
#[derive(Clone, Copy)]
struct Strata {
    /// Their number, as a power of two.
    bits: u32,
    row: usize,
}

impl PlacedPoints {
    /// Coordinates of a place in the order `stream`, of any length.
    pub fn new(seed: u32, stream: u32, place: usize) -> Self {
        let sequence = (place >> SEQUENCE_BITS) as u32;
        let place = (place as u32) << (u32::BITS - SEQUENCE_BITS);
        Self { place, seed: mix(seed ^ mix(stream ^ mix(sequence))), next_dimension: 1, strata: None }
    }

    /// Coordinates of a place where the strata of the first `period` places recur, each time with another
    /// point in the stratum. So every run of `period` places is as well distributed as the first.
    pub fn in_strata(seed: u32, stream: u32, place: usize, period: usize) -> Self {
        let strata = Strata { bits: period.max(1).ilog2(), row: place / period.max(1) };
        Self { strata: Some(strata), ..Self::new(seed, stream, place % period.max(1)) }
    }

    /// The next `N` coordinates, each in `[0, 1)`.
    pub fn take<const N: usize>(&mut self) -> [f64; N] {
        std::array::from_fn(|coordinate| {
            let dimension = self.next_dimension;
            self.next_dimension += 1;
            let point = owen_scramble_rev(sobol_rev(self.place, dimension), hash(self.seed ^ mix(dimension)));
            let point = f64::from(u32_to_f32_norm(point.reverse_bits()));
            let Some(Strata { bits, row }) = self.strata else { return point };
            // Cells have the same number of digits in each of the first two coordinates, or one more in the
            // first.
            let digits = [bits.div_ceil(2), bits / 2].get(coordinate).copied().unwrap_or(0);
            let cells = f64::from(1_u32 << digits);
            let start = f64::from(mix(self.seed ^ mix(dimension ^ mix(self.place)))) / 2.0_f64.powi(32);
            let step = ROW_STEPS[(dimension as usize - 1) % ROW_STEPS.len()];
            ((point * cells).floor() + (start + row as f64 * step).fract()) / cells
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_even(places: impl Iterator<Item = usize>) {
        let mut hits = [0; 16];
        for place in places {
            let [u, v] = PlacedPoints::new(7, 3, place).take();
            hits[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
        }
        assert_eq!(hits, [1; 16]);
    }

    #[test]
    fn aligned_runs_are_even() {
        for start in (0..200_000).step_by(16 * 97) {
            assert_even(start..start + 16);
        }
    }

    #[test]
    fn places_that_halve_their_distance_are_even() {
        for distance in [1, 2, 4, 64, 4096] {
            assert_even((0..16).map(|number| number * distance));
            assert_even((0..16).map(|number| number * distance + distance / 2));
        }
    }

    /// Every run is stratified, and so are rows together, finer than the strata.
    #[test]
    fn strata_come_again_with_other_points() {
        let point = |place| PlacedPoints::in_strata(7, 3, place, 16).take::<2>();
        for start in (0..1600).step_by(16) {
            let mut hits = [0; 16];
            for [u, v] in (start..start + 16).map(point) {
                hits[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
            }
            assert_eq!(hits, [1; 16]);
        }
        let mut firsts: Vec<f64> = (0..64).map(|row| point(16 * row + 5)[0] * 4.0).map(f64::fract).collect();
        firsts.sort_by(f64::total_cmp);
        assert!(firsts.windows(2).all(|pair| pair[1] - pair[0] < 2.5 / 64.0), "{firsts:?}");
    }

    #[test]
    fn streams_and_seeds_differ() {
        let [first, second, third] =
            [(0, 0), (0, 1), (1, 0)].map(|(seed, stream)| PlacedPoints::new(seed, stream, 1).take::<1>());
        assert!(first != second && first != third && second != third);
    }
}
