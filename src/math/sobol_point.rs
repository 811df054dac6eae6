//! Points of one low-discrepancy sequence by their numbers. In goes a number, out come coordinates, as many as are asked for. Invariant: those of
//! the first `2^k` numbers, and of every aligned run of as many, are evenly spread, in each coordinate and in the first two together best of all.

use super::sampler::mix;

/// One point of an Owen-scrambled Sobol sequence (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)).
pub struct SobolPoint {
    number: u32,
    seed: u32,
    next_dimension: u32,
}

impl SobolPoint {
    /// How many points a sequence has before they repeat.
    pub const COUNT: usize = 1 << 16;

    /// Point `number` of the sequence `stream`, of which there may be any number.
    pub fn new(seed: u32, stream: u32, number: usize) -> Self {
        Self { number: (number % Self::COUNT) as u32, seed: mix(seed ^ mix(stream)), next_dimension: 0 }
    }

    /// The next so many coordinates, each in `[0, 1)`.
    pub fn take<const N: usize>(&mut self) -> [f64; N] {
        [(); N].map(|()| {
            let dimension = self.next_dimension;
            self.next_dimension += 1;
            f64::from(sobol_burley::sample(self.number, dimension, self.seed))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn aligned_runs_are_even() {
        for start in (0..60_000).step_by(16 * 97) {
            let mut hits = [0; 16];
            for number in start..start + 16 {
                let [u, v] = SobolPoint::new(7, 3, number).take();
                hits[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
            }
            assert_eq!(hits, [1; 16]);
        }
    }

    #[test]
    fn every_coordinate_is_even() {
        let mut hits = [[0; 32]; 8];
        for number in 0..32 {
            for (hits, u) in hits.iter_mut().zip(SobolPoint::new(5, 0, number).take::<8>()) {
                hits[(u * 32.0) as usize] += 1;
            }
        }
        assert_eq!(hits, [[1; 32]; 8]);
    }

    #[test]
    fn streams_and_seeds_differ() {
        let [first, second, third] =
            [(0, 0), (0, 1), (1, 0)].map(|(seed, stream)| SobolPoint::new(seed, stream, 1).take::<1>());
        assert!(first != second && first != third && second != third);
    }
}
