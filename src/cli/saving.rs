//! The files of commands other than `render`. Invariant: a file is whole or not there; what killed runs left
//! of it is removed, and said with a count.

use super::{CliError, tell};
use std::path::Path;
use sunfleck::diagnostic::shown;
use sunfleck::frame_file::{self, FrameFileError, folder_of};

/// Writes a file that is made of parts; its folder is made if need be.
pub(super) fn save(path: &Path, parts: &[&[u8]]) -> Result<(), CliError> {
    clear(path);
    frame_file::write_whole(path, parts).map_err(failure)
}

/// Removes what killed runs left of a file.
pub(super) fn clear(path: &Path) {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    clear_folder(folder_of(path), |wanted| wanted == name);
}

/// Removes what killed runs left in a folder, of the files that are wanted by the bytes of their names.
pub(super) fn clear_folder(folder: &Path, is_wanted: impl Fn(&[u8]) -> bool) {
    let removed = frame_file::remove_abandoned(folder, is_wanted).len();
    let plural = if removed == 1 { "" } else { "s" };
    if removed > 0 {
        tell(&format!(
            "removed {removed} unfinished file{plural} that killed runs left in {}",
            shown(folder)
        ));
    }
}

/// A file that cannot be read or written.
pub(super) fn failure(error: FrameFileError) -> CliError {
    CliError::InputOutput(error.diagnostic().to_string())
}
