//! What a picture is rendered in. Invariant: a pass's samples are a pure function of its place in
//! the order and of the pixel, so that leaving pixels out changes no other pixel.

use super::{Progress, Watch};
use crate::film::{Film, Mask};

/// One sampling of some pixels.
#[derive(Clone, Copy)]
pub(super) struct Pass<'a> {
    /// Passes of one level have the same density, and together are spread as evenly as one.
    pub(super) level: u32,
    /// Which of its level.
    pub(super) number: u32,
    /// Samples a pixel, at least 1.
    pub(super) samples: u32,
    /// Samples a pixel of all passes before.
    pub(super) before: u32,
    /// Which pixels are to have them.
    pub(super) wanted: &'a Mask,
    /// Which of them judge the others (see [`Film::estimates`]).
    pub(super) fresh: Fresh,
}

/// Which of a pass's samples are the fresh half of all samples so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fresh {
    /// All of them: there are passes before.
    All,
    /// Every other one, so that a pass alone can be judged.
    Half,
}

/// Samples a pixel of level 0, with a tolerance: slices of one lattice complete one another, those of several less so. With 4 a tolerance of 0.02 takes
/// as long for nearly twice the error, with 16 one of 0.1 twice as long (docs/decisions/tolerance.md).
const FIRST_SAMPLES: u32 = 8;

/// The passes that come first (`stage` 0), or that double the samples of the pixels wanted for the `stage`-th time;
/// none if that would be more than `most` a pixel.
///
/// Four passes of a level have the density of one of the next. Dense passes are cheap where few pixels want them,
/// for a slice is found as a whole whatever is wanted of it; several sparse ones look at more slices, and so are worth
/// more while nobody knows how few samples will do.
pub(super) fn stage<'a>(stage: u32, most: u32, wanted: &'a Mask) -> Vec<Pass<'a>> {
    let first = FIRST_SAMPLES.min(most);
    if first << stage > most {
        return Vec::new();
    }
    let level = stage.saturating_sub(1) / 2;
    let samples = first << (2 * level);
    let (numbers, before, fresh) = match stage {
        0 => (0..1, 0, Fresh::Half),
        // Number 0 of a level is what all levels below add up to.
        _ if stage % 2 == 1 => (1..2, first << (stage - 1), Fresh::All),
        _ => (2..4, first << (stage - 1), Fresh::All),
    };
    let before = |number| before + (number - numbers.start) * samples;
    numbers
        .clone()
        .map(|number| Pass { level, number, samples, before: before(number), wanted, fresh })
        .collect()
}

/// A picture that is rendered in passes: all of it, or one light's part.
pub(super) trait Picture {
    /// Adds the samples of a pass.
    fn add_pass(&self, pass: &Pass, film: &mut Film, watch: &Watch);

    /// Gives every pixel that got no sample from the passes one of its own.
    fn fill_holes(&self, film: &mut Film, watch: &Watch);
}

impl Watch<'_> {
    /// Tells of a part of the work: the one from `start` to `end`, in fractions of all of it.
    pub(super) fn part<R>(
        &self,
        (start, end): (f64, f64),
        error: Option<f64>,
        work: impl FnOnce(&Watch) -> R,
    ) -> R {
        let tell = |part: Progress| {
            let fraction = start + (end - start) * part.fraction;
            (self.progress)(Progress { fraction, error: part.error.or(error) });
        };
        work(&Watch { progress: &tell, cancelled: self.cancelled, look: self.look })
    }

    /// Tells how much is done.
    pub(super) fn tell(&self, fraction: f64) {
        (self.progress)(Progress { fraction, error: None });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Window;

    #[test]
    fn every_stage_doubles_the_samples() {
        let mask = Mask::all(Window { x: 0, y: 0, width: 1, height: 1 });
        for most in [1, 3, 4, 100, 1024, 65536] {
            let mut before = 0;
            for number in 0.. {
                let passes = stage(number, most, &mask);
                if passes.is_empty() {
                    break;
                }
                let start = before;
                for pass in passes {
                    assert_eq!(pass.before, before);
                    before += pass.samples;
                }
                assert!(number == 0 || before == 2 * start, "{start} {before}");
            }
            assert!(before <= most && most < 2 * before, "{before} of {most}");
        }
    }
}
