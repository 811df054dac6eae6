//! The OpenVDB files that a path stands for: one, or one a frame where signs stand for a number. In go paths,
//! out come grids by frame. Invariant: a sequence has no gap.

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
    /// The grids of each file: at least one.
    pub frames: Vec<Arc<[Grid]>>,
}

/// Reads them; `referrer` says who asks for them.
///
/// # Errors
/// If a file cannot be read, is damaged, or is missing in a sequence.
pub fn load_files(path: &Path, referrer: &str, files: &mut Files) -> Result<GridFiles, LoadError> {
    let mut grids = |path: &Path| Ok(parse(&files.read(path, Some(referrer))?, path)?.into());
    let (first_frame, frames) = match Numbered::of(path) {
        None => (0, vec![grids(path)?]),
        Some(numbered) => {
            let numbers = numbered.numbers(referrer)?;
            let first = *numbers.start();
            let frames = numbers.map(|number| grids(&numbered.file(number)));
            (first, frames.collect::<Result<_, LoadError>>()?)
        }
    };
    Ok(GridFiles { path: path.to_owned(), first_frame, frames })
}
