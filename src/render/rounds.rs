//! Rounds in which a picture is rendered. In go a sampling and wanted pixels, out come rounds. Invariant: a
//! round's samples are a pure function of its number and the pixel, so leaving pixels out changes no other
//! pixel.

use super::{Job, Watch};
use crate::film::{BLOCK_SIDE, Film, Mask};
use crate::scene::{PixelFilter, Sampling, Size, Window};
use crate::transport::slices::FARTHEST_SHIFT_PX;

/// Distance in pixels from which a sample may count in a pixel. An edge moves by at most
/// [`FARTHEST_SHIFT_PX`] along its slice, and so does the next edge that it meets. A swath adds a pixel.
const REACH_PX: usize = 3 * FARTHEST_SHIFT_PX as usize + 1;

/// Maximum number of samples a pixel of the first round: with 4 many blocks end by chance, with 16 too few
/// could have ended before (docs/decisions/tolerance.md).
const FIRST_SAMPLES: u32 = 8;

/// Samples of the first round with a tolerance of at least [`LOOSE`], for which 8 are mostly more than
/// enough.
const FIRST_SAMPLES_LOOSE: u32 = 3;

/// See [`FIRST_SAMPLES_LOOSE`].
pub(super) const LOOSE: f64 = 0.25;

/// Schedule of rounds, each of which doubles the samples before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Schedule {
    /// Samples in the first round, at least 1.
    pub(super) first: u32,
    /// Maximum number of rounds after it; their samples lie between its own.
    pub(super) doublings: u32,
}

impl Schedule {
    /// One round for a fixed number of samples, otherwise rounds up to the maximum.
    pub(super) fn of(sampling: Sampling) -> Self {
        match sampling {
            Sampling::Exactly(samples) => Self { first: samples, doublings: 0 },
            Sampling::Until { tolerance, most } if tolerance >= LOOSE => {
                Self::doubling(FIRST_SAMPLES_LOOSE, most)
            }
            // Doubled a few times, they reach about the maximum number of samples of a pixel.
            Sampling::Until { most, .. } => {
                Self::doubling(most >> most.div_ceil(FIRST_SAMPLES).next_power_of_two().ilog2(), most)
            }
        }
    }

    fn doubling(first: u32, most: u32) -> Self {
        let first = first.min(most);
        Self { first, doublings: (most / first).ilog2() }
    }

    /// Samples a pixel after all rounds.
    pub(super) fn in_all(self) -> u32 {
        self.first << self.doublings
    }

    /// Round `number` of the pixels wanted; `None` if there are no more.
    pub(super) fn round(self, number: u32, wanted: &Mask) -> Option<Round<'_>> {
        (number <= self.doublings).then_some(Round { number, schedule: self, wanted })
    }
}

/// One sampling of some pixels: the first of a picture, or one that doubles their samples. All rounds so far
/// are together as well distributed as one with all their samples.
#[derive(Clone, Copy)]
pub(super) struct Round<'a> {
    /// Number of earlier rounds.
    pub(super) number: u32,
    pub(super) schedule: Schedule,
    /// Pixels that get its samples.
    pub(super) wanted: &'a Mask,
}

impl Round<'_> {
    /// Whether no round follows.
    pub(super) fn is_last(&self) -> bool {
        self.number == self.schedule.doublings
    }

    /// Samples a pixel, at least 1.
    pub(super) fn samples(&self) -> u32 {
        self.schedule.first << self.number.saturating_sub(1)
    }

    /// Samples a pixel of all earlier rounds.
    pub(super) fn before(&self) -> u32 {
        if self.is_first() { 0 } else { self.samples() }
    }

    /// Whether there are no earlier rounds.
    pub(super) fn is_first(&self) -> bool {
        self.number == 0
    }

    /// Side in pixels of the squares within which a sample of one pixel may count in another, and within
    /// which edges continue. After the first round these are blocks, so no block depends on the rounds of
    /// others.
    pub(super) fn region_side(&self) -> usize {
        if self.is_first() { usize::MAX } else { BLOCK_SIDE }
    }

    /// Whether a sample of one pixel may count in another: see [`Round::region_side`].
    pub(super) fn may_share(&self, from: (usize, usize), to: (usize, usize)) -> bool {
        let side = self.region_side();
        let region = |(x, y): (usize, usize)| (x / side, y / side);
        self.is_first() || region(from) == region(to) && self.wanted.contains(to.0, to.1)
    }

    /// Mask of the pixels whose samples count: wanted ones, and their neighbours within the radius of the
    /// filter. Samples beside the film count in it.
    pub(super) fn seen(&self, full: Size, filter: PixelFilter) -> Mask {
        match filter {
            PixelFilter::Box if !self.is_first() => self.wanted.clone(),
            PixelFilter::Box => (0..REACH_PX).fold(self.wanted.clone(), |mask, _| mask.with_rim(full)),
            PixelFilter::BlackmanHarris => self.wanted.with_rim(full),
        }
    }
}

/// A picture that is rendered in rounds: all of it, or one component.
pub(super) trait Picture {
    /// An empty film of a window of it.
    fn film(&self, job: &Job, window: Window) -> Film;

    /// Power of the number of samples by which its errors fall.
    fn convergence(&self) -> f64;

    /// Samples a pixel below which a block's error may be the same in both halves, so that they agree by
    /// chance.
    fn fewest_samples(&self) -> u32;

    fn add_round(&self, round: &Round, film: &mut Film, watch: &Watch);

    /// Traces a ray for every pixel without a sample.
    fn fill_holes(&self, film: &mut Film, watch: &Watch);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_round_doubles_the_samples() {
        let mask = Mask::all(Window { x: 0, y: 0, width: 1, height: 1 });
        for tolerance in [0.02, 0.4] {
            for most in [1, 3, 4, 100, 1024, 65536] {
                let schedule = Schedule::of(Sampling::Until { tolerance, most });
                let mut before = 0;
                for round in (0..).map_while(|number| schedule.round(number, &mask)) {
                    assert_eq!(round.before(), before);
                    assert!(round.is_first() || round.samples() == before, "{before}");
                    before += round.samples();
                }
                assert_eq!(before, schedule.in_all());
                assert!(before <= most && most < 2 * before, "{before} of {most}");
            }
        }
    }
}
