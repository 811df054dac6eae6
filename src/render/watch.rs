//! Observers of a rendering. In go finished shares of the work, out come reports of progress. Invariant: an
//! observer can cancel a picture, and otherwise has no effect on it.

use crate::film::Frame;
use std::time::{Duration, Instant};

/// Who looks on while a frame is rendered. None of it reaches a finished frame.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Is told now and then how far the frame is, from any thread.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Tells whether to stop; then the frame comes back unfinished.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Is asked whenever a round is done, and may ask for the picture so far.
    pub look: Option<&'a Look<'a>>,
    /// Is told how long each stage took.
    pub stage: &'a (dyn Fn(Stage, Duration) + Sync),
}

/// Stage of a frame whose time is told; what is left are the samples of its lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Light of higher orders from its grids.
    IndirectLight,
    /// Random walks that correct it, and a look at which light counts where.
    Walks,
}

/// Use of a function that makes the picture so far, which takes its time.
pub type Look<'a> = dyn Fn(&dyn Fn() -> Frame) + Sync + 'a;

impl Watch<'static> {
    /// Nobody.
    pub const NOBODY: Self = Self { progress: &|_| {}, cancelled: &|| false, look: None, stage: &|_, _| {} };
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
            (self.progress)(Progress::new(fraction, part.error.or(error)));
        };
        work(&Watch { progress: &tell, ..*self })
    }

    /// Tells how long a stage took.
    pub(super) fn timed<R>(&self, stage: Stage, work: impl FnOnce() -> R) -> R {
        let started = Instant::now();
        let result = work();
        (self.stage)(stage, started.elapsed());
        result
    }

    /// Tells how much is done.
    pub(super) fn tell(&self, fraction: f64) {
        (self.progress)(Progress::new(fraction, None));
    }
}

/// Progress of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Share of the work that is done, as far as one can tell, `0..=1`.
    pub fraction: f64,
    /// Largest relative error that some block of pixels is estimated to have, if there is a tolerance.
    pub error: Option<f64>,
}

impl Progress {
    /// Progress so far, with that error.
    pub fn new(fraction: f64, error: Option<f64>) -> Self {
        Self { fraction, error }
    }
}
