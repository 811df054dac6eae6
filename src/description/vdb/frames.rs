//! The OpenVDB files that a path stands for: one, or one a frame where signs stand for a number. In go paths,
//! out come files by frame. Invariant: a sequence has no gap, and its bytes are those that were read first.

use super::{Grid, parse};
use crate::description::numbered::Numbered;
use crate::description::{Files, LoadError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Grid files that a path stands for.
#[derive(Clone, Debug)]
pub struct GridFiles {
    /// The path, with its signs.
    pub path: PathBuf,
    /// The number of the first file.
    pub first_frame: i64,
    /// Each file: at least one.
    pub frames: Vec<Arc<GridFile>>,
}

/// A file that is whole. One of a sequence stays packed: the grids of all of them are larger than memory.
#[derive(Debug)]
pub enum GridFile {
    /// Its grids.
    Read(Arc<[Grid]>),
    /// Its bytes.
    Packed(Vec<u8>),
}

impl GridFile {
    /// Its grids.
    pub fn grids(&self) -> Arc<[Grid]> {
        match self {
            Self::Read(grids) => Arc::clone(grids),
            // It was whole when it was read.
            Self::Packed(bytes) => parse(bytes, Path::new("")).unwrap_or_default().into(),
        }
    }
}

/// Reads them; `referrer` says who asks for them.
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
                Ok(Arc::new(GridFile::Packed(bytes)))
            };
            (first, numbers.map(packed).collect::<Result<_, LoadError>>()?)
        }
    };
    Ok(GridFiles { path: path.to_owned(), first_frame, frames })
}
