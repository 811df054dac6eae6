//! Task of a run over frames. In go its settings, out come errors with the frame. Invariant: after a failed
//! frame no other one is written.

use super::{FrameList, OutputPattern};
use crate::color::Display;
use crate::film::FrameDefects;
use crate::frame_file::FrameFileError;
use std::sync::atomic::AtomicBool;

/// Frames that need no rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Skip {
    /// Those that are whole and were made by this version from this scene and these settings.
    Valid,
    /// All that exist.
    Exists,
    /// None: render everything again.
    #[default]
    None,
}

/// Settings of a run.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Frames.
    pub frames: &'a FrameList,
    /// Pattern of their paths.
    pub output: &'a OutputPattern,
    /// Rule for skipping frames.
    pub skip: Skip,
    /// Writes a PNG beside each frame with this display; for skipped frames, from their files.
    pub preview: Option<Display>,
    /// Set by a signal: no frame is started, and those in progress may be abandoned.
    pub stop: &'a AtomicBool,
    /// Called after the first frame with the number of frames left; returns how many to render at once.
    pub workers: &'a (dyn Fn(usize) -> usize + Sync),
}

impl std::fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { frames, output, skip, preview, .. } = self;
        write!(f, "Job {{ {frames:?}, {output:?}, {skip:?}, {preview:?} }}")
    }
}

/// Error of a run. Frames written before are whole and stay.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError<E> {
    /// A frame could not be rendered.
    #[error("frame {frame}: {source}")]
    Render {
        /// The frame.
        frame: i64,
        /// The renderer's error.
        source: E,
    },
    /// A frame holds NaN or infinity and was not written.
    #[error("frame {frame} is not written, for it holds values that are no light: {defects}")]
    Defective {
        /// The frame.
        frame: i64,
        /// Number of defects, and the place of the first.
        defects: FrameDefects,
    },
    /// A frame could not be written.
    #[error("frame {frame}: {source}")]
    Write {
        /// The frame.
        frame: i64,
        /// The disk's error, with a remedy.
        source: FrameFileError,
    },
}
