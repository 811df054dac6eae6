//! Events of a run, for observers. In goes the progress of frames, out come events and a summary. Invariant:
//! every frame of the list ends as skipped, written, given up or not reached, and the summary counts it once.

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
    /// A temporary file of a killed run was removed.
    AbandonedRemoved {
        /// The file.
        path: PathBuf,
    },
    /// A frame was skipped.
    FrameSkipped {
        /// The frame.
        frame: i64,
        /// Why.
        reason: SkipReason,
    },
    /// A skipped frame gets no preview.
    PreviewOmitted {
        /// The frame.
        frame: i64,
        /// Fault of the frame's file or of the disk.
        reason: String,
    },
    /// The rendering of a frame began.
    FrameStarted {
        /// The frame.
        frame: i64,
    },
    /// Part of the frame is done.
    FrameProgress {
        /// The frame.
        frame: i64,
        /// Progress and error so far.
        progress: Progress,
    },
    /// The frame exceeded the time limit; its earlier file stays.
    FrameGivenUp {
        /// The frame.
        frame: i64,
        /// Time that it was rendered for, seconds.
        seconds: f64,
    },
    /// The frame was written.
    FrameWritten {
        /// The frame.
        frame: i64,
        /// Path.
        path: PathBuf,
        /// Time of rendering, seconds.
        seconds: f64,
        /// Time of encoding and writing, seconds.
        write_seconds: f64,
        /// Number of values beyond half precision, stored as the largest half.
        clamped: usize,
        /// Set if the frame looks black.
        dark: Option<Dark>,
        /// Statistics of its rendering.
        statistics: Statistics,
    },
    /// The run ended, complete or stopped; a failed run has no such event.
    Finished(Summary),
}

/// Why a frame was not rendered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkipReason {
    /// Its file is valid and up to date.
    Valid,
    /// Its file exists.
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
    /// Frames that exceeded the time limit.
    pub given_up: Vec<i64>,
    /// Frames not reached before the run stopped.
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

    /// Number of frames that are written, skipped or given up.
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
