//! Why there is no frame. Invariant: every failure says what was found, what was expected and what to do.

use crate::diagnostic::Diagnostic;
use crate::frame_file::FrameFileError;
use std::fmt;

/// Which of a renderer's settings is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Setting {
    /// Name of the camera.
    Camera,
    /// Number of the frame.
    Frame,
    /// Size of the whole picture.
    Size,
    /// The part of it that is wanted.
    Crop,
    /// Samples a pixel.
    Samples,
    /// The error at which a pixel is good enough.
    Tolerance,
    /// How long the shutter is open, and when.
    Shutter,
    /// Steps or points of the method.
    Method,
}

/// Why a frame could not be rendered or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A setting has a value that cannot be rendered of this scene.
    #[error(
        "error: {setting}: {found}\n  expected: {expected}\n  remedy: change what is asked for as {setting}"
    )]
    Setting {
        /// Which.
        setting: Setting,
        /// What was found.
        found: String,
        /// What was expected instead.
        expected: String,
    },
    /// There is not as much memory as the picture takes.
    #[error("{0}")]
    Memory(Box<Diagnostic>),
    /// The frame holds values that are no light: NaN or infinity.
    #[error("{0}")]
    Defective(Box<Diagnostic>),
    /// Whoever looked on said to stop.
    #[error("error: the frame was cancelled\n  expected: time to finish it\n  remedy: render it again")]
    Cancelled,
    /// The scene holds what no glTF file can.
    #[error("{0}")]
    Export(Box<Diagnostic>),
    /// The frame could not be written.
    #[error(
        "error: {0}\n  expected: {expected}\n  remedy: choose a folder that can be written to, with room for the file",
        expected = .0.expected()
    )]
    Write(#[from] FrameFileError),
}

impl RenderError {
    /// A setting that cannot be used.
    pub(super) fn setting(setting: Setting, found: String, expected: impl Into<String>) -> Self {
        Self::Setting { setting, found, expected: expected.into() }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Camera => "camera",
            Self::Frame => "frame",
            Self::Size => "size",
            Self::Crop => "crop",
            Self::Samples => "samples",
            Self::Tolerance => "tolerance",
            Self::Shutter => "shutter",
            Self::Method => "method",
        })
    }
}
