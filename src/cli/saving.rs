//! Files of commands other than `render`. In go bytes, out come files. Invariant: a file is whole or absent;
//! leftovers of killed runs are removed, and their number is reported.

use super::{CliError, tell};
use std::path::Path;
use sunfleck::diagnostic::shown;
use sunfleck::frame_file::{self, FrameFileError, folder_of};

/// Writes a file from parts; its folder is created if necessary.
pub(super) fn save(path: &Path, parts: &[&[u8]]) -> Result<(), CliError> {
    clear(path);
    frame_file::write_whole(path, parts).map_err(failure)
}

/// Removes leftovers of killed runs of a file.
pub(super) fn clear(path: &Path) {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    clear_folder(folder_of(path), |wanted| wanted == name);
}

/// Removes leftovers of killed runs in a folder; `is_wanted` gets the bytes of final names.
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

/// Error of a file that cannot be read or written.
pub(super) fn failure(error: FrameFileError) -> CliError {
    CliError::InputOutput(error.diagnostic().to_string())
}
