//! Temporary files, and those that killed runs left. In go names, out come locked files and removals.
//! Invariant: only names that [`temporary`] makes are removed, and none that another process is writing.

use std::ffi::{OsStr, OsString};
use std::fs::{self, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::NamedTempFile;

/// Suffix of temporary files. Their names begin with a dot, the final name, and a dot.
const SUFFIX: &str = ".sunfleck-part";
/// Number of random letters before the suffix.
const RANDOM_LETTERS: usize = 6;
/// Age at which a temporary file counts as abandoned, where files cannot be locked; no frame takes a day to
/// write.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// Creates and locks a temporary file for a file of this name, in its folder. The lock tells other processes
/// that it is in use. It is removed when dropped.
pub(super) fn temporary(folder: &Path, name: &OsStr) -> io::Result<NamedTempFile> {
    let mut prefix = OsString::from(".");
    prefix.push(name);
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).rand_bytes(RANDOM_LETTERS).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Permissions of an ordinary file, by the umask; temporary files are private by default.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    claimed(|| builder.tempfile_in(folder))
}

fn claimed(mut create: impl FnMut() -> io::Result<NamedTempFile>) -> io::Result<NamedTempFile> {
    loop {
        let temporary = create()?;
        match temporary.as_file().try_lock() {
            // Another process locked it first, as abandoned, and is about to remove it.
            Err(TryLockError::WouldBlock) => continue,
            // Another process has removed it.
            Ok(()) if !temporary.path().exists() => continue,
            // Without locks, `abandoned` goes by age.
            Ok(()) | Err(TryLockError::Error(_)) => return Ok(temporary),
        }
    }
}

/// Removes temporary files that killed runs left in a folder, if `is_wanted` is true for the bytes of their
/// final names. Returns the removed files.
///
/// Files that another process is writing stay, so two simultaneous runs of the same frame both end with whole
/// frames.
pub fn remove_abandoned(folder: &Path, is_wanted: impl Fn(&[u8]) -> bool) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    entries
        .filter_map(Result::ok)
        .filter(|entry| final_name(entry.file_name().as_encoded_bytes()).is_some_and(&is_wanted))
        .map(|entry| entry.path())
        .filter(|temporary| abandoned(temporary).is_some_and(|_locked| fs::remove_file(temporary).is_ok()))
        .collect()
}

/// Final name of a temporary file, in bytes.
pub fn final_name(temporary: &[u8]) -> Option<&[u8]> {
    let unique = temporary.strip_prefix(b".")?.strip_suffix(SUFFIX.as_bytes())?;
    let (name, letters) = unique.split_at_checked(unique.len().checked_sub(RANDOM_LETTERS)?)?;
    letters.iter().all(u8::is_ascii_alphanumeric).then(|| name.strip_suffix(b"."))?
}

/// Locks a temporary file that no process uses: its lock was free, or without locks it is old. While the
/// result is kept, its creator sees the file locked.
fn abandoned(temporary: &Path) -> Option<fs::File> {
    // A pipe of such a name would block.
    fs::symlink_metadata(temporary).ok().filter(fs::Metadata::is_file)?;
    let file = fs::File::open(temporary).ok()?;
    let is_old =
        || -> Option<bool> { Some(file.metadata().ok()?.modified().ok()?.elapsed().ok()? > ABANDONED_AFTER) };
    let is_free = match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => is_old().unwrap_or(false),
    };
    is_free.then_some(file)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const OURS: &str = ".picture.0001.exr.Ab3dE6.sunfleck-part";

    fn remove(folder: &Path) -> Vec<PathBuf> {
        remove_abandoned(folder, |name| name == b"picture.0001.exr")
    }

    #[test]
    fn what_another_process_writes_is_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let at_work = folder.path().join(OURS);
        let file = fs::File::create(&at_work).unwrap();
        file.lock().unwrap();
        assert!(remove(folder.path()).is_empty());
        drop(file);
        assert_eq!(remove(folder.path()), [at_work]);
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
        let others = [
            ".picture.0001.exr.swp",
            ".picture.0001.exr.more.Ab3dE6.sunfleck-part",
            ".picture.0001.exr.sunfleck-part",
            ".picture.0002.exr.Ab3dE6.sunfleck-part",
            "picture.0001.exr",
        ];
        for name in others.iter().chain([&OURS]) {
            fs::write(folder.path().join(name), b"half").unwrap();
        }
        assert_eq!(remove(folder.path()), [folder.path().join(OURS)]);
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
    }

    #[test]
    fn names_of_temporary_files_tell_the_final_ones() {
        let folder = tempfile::tempdir().unwrap();
        let made = temporary(folder.path(), OsStr::new("a.b")).unwrap();
        assert_eq!(final_name(made.path().file_name().unwrap().as_encoded_bytes()), Some(&b"a.b"[..]));
        assert_eq!(final_name(OURS.as_bytes()), Some(&b"picture.0001.exr"[..]));
        assert_eq!(final_name(b".Ab3dE6.sunfleck-part"), None);
    }
}
