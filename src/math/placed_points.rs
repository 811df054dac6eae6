//! Low-discrepancy points whose places in an order are given. In goes a place, out come coordinates.
//! Invariant: together with the place itself they are a Sobol sequence. So the points of every aligned run of
//! places are evenly spread, and so are those of places that only ever halve their distance.

use super::sampler::mix;
use sobol_burley::parts::{hash, owen_scramble_rev, sobol_rev, u32_to_f32_norm};

/// Number of places that share a sequence, as a power of two: the library keeps sixteen bits of a point's
/// number.
const SEQUENCE_BITS: u32 = 16;

/// The coordinates that belong to a place.
///
/// The first coordinate of a Sobol sequence is its van der Corput sequence: the number of a point is its
/// first coordinate with its binary digits in reverse. So with that as the place any other coordinate is
/// known, whichever places are asked for first. Each has an Owen scrambling of its own.
pub struct PlacedPoints {
    /// The place, as a binary fraction.
    place: u32,
    seed: u32,
    next_dimension: u32,
}

impl PlacedPoints {
    /// The coordinates of a place in the order `stream`, of which there may be any number.
    pub fn new(seed: u32, stream: u32, place: usize) -> Self {
        let sequence = (place >> SEQUENCE_BITS) as u32;
        let place = (place as u32) << (u32::BITS - SEQUENCE_BITS);
        Self { place, seed: mix(seed ^ mix(stream ^ mix(sequence))), next_dimension: 1 }
    }

    /// The next so many coordinates, each in `[0, 1)`.
    pub fn take<const N: usize>(&mut self) -> [f64; N] {
        [(); N].map(|()| {
            let dimension = self.next_dimension;
            self.next_dimension += 1;
            let point = owen_scramble_rev(sobol_rev(self.place, dimension), hash(self.seed ^ mix(dimension)));
            f64::from(u32_to_f32_norm(point.reverse_bits()))
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

    #[test]
    fn streams_and_seeds_differ() {
        let [first, second, third] =
            [(0, 0), (0, 1), (1, 0)].map(|(seed, stream)| PlacedPoints::new(seed, stream, 1).take::<1>());
        assert!(first != second && first != third && second != third);
    }
}
