//! Atomic writes. In go bytes, out comes a file. Invariant: at every moment the final name has either its
//! earlier contents or all new bytes, and the bytes are on the disk before the name is.

use super::{FrameFileError, leftovers};
use std::ffi::OsStr;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Writes `bytes` to `path` through a temporary file in the same folder, which is created if necessary.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), FrameFileError> {
    write_whole(path, &[bytes])
}

/// Writes a file from parts, through a temporary file in the same folder, which is created if necessary.
///
/// # Errors
/// If the folder cannot be created or the file cannot be written; an earlier file then stays.
pub fn write_whole(path: &Path, parts: &[&[u8]]) -> Result<(), FrameFileError> {
    let (Some(name), false) = (path.file_name(), path.is_dir()) else {
        return Err(FrameFileError::IsFolder { path: path.to_owned() });
    };
    let folder = folder_of(path);
    fs::create_dir_all(folder)
        .map_err(|source| FrameFileError::CreateFolder { path: folder.to_owned(), source })?;
    write_in(folder, path, name, parts)
        .map_err(|source| FrameFileError::Write { path: path.to_owned(), source })
}

/// Checks that files can be written to a folder, which need not exist yet; leaves no trace.
///
/// # Errors
/// If the folder, or its nearest existing ancestor, is not a folder or not writable.
pub fn check_folder(folder: &Path) -> Result<(), FrameFileError> {
    match tempfile::tempfile_in(nearest(folder)) {
        Ok(_) => Ok(()),
        Err(source) => Err(FrameFileError::CreateFolder { path: folder.to_owned(), source }),
    }
}

/// Checks that a file of this name can be written in its folder, which need not exist yet; leaves no trace.
///
/// # Errors
/// If the system refuses the name, or the longer one of its temporary file.
pub fn check_name(path: &Path) -> Result<(), FrameFileError> {
    let there = nearest(folder_of(path));
    let tried = path.file_name().map(|name| leftovers::temporary(there, name));
    tried.transpose().map(drop).map_err(|source| FrameFileError::Write { path: path.to_owned(), source })
}

/// Nearest existing ancestor of a folder.
fn nearest(folder: &Path) -> &Path {
    folder.ancestors().find(|ancestor| ancestor.exists()).unwrap_or(Path::new("."))
}

fn write_in(folder: &Path, path: &Path, name: &OsStr, parts: &[&[u8]]) -> io::Result<()> {
    let mut temporary = leftovers::temporary(folder, name)?;
    let unfinished = temporary.path().to_owned();
    writes().push(unfinished.clone());
    let written = parts.iter().try_for_each(|part| temporary.write_all(part));
    let synced = written.and_then(|()| temporary.as_file().sync_all());
    let mut writes = writes();
    // On an error it is dropped, which removes the file.
    let persisted = synced.and_then(|()| temporary.persist(path).map_err(|error| error.error));
    writes.retain(|path| *path != unfinished);
    persisted?;
    drop(writes);
    // The folder's entry has to reach the disk as well. Network shares refuse that (EINVAL, ENOTSUP, EIO);
    // the frame's own bytes are safe by then.
    #[cfg(unix)]
    let _ = fs::File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Temporary files that this process is writing.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn writes() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of this process, and blocks all later writes forever: for the moment before it
/// exits.
pub fn abandon_writes() {
    let unfinished = writes();
    unfinished.iter().for_each(|path| drop(fs::remove_file(path)));
    std::mem::forget(unfinished);
}

/// Folder of `path`; for a bare name the current one.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn makes_folders_and_leaves_one_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/picture.exr");
        write(&path, b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
        assert_eq!(names(path.parent().unwrap()), ["picture.exr"]);
    }

    #[test]
    fn replaces_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        write(&path, b"first").unwrap();
        write(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
    }

    #[test]
    #[cfg(unix)]
    fn others_may_read_the_file() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (ours, ordinary) = (folder.path().join("ours"), folder.path().join("ordinary"));
        write(&ours, b"").unwrap();
        fs::write(&ordinary, b"").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&ours), mode(&ordinary));
    }

    #[test]
    fn a_folder_in_the_files_place_is_an_error_with_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let error = write(folder.path(), b"x").unwrap_err();
        assert!(matches!(error, FrameFileError::IsFolder { .. }));
        assert!(error.remedy().contains("--out"));
    }

    #[test]
    fn a_file_in_the_folders_place_is_an_error_with_a_remedy() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), b"").unwrap();
        let error = write(&folder.path().join("file/picture.exr"), b"x").unwrap_err();
        assert!(matches!(error, FrameFileError::CreateFolder { .. }));
        assert!(error.remedy().contains("is a file"), "{}", error.remedy());
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.exr");
        write(&path, b"old").unwrap();
        check_name(&folder.path().join("not there/picture.exr")).unwrap();
        // A name that the folder cannot hold fails after the folder was made.
        let long = folder.path().join("x".repeat(300));
        assert!(check_name(&long).unwrap_err().remedy().contains("shorter"));
        assert!(matches!(write(&long, b"new"), Err(FrameFileError::Write { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["picture.exr"]);
    }
}
