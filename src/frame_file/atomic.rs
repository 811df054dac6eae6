//! Bytes to a file, whole or not at all. Invariant: at every moment the final name holds either
//! what it held before or all of the new bytes, and those are on the disk before the name is.

use super::FrameFileError;
use std::fs::{self, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tempfile::NamedTempFile;

/// What our temporary files end with; they begin with a dot and the final file's name.
const TEMPORARY_SUFFIX: &str = ".sunfleck-part";
/// Where files cannot be locked, a temporary one as old as this is nobody's: no frame takes a day to write.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// Writes `bytes` to `path` by way of a temporary file in the same folder, which is created if need be.
pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<(), FrameFileError> {
    write_whole(path, &[bytes])
}

/// Writes a file that is made of parts, by way of a temporary file in the same folder, which is created if need be.
///
/// # Errors
/// If the folder cannot be made or the file not be written; what was there before is then still there.
pub fn write_whole(path: &Path, parts: &[&[u8]]) -> Result<(), FrameFileError> {
    let (Some(name), false) = (path.file_name(), path.is_dir()) else {
        return Err(FrameFileError::IsFolder { path: path.to_owned() });
    };
    let folder = folder_of(path);
    fs::create_dir_all(folder)
        .map_err(|source| FrameFileError::CreateFolder { path: folder.to_owned(), source })?;
    write_in(folder, path, &temporary_prefix(name), parts)
        .map_err(|source| FrameFileError::Write { path: path.to_owned(), source })
}

/// Whether files could be written to a folder, which need not be there yet; nothing is left behind.
///
/// # Errors
/// If the folder, or what there is of the way to it, is no folder or takes no files.
pub fn check_folder(folder: &Path) -> Result<(), FrameFileError> {
    let there = folder.ancestors().find(|ancestor| ancestor.exists()).unwrap_or(Path::new("."));
    match tempfile::tempfile_in(there) {
        Ok(_) => Ok(()),
        Err(source) => Err(FrameFileError::CreateFolder { path: folder.to_owned(), source }),
    }
}

fn write_in(folder: &Path, path: &Path, prefix: &str, parts: &[&[u8]]) -> io::Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(TEMPORARY_SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any other file: the umask decides, where a temporary file would be its owner's alone.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut temporary = claimed(|| builder.tempfile_in(folder))?;
    let unfinished = temporary.path().to_owned();
    writes().push(unfinished.clone());
    let written = parts.iter().try_for_each(|part| temporary.write_all(part));
    let synced = written.and_then(|()| temporary.as_file().sync_all());
    let mut writes = writes();
    // Dropped on an error, it removes itself.
    let persisted = synced.and_then(|()| temporary.persist(path).map_err(|error| error.error));
    writes.retain(|path| *path != unfinished);
    persisted?;
    drop(writes);
    // The new name is an entry of the folder, which the disk should learn of too. Network shares refuse that (EINVAL,
    // ENOTSUP, EIO); the frame's own bytes are safe by then.
    #[cfg(unix)]
    let _ = fs::File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Temporary files that this process is writing.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn writes() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what this process is writing, and has all later writes wait for ever: for the moment before it exits.
pub fn abandon_writes() {
    let unfinished = writes();
    unfinished.iter().for_each(|path| drop(fs::remove_file(path)));
    std::mem::forget(unfinished);
}

/// A temporary file that this process has locked, which tells others that somebody is at work on it. Dropped on an
/// error, it removes itself.
fn claimed(mut create: impl FnMut() -> io::Result<NamedTempFile>) -> io::Result<NamedTempFile> {
    loop {
        let temporary = create()?;
        match temporary.as_file().try_lock() {
            // Another process took it for abandoned before it was locked, and is about to remove it.
            Err(TryLockError::WouldBlock) => continue,
            // Removed already.
            Ok(()) if !temporary.path().exists() => continue,
            // Where files cannot be locked their age tells (see `is_abandoned`).
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(temporary),
        }
    }
}

/// Whether no process is at work on a temporary file: its lock is free, or, where there are no locks, it is old.
fn is_abandoned(temporary: &Path) -> bool {
    let Ok(file) = fs::File::open(temporary) else { return false };
    match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => file
            .metadata()
            .and_then(|metadata| metadata.modified())
            .is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age > ABANDONED_AFTER)),
    }
}

/// Removes what killed runs left of the temporary files of `path`, and says what it removed.
///
/// Only names that [`write`] makes for this very file are touched, and none that another process is still writing: two runs
/// of the same frame at the same time both end with whole frames.
pub fn remove_abandoned(path: &Path) -> Vec<PathBuf> {
    let Some(prefix) = path.file_name().map(temporary_prefix) else { return Vec::new() };
    let Ok(entries) = fs::read_dir(folder_of(path)) else { return Vec::new() };
    entries
        .filter_map(Result::ok)
        .filter(|entry| {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            name.starts_with(&prefix) && name.ends_with(TEMPORARY_SUFFIX)
        })
        .map(|entry| entry.path())
        .filter(|temporary| is_abandoned(temporary) && fs::remove_file(temporary).is_ok())
        .collect()
}

fn temporary_prefix(name: &std::ffi::OsStr) -> String {
    format!(".{}.", name.to_string_lossy())
}

/// The folder that `path` is in; a bare name is in the current one.
fn folder_of(path: &Path) -> &Path {
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
        // A name that the folder cannot hold fails after the folder was made.
        let long = folder.path().join("x".repeat(300));
        assert!(matches!(write(&long, b"new"), Err(FrameFileError::Write { .. })));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["picture.exr"]);
    }

    #[test]
    fn what_another_process_writes_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at_work = folder.path().join(".picture.0001.exr.Ab3dE6.sunfleck-part");
        let file = fs::File::create(&at_work).unwrap();
        file.lock().unwrap();
        assert!(remove_abandoned(&folder.path().join("picture.0001.exr")).is_empty());
        drop(file);
        assert_eq!(remove_abandoned(&folder.path().join("picture.0001.exr")), [at_work]);
    }

    #[test]
    fn a_temporary_file_that_is_taken_for_abandoned_is_made_anew() {
        let folder = tempfile::tempdir().unwrap();
        let mut made = 0;
        let temporary = claimed(|| {
            made += 1;
            let temporary = tempfile::Builder::new().tempfile_in(folder.path())?;
            if made == 1 {
                fs::remove_file(temporary.path())?;
            }
            Ok(temporary)
        });
        assert!(temporary.unwrap().path().exists() && made == 2);
    }

    #[test]
    fn only_our_own_leavings_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        for name in [
            ".picture.0001.exr.Ab3dE6.sunfleck-part",
            ".picture.0002.exr.Ab3dE6.sunfleck-part",
            ".picture.0001.exr.swp",
            "picture.0001.exr",
        ] {
            fs::write(folder.path().join(name), b"half").unwrap();
        }
        let removed = remove_abandoned(&folder.path().join("picture.0001.exr"));
        assert_eq!(removed.len(), 1);
        assert_eq!(
            names(folder.path()),
            [".picture.0001.exr.swp", ".picture.0002.exr.Ab3dE6.sunfleck-part", "picture.0001.exr"]
        );
    }
}
