//! Errors of rendering and writing. In go causes, out come diagnostics. Invariant: each names what was found,
//! what was expected and a remedy.

use crate::diagnostic::{Diagnostic, Place};
use crate::frame_file::FrameFileError;
use std::fmt;

/// Setting of a renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Setting {
    /// Name of the camera.
    Camera,
    /// Number of the frame.
    Frame,
    /// Size of the whole picture.
    Size,
    /// Part of the picture to render.
    Crop,
    /// Samples a pixel.
    Samples,
    /// Relative error at which a pixel needs no more samples.
    Tolerance,
    /// Length of the shutter's opening, and its position.
    Shutter,
    /// Steps or points of the method.
    Method,
}

/// Why a frame could not be rendered or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A setting has a value with which this scene cannot be rendered.
    #[error("{setting}: {found}")]
    Setting {
        /// Setting with the value.
        setting: Setting,
        /// The value, and why it cannot be used.
        found: String,
        /// Expectation that was not met.
        expected: String,
    },
    /// The picture needs more memory than there is.
    #[error("{}", .0.line())]
    Memory(Box<Diagnostic>),
    /// The frame holds NaN or infinity.
    #[error("{}", .0.line())]
    Defective(Box<Diagnostic>),
    /// The caller cancelled the rendering.
    #[error("the frame was cancelled")]
    Cancelled,
    /// The scene holds something that glTF cannot represent.
    #[error("{}", .0.line())]
    Export(Box<Diagnostic>),
    /// The frame could not be written.
    #[error("{0}")]
    Write(#[from] FrameFileError),
}

impl RenderError {
    pub(super) fn setting(setting: Setting, found: String, expected: impl Into<String>) -> Self {
        Self::Setting { setting, found, expected: expected.into() }
    }

    /// Diagnostic, with expectation and remedy.
    pub fn diagnostic(&self) -> Diagnostic {
        let error = |expected: &str| Diagnostic::error(Place::Nowhere, self.to_string()).expected(expected);
        match self {
            Self::Setting { setting, expected, .. } => {
                error(expected).remedy(format!("change what is asked for as {setting}"))
            }
            Self::Memory(diagnostic) | Self::Defective(diagnostic) | Self::Export(diagnostic) => {
                Diagnostic::clone(diagnostic)
            }
            Self::Cancelled => error("time to finish it").remedy("render it again"),
            Self::Write(reason) => error(reason.expected())
                .remedy("choose a folder that can be written to, with room for the file"),
        }
    }

    /// Remedy, as a sentence for the user.
    pub fn remedy(&self) -> String {
        self.diagnostic().remedy.map(String::from).unwrap_or_default()
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
