//! Low-discrepancy points: Owen-scrambled Sobol (Burley 2020, "Practical Hash-based Owen
//! Scrambling", JCGT 9(4)). Invariant: a point is a pure function of (seed, pixel, sample, dimension).

/// The random numbers of one sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sampler {
    seed: u32,
    sample: u32,
    next_set: u32,
}

impl Sampler {
    /// Maximum number of samples of a pixel before points repeat.
    pub const MAX_SAMPLES: u32 = 1 << 16;

    /// The points of `sample` in pixel (`x`, `y`).
    pub fn new(seed: u32, x: u32, y: u32, sample: u32) -> Self {
        let seed = mix(seed ^ mix(x ^ mix(y)));
        Self { seed, sample: sample % Self::MAX_SAMPLES, next_set: 0 }
    }

    /// Number of points drawn so far.
    pub fn drawn(&self) -> u32 {
        self.next_set
    }

    /// Points of one of `of` branches of this sample. All branches of all samples together have the points of
    /// as many samples.
    pub fn branch(&self, number: u32, of: u32) -> Self {
        let sample = u64::from(self.sample) * u64::from(of) + u64::from(number);
        let most = u64::from(Self::MAX_SAMPLES);
        let seed = mix(self.seed.wrapping_add(self.next_set) ^ mix(of ^ mix((sample / most) as u32)));
        Self { seed, sample: (sample % most) as u32, next_set: 0 }
    }

    /// The sampler after so many more points are drawn.
    pub fn after(&self, drawn: u32) -> Self {
        Self { next_set: self.next_set.wrapping_add(drawn), ..*self }
    }

    /// The next two coordinates, each in `[0, 1)`.
    pub fn next_2d(&mut self) -> (f64, f64) {
        let seed = self.next_seed();
        let point = |dimension| f64::from(sobol_burley::sample(self.sample, dimension, seed));
        (point(0), point(1))
    }

    /// The next three coordinates, each in `[0, 1)`.
    pub fn next_3d(&mut self) -> [f64; 3] {
        let seed = self.next_seed();
        [0, 1, 2].map(|dimension| f64::from(sobol_burley::sample(self.sample, dimension, seed)))
    }

    /// The next coordinate, in `[0, 1)`.
    pub fn next_1d(&mut self) -> f64 {
        self.next_2d().0
    }

    /// Padding: each set of dimensions has a sequence of its own (Burley, section 5).
    fn next_seed(&mut self) -> u32 {
        let seed = mix(self.seed.wrapping_add(self.next_set));
        self.next_set += 1;
        seed
    }
}

/// An integer hash (Wellons 2018, "lowbias32").
pub(super) fn mix(mut x: u32) -> u32 {
    x = x.wrapping_add(0x9e37_79b9);
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first 16 points of a two-dimensional Sobol sequence hit each of 4 x 4 cells once.
    #[test]
    fn stratified_in_every_pixel() {
        for pixel in 0..50 {
            let mut hits = [0; 16];
            for sample in 0..16 {
                let (u, v) = Sampler::new(7, pixel, pixel / 3, sample).next_2d();
                hits[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
            }
            assert_eq!(hits, [1; 16]);
        }
    }

    #[test]
    fn branches_are_stratified_together() {
        let mut hits = [0; 16];
        for sample in 0..4 {
            let mut trunk = Sampler::new(7, 3, 0, sample);
            trunk.next_3d();
            for branch in 0..4 {
                let (u, v) = trunk.branch(branch, 4).next_2d();
                hits[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
            }
            assert_ne!(trunk.branch(0, 4).next_2d(), trunk.after(1).branch(0, 4).next_2d());
        }
        assert_eq!(hits, [1; 16]);
    }

    #[test]
    fn the_first_two_of_three_are_stratified_too() {
        for pixel in 0..50 {
            let mut hits = [0; 16];
            for sample in 0..16 {
                let mut sampler = Sampler::new(7, pixel, 0, sample);
                sampler.next_2d();
                let [u, v, w] = sampler.next_3d();
                assert!((0.0..1.0).contains(&w));
                hits[(u * 4.0) as usize * 4 + (v * 4.0) as usize] += 1;
            }
            assert_eq!(hits, [1; 16]);
        }
    }

    #[test]
    fn pixels_differ() {
        assert_ne!(Sampler::new(0, 1, 0, 0).next_2d(), Sampler::new(0, 0, 1, 0).next_2d());
        assert_ne!(Sampler::new(0, 1, 0, 0).next_2d(), Sampler::new(1, 1, 0, 0).next_2d());
    }
}
