//! Events of a run, for those who watch. Invariant: every frame of the list ends in exactly one of
//! skipped, written, given up or none of them, and the summary counts them.

use crate::diagnostic::shown;
use crate::film::Dark;
use crate::render::{Progress, Statistics};
use std::fmt;
use std::path::PathBuf;

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The run begins.
    Started {
        /// Frames in the list, skipped ones included.
        frames: usize,
    },
    /// A killed run had left a temporary file, which is gone now.
    AbandonedRemoved {
        /// The file.
        path: PathBuf,
    },
    /// A frame is left as it is.
    FrameSkipped {
        /// The frame.
        frame: i64,
        /// Why.
        reason: SkipReason,
    },
    /// A frame that is left as it is gets no picture beside it.
    PreviewOmitted {
        /// The frame.
        frame: i64,
        /// Fault of its file, or of the disk.
        reason: String,
    },
    /// A frame is being rendered.
    FrameStarted {
        /// The frame.
        frame: i64,
    },
    /// Some of it is done.
    FrameProgress {
        /// The frame.
        frame: i64,
        /// Progress and error so far.
        progress: Progress,
    },
    /// It took longer than it may; its earlier file stays.
    FrameGivenUp {
        /// The frame.
        frame: i64,
        /// Time that it was rendered for, seconds.
        seconds: f64,
    },
    /// It is on the disk.
    FrameWritten {
        /// The frame.
        frame: i64,
        /// Path.
        path: PathBuf,
        /// Time of rendering, seconds.
        seconds: f64,
        /// Time of encoding and writing, seconds.
        write_seconds: f64,
        /// Values that were too large for half precision and stored as the largest half.
        clamped: usize,
        /// Whether next to nothing is seen on it.
        dark: Option<Dark>,
        /// Statistics of its rendering.
        statistics: Statistics,
    },
    /// The run is over, be it complete or stopped; a run that fails ends without.
    Finished(Summary),
}

/// Why a frame was not rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkipReason {
    /// Its file holds what rendering would give.
    Valid,
    /// It has a file.
    Exists,
}

/// Summary of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Frames written.
    pub written: usize,
    /// Frames skipped because their files are valid.
    pub skipped_valid: usize,
    /// Frames skipped because they have files.
    pub skipped_existing: usize,
    /// Frames that took longer than they may.
    pub given_up: Vec<i64>,
    /// Frames not reached because the run was stopped.
    pub not_reached: usize,
    /// Time of the run, seconds.
    pub seconds: f64,
    /// Folder of the frames.
    pub folder: PathBuf,
    /// True if a signal ended the run early.
    pub stopped: bool,
}

impl Summary {
    pub(super) fn count_skipped(&mut self, reason: SkipReason) {
        match reason {
            SkipReason::Valid => self.skipped_valid += 1,
            SkipReason::Exists => self.skipped_existing += 1,
        }
    }

    /// Frames that are written, kept or given up.
    pub(super) fn done(&self) -> usize {
        self.written + self.skipped_valid + self.skipped_existing + self.given_up.len()
    }
}

impl fmt::Display for SkipReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Valid => "there already, and valid",
            Self::Exists => "there already",
        })
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.written == 1 { "" } else { "s" };
        write!(
            f,
            "{} frame{plural} written to {} in {:.1} s",
            self.written,
            shown(&self.folder),
            self.seconds
        )?;
        for (count, what) in [
            (self.skipped_valid, SkipReason::Valid.to_string()),
            (self.skipped_existing, SkipReason::Exists.to_string()),
        ] {
            if count > 0 {
                write!(f, "; {count} skipped ({what})")?;
            }
        }
        if !self.given_up.is_empty() {
            let frames: Vec<String> = self.given_up.iter().map(ToString::to_string).collect();
            write!(f, "; given up, for they took too long: {}", frames.join(", "))?;
        }
        if self.stopped {
            write!(f, "; stopped with {} to go", self.not_reached)?;
        }
        Ok(())
    }
}
