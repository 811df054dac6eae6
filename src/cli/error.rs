//! Errors of commands, with exit codes. In go causes, out come messages and codes. Invariant: the code tells
//! scripts the kind of error, the text tells people the rest.

use sunfleck::api::{RenderError, Setting};
use sunfleck::description::LoadError;
use sunfleck::diagnostic::{Diagnostic, Diagnostics, Place};

/// Exit code of an invalid command line.
pub(super) const USAGE: u8 = 2;
const SCENE: u8 = 3;
pub(super) const INPUT_OUTPUT: u8 = 4;
const FRAME: u8 = 5;

#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    /// A value on the command line cannot be used (exit code 2).
    #[error("{0}")]
    Usage(Diagnostic),
    /// The scene cannot be used (3).
    #[error("{0}")]
    Scene(Diagnostics),
    /// A file cannot be read or written (4).
    #[error("{0}")]
    InputOutput(String),
    /// A frame failed its checks, or differs too much from another (5).
    #[error("{0}")]
    Frame(String),
    /// A signal ended the command (128 + its number).
    #[error("stopped by signal {0}: what is whole is kept")]
    Signal(u8),
    /// A signal ended a run over frames (128 + its number).
    #[error("stopped by signal {0}: what is whole is kept; `render` goes on with --skip valid")]
    Interrupted(u8),
}

impl CliError {
    /// The process's exit code.
    pub(super) fn code(&self) -> u8 {
        match self {
            Self::Usage(_) => USAGE,
            Self::Scene(_) => SCENE,
            Self::InputOutput(_) => INPUT_OUTPUT,
            Self::Frame(_) => FRAME,
            Self::Signal(number) | Self::Interrupted(number) => 128 + number,
        }
    }
}

impl From<LoadError> for CliError {
    fn from(error: LoadError) -> Self {
        match error {
            LoadError::Invalid(diagnostics) => Self::Scene(diagnostics.worst()),
            _ => Self::InputOutput(error.diagnostics().to_string()),
        }
    }
}

impl From<Diagnostics> for CliError {
    fn from(diagnostics: Diagnostics) -> Self {
        Self::Scene(diagnostics.worst())
    }
}

impl From<RenderError> for CliError {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Setting { setting, found, expected } => usage(&flag(setting), found, &expected),
            RenderError::Defective(_) => Self::Frame(error.diagnostic().to_string()),
            RenderError::Write(error) => Self::InputOutput(error.diagnostic().to_string()),
            RenderError::Export(error) => Self::Scene(Diagnostics(vec![*error])),
            _ => Self::InputOutput(error.diagnostic().to_string()),
        }
    }
}

fn flag(setting: Setting) -> String {
    match setting {
        Setting::Frame => String::from("--frames"),
        Setting::Method => String::from("--volume-steps"),
        setting => format!("--{setting}"),
    }
}

pub(super) fn usage(flag: &str, found: String, expected: &str) -> CliError {
    CliError::Usage(Diagnostic::error(Place::Nowhere, format!("{flag}: {found}")).expected(expected).remedy(
        format!("change {flag}: `--help` says what there is, `sunfleck inspect` what the input holds"),
    ))
}
