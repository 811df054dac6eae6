//! What a run over frames is to do, and why it fails. Invariant: behind a failure no frame is written.

use super::{FrameList, OutputPattern};
use crate::color::Display;
use crate::film::FrameDefects;
use crate::frame_file::FrameFileError;
use std::sync::atomic::AtomicBool;

/// Which frames need no rendering.
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

/// Task of a run.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// Frames.
    pub frames: &'a FrameList,
    /// Pattern of their paths.
    pub output: &'a OutputPattern,
    /// Frames that need no rendering.
    pub skip: Skip,
    /// Writes a PNG beside each frame, shown so; of frames that are kept, from their files.
    pub preview: Option<Display>,
    /// Set by a signal: frames in progress are given up unless they get done, and none is begun.
    pub stop: &'a AtomicBool,
    /// Asked once the first frame is done: how many of so many that are left are to be rendered at once.
    pub workers: &'a (dyn Fn(usize) -> usize + Sync),
}

impl std::fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { frames, output, skip, preview, .. } = self;
        write!(f, "Job {{ {frames:?}, {output:?}, {skip:?}, {preview:?} }}")
    }
}

/// Why a run failed. Frames written before are whole and stay.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError<E> {
    /// A frame could not be rendered.
    #[error("frame {frame}: {source}")]
    Render {
        /// The frame.
        frame: i64,
        /// The renderer's reason.
        source: E,
    },
    /// A frame holds NaN or infinity and was not written.
    #[error("frame {frame} is not written, for it holds values that are no light: {defects}")]
    Defective {
        /// The frame.
        frame: i64,
        /// Defects: how many, and where first.
        defects: FrameDefects,
    },
    /// A frame could not be written.
    #[error("frame {frame}: {source}")]
    Write {
        /// The frame.
        frame: i64,
        /// The disk's reason, with a remedy.
        source: FrameFileError,
    },
}
