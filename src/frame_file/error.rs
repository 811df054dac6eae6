//! Errors of frame files. In go causes, out come messages and remedies. Invariant: every error names the
//! path.

use crate::diagnostic::{Diagnostic, Place, shown};
use std::io;
use std::path::{Path, PathBuf};

/// Expectation for the limit on file sizes.
pub const WITHIN_LIMIT: &str =
    "a file within the limit of file sizes (`ulimit -f`, and what the file system takes)";

/// Remedy for the limit on file sizes.
pub const RAISE_LIMIT: &str = "allow larger files (`ulimit -f unlimited`), then run the command again; `render --skip valid` keeps whole frames";

/// Error of writing or reading a file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FrameFileError {
    /// The output's name is that of a folder, or not a file name.
    #[error("{} is a folder, not a file", shown(path))]
    IsFolder {
        /// The path.
        path: PathBuf,
    },
    /// The folder for the output cannot be created or written to.
    #[error("cannot make a file in the folder {}: {source}", shown(path))]
    CreateFolder {
        /// The folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The bytes could not be written to the disk. The file's name has its earlier contents.
    #[error("cannot write {}: {source}", shown(path))]
    Write {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The frame cannot be encoded.
    #[error("cannot encode {}: {reason}", shown(path))]
    Encode {
        /// The file.
        path: PathBuf,
        /// The encoder's error.
        reason: String,
    },
    /// The animation's format cannot hold the pictures.
    #[error("cannot make {}: {reason}", shown(path))]
    Animation {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A folder has two frames with one number.
    #[error("{} and {} are both frame {number}", shown(path), shown(other))]
    SameNumber {
        /// First file.
        path: PathBuf,
        /// Second file.
        other: PathBuf,
        /// Number at the end of their names; 0 without one.
        number: i64,
    },
    /// The file cannot be read from the disk.
    #[error("cannot read {}: {source}", shown(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The file is not EXR, or damaged.
    #[error("{} is no whole EXR file: {reason}", shown(path))]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The decoder's error.
        reason: String,
    },
    /// The file is an EXR of an unsupported kind.
    #[error("{}: {what} cannot be read", shown(path))]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// The feature.
        what: String,
        /// Way to convert the file to a supported one.
        remedy: String,
    },
    /// The header declares more memory than the file can need.
    #[error("{} claims {bytes} bytes of pixels, more than {limit}", shown(path))]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Bytes claimed.
        bytes: u64,
        /// Bytes allowed.
        limit: u64,
    },
}

impl FrameFileError {
    /// File or folder concerned.
    pub fn path(&self) -> &Path {
        match self {
            Self::IsFolder { path }
            | Self::CreateFolder { path, .. }
            | Self::Write { path, .. }
            | Self::Encode { path, .. }
            | Self::Animation { path, .. }
            | Self::SameNumber { path, .. }
            | Self::Read { path, .. }
            | Self::Invalid { path, .. }
            | Self::Unsupported { path, .. }
            | Self::TooLarge { path, .. } => path,
        }
    }

    /// Expectation that was not met.
    pub fn expected(&self) -> &'static str {
        match self {
            Self::IsFolder { .. } => "the name of a file",
            Self::CreateFolder { .. } => "a folder, or a place where one can be made",
            Self::Write { source, .. } if source.kind() == io::ErrorKind::FileTooLarge => WITHIN_LIMIT,
            Self::Write { .. } => "a folder that can be written to, with room for the file",
            Self::Encode { .. } => "a frame that a file of this kind can hold",
            Self::Animation { .. } => "pictures that an animation of this format can hold",
            Self::SameNumber { .. } => "a folder of one sequence",
            Self::Read { .. } => "a readable file",
            Self::Invalid { .. } | Self::TooLarge { .. } => "a whole EXR file",
            Self::Unsupported { .. } => {
                "an EXR file of flat parts, of any compression but JPEG 2000 and Zstandard"
            }
        }
    }

    /// Remedy for the user.
    pub fn remedy(&self) -> &str {
        match self {
            Self::IsFolder { .. } => "move the folder away, or end --out with / to write into it",
            Self::CreateFolder { source, .. } | Self::Write { source, .. } => match source.kind() {
                io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                    "free some space or choose another place (`--out`), then run the command again; `render --skip valid` keeps whole frames"
                }
                io::ErrorKind::FileTooLarge => RAISE_LIMIT,
                io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                    "make the folder writable or choose another place (`--out`)"
                }
                io::ErrorKind::NotADirectory | io::ErrorKind::AlreadyExists => {
                    "a part of the path is a file: move it away or choose another place (`--out`)"
                }
                io::ErrorKind::InvalidFilename => {
                    "choose a name that is shorter (`--out`): while it is written it is 22 bytes longer"
                }
                io::ErrorKind::NotFound => {
                    "see that nothing else removes files there, such as a second run of the same frames"
                }
                _ => {
                    "see that the disk is there and writable, then run the command again; `render --skip valid` keeps whole frames"
                }
            },
            Self::Encode { .. } => "report this: a frame that was rendered should be one that can be written",
            Self::SameNumber { .. } => "name one file, or one sequence such as x.####.exr",
            Self::Animation { .. } => {
                "make fewer or smaller pictures, or a picture a frame: --out NAME.####.png"
            }
            Self::Read { source, .. } => match source.kind() {
                io::ErrorKind::NotFound => "check the path",
                io::ErrorKind::PermissionDenied => "make the file readable",
                _ => "see that the path is a file and the disk is in order",
            },
            Self::Invalid { .. } => "render or copy the file again",
            Self::Unsupported { remedy, .. } => remedy,
            Self::TooLarge { .. } => "the header is most likely damaged: render or copy the file again",
        }
    }

    /// Diagnostic of the error, for the user.
    pub fn diagnostic(&self) -> Diagnostic {
        Diagnostic::error(Place::Nowhere, self.to_string()).expected(self.expected()).remedy(self.remedy())
    }
}
