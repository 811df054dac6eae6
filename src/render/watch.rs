//! Observers of a rendering. In go finished shares of the work, out come reports of progress. Invariant: an
//! observer can cancel a picture, and otherwise has no effect on it.

use crate::film::Frame;
use std::time::{Duration, Instant};

/// Observer of a frame's rendering. It has no effect on a finished frame.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Receives the progress now and then, from any thread.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Returns whether to stop; the frame is then unfinished.
    pub cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Called after each round; it may ask for the picture so far.
    pub look: Option<&'a Look<'a>>,
    /// Receives the duration of each stage.
    pub stage: &'a (dyn Fn(Stage, Duration) + Sync),
}

/// Stage of a frame whose time is reported; the rest are the samples of its components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Light of higher orders from its grids.
    IndirectLight,
    /// Random walks that correct it, and the survey of components.
    Walks,
}

/// Receives a function that makes the picture so far, which takes time.
pub type Look<'a> = dyn Fn(&dyn Fn() -> Frame) + Sync + 'a;

impl Watch<'static> {
    /// No observer.
    pub const NOBODY: Self = Self { progress: &|_| {}, cancelled: &|| false, look: None, stage: &|_, _| {} };
}

impl Watch<'_> {
    /// Reports a part of the work as the range from `start` to `end`, in fractions of all of it.
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

    /// Reports the duration of a stage.
    pub(super) fn timed<R>(&self, stage: Stage, work: impl FnOnce() -> R) -> R {
        let started = Instant::now();
        let result = work();
        (self.stage)(stage, started.elapsed());
        result
    }

    /// Reports the fraction of the work that is done.
    pub(super) fn tell(&self, fraction: f64) {
        (self.progress)(Progress::new(fraction, None));
    }
}

/// Progress of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// Estimated share of the work that is done, `0..=1`.
    pub fraction: f64,
    /// Largest estimated relative error of a block of pixels, if there is a tolerance.
    pub error: Option<f64>,
}

impl Progress {
    /// Progress with a fraction and an error.
    pub fn new(fraction: f64, error: Option<f64>) -> Self {
        Self { fraction, error }
    }
}
