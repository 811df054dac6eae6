//! OpenVDB files of a path: one, or a numbered sequence. In go paths, out come files by frame. Invariant: a
//! sequence has no gap, and its bytes are kept, so later changes on the disk have no effect.

use super::{Grid, parse};
use crate::description::numbered::Numbered;
use crate::description::{Files, LoadError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// OpenVDB files of a path.
#[derive(Clone, Debug)]
pub struct GridFiles {
    /// Path, with its placeholder.
    pub path: PathBuf,
    /// Number of the first file.
    pub first_frame: i64,
    /// Files, at least one.
    pub frames: Vec<Arc<GridFile>>,
}

/// Valid file. Those of sequences stay compressed, as all their grids together may exceed memory.
#[derive(Debug)]
pub enum GridFile {
    /// Decoded grids.
    Read(Arc<[Grid]>),
    /// Bytes of the file.
    Packed(Box<[u8]>),
}

impl GridFile {
    /// Decoded grids.
    pub fn grids(&self) -> Arc<[Grid]> {
        match self {
            Self::Read(grids) => Arc::clone(grids),
            // The file was validated when it was read.
            Self::Packed(bytes) => parse(bytes, Path::new("")).unwrap_or_default().into(),
        }
    }
}

/// Reads the files; `referrer` is the place that refers to them.
///
/// # Errors
/// If a file cannot be read, is damaged, or is missing in a sequence.
pub fn load_files(path: &Path, referrer: &str, files: &mut Files) -> Result<GridFiles, LoadError> {
    let (first_frame, frames) = match Numbered::of(path) {
        None => {
            let grids = parse(&files.read(path, Some(referrer))?, path)?;
            (0, vec![Arc::new(GridFile::Read(grids.into()))])
        }
        Some(numbered) => {
            let numbers = numbered.numbers(referrer)?;
            let first = *numbers.start();
            let packed = |number| {
                let path = numbered.file(number);
                let bytes = files.read(&path, Some(referrer))?;
                parse(&bytes, &path)?;
                Ok(Arc::new(GridFile::Packed(bytes.into())))
            };
            (first, numbers.map(packed).collect::<Result<_, LoadError>>()?)
        }
    };
    Ok(GridFiles { path: path.to_owned(), first_frame, frames })
}
