//! Frames whose indirect light may err by far more than the tolerance. In go frames as they are rendered, out
//! comes one warning a run, or an error with `--strict`. Invariant: the error compared with the tolerance is
//! the one that the frame's line reports.

use super::tell;
use std::sync::{Mutex, PoisonError};
use sunfleck::diagnostic::{Diagnostic, Loss, Place};
use sunfleck::render::Statistics;
use sunfleck::scene::Sampling;

/// Maximum error of indirect light, relative to the tolerance.
const MOST: f64 = 3.0;

const REMEDY: &str = "a larger --tolerance, or --volume paths, whose light is unbiased and noisy";

/// Frame whose indirect light exceeds that error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Doubt {
    frame: i64,
    /// Reported error, relative to the picture's mean.
    error: f64,
    tolerance: f64,
}

impl Doubt {
    /// `None` if it is within limits, or without a tolerance.
    pub(super) fn of(frame: i64, statistics: &Statistics, sampling: Sampling) -> Option<Self> {
        let (Sampling::Until { tolerance, .. }, Some(error)) = (sampling, statistics.grid_error) else {
            return None;
        };
        (error > MOST * tolerance).then_some(Self { frame, error, tolerance })
    }

    fn sentence(&self) -> String {
        let [error, tolerance] = [self.error, self.tolerance].map(|share| 100.0 * share);
        format!(
            "frame {}: indirect light may err by {error:.1} %, asked for are {tolerance:.1} %",
            self.frame
        )
    }

    /// Reason for not writing it.
    pub(super) fn refusal(&self) -> String {
        let mut error = Diagnostic::warning(Loss::IndirectLight, Place::Nowhere, self.sentence());
        error.severity = sunfleck::diagnostic::Severity::Error;
        error.remedy(REMEDY).to_string()
    }
}

/// Counts such frames.
#[derive(Default)]
pub(super) struct Doubts(Mutex<(usize, Option<Doubt>)>);

impl Doubts {
    pub(super) fn count(&self, doubt: Doubt) {
        let (count, worst) = &mut *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        *count += 1;
        *worst = Some(worst.filter(|worst| worst.error >= doubt.error).unwrap_or(doubt));
    }

    /// Reports the worst one, if there are any.
    pub(super) fn tell(&self) {
        let (count, worst) = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(worst) = worst else { return };
        let which = if count > 1 { format!("{count} frames, the worst: ") } else { String::new() };
        let found = format!("{which}{}", worst.sentence());
        let warning = Diagnostic::warning(Loss::IndirectLight, Place::Nowhere, found);
        tell(&warning.counting(count).remedy(REMEDY).to_string());
    }
}
