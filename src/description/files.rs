//! Reader of input files. In go paths, out come bytes, all of them hashed. Invariant: the content hash
//! depends on the files' bytes and the order of reading, and not on their paths.

use super::LoadError;
use crate::math::MAPPED_BYTES;
use sha2::{Digest, Sha256};
use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

/// Size from which a file has room of [`MAPPED_BYTES`], of which its bytes alone take memory.
const LARGE: usize = 1 << 20;

/// Reads files and hashes their contents.
#[derive(Default)]
pub struct Files {
    hash: Sha256,
    read: Vec<PathBuf>,
}

/// Opens a regular file, limited to its present length. Pipes and devices are not opened, as they may block
/// or never end.
///
/// # Errors
/// If there is no such file, or it is not regular.
pub fn open_regular(path: &Path) -> io::Result<io::Take<File>> {
    let metadata = fs::metadata(path)?;
    if !metadata.is_file() && !metadata.is_dir() {
        return Err(io::Error::new(ErrorKind::InvalidInput, "it is a pipe or a device, not a file"));
    }
    // Bytes appended while it is read do not count.
    Ok(File::open(path)?.take(metadata.len()))
}

/// Reads a regular file.
///
/// # Errors
/// If there is no such file, it is not regular, or its bytes do not fit into memory.
pub fn read_regular(path: &Path) -> io::Result<Vec<u8>> {
    let mut file = open_regular(path)?;
    let mut bytes = Vec::new();
    let out_of_memory =
        |_| io::Error::new(ErrorKind::OutOfMemory, "it is larger than the memory that can be had");
    let room = |length: usize| if length < LARGE { length } else { length.max(MAPPED_BYTES) };
    // Under a limit of memory there may be no such room.
    if bytes.try_reserve_exact(room(file.limit() as usize)).is_err() {
        bytes.try_reserve_exact(file.limit() as usize).map_err(out_of_memory)?;
    }
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Path of a named file in a folder. If it does not exist, backslashes become slashes, as Windows programs
/// write them.
pub(super) fn beside(folder: &Path, name: &Path) -> PathBuf {
    let as_it_stands = folder.join(name);
    match name.to_str() {
        Some(name) if name.contains('\\') && !as_it_stands.exists() => folder.join(name.replace('\\', "/")),
        _ => as_it_stands,
    }
}

impl Files {
    /// Reads a file; `referrer` is the place that refers to it ("scene.ron: meshes.leaf").
    pub fn read(&mut self, path: &Path, referrer: Option<&str>) -> Result<Vec<u8>, LoadError> {
        let bytes = self.read_uncounted(path, referrer)?;
        self.count(&bytes);
        Ok(bytes)
    }

    /// Reads a text file; the hash ignores comments and blanks.
    pub(super) fn read_text(
        &mut self,
        path: &Path,
        meant: fn(&[u8]) -> Vec<u8>,
    ) -> Result<Vec<u8>, LoadError> {
        let bytes = self.read_uncounted(path, None)?;
        self.count(&meant(&bytes));
        Ok(bytes)
    }

    fn read_uncounted(&mut self, path: &Path, referrer: Option<&str>) -> Result<Vec<u8>, LoadError> {
        let bytes = read_regular(path).map_err(|source| LoadError::Io {
            path: path.to_owned(),
            referrer: referrer.map(str::to_owned),
            source,
        })?;
        self.read.push(path.to_owned());
        Ok(bytes)
    }

    /// Hashes bytes that are not from a file.
    pub(super) fn count(&mut self, bytes: &[u8]) {
        self.hash.update((bytes.len() as u64).to_le_bytes());
        self.hash.update(bytes);
    }

    /// Paths that were read, each once, in the order of reading.
    pub fn into_paths(mut self) -> Vec<PathBuf> {
        let mut seen = HashSet::new();
        self.read.retain(|path| seen.insert(path.clone()));
        self.read
    }

    /// Bytes of an optional file; `None` if it does not exist or cannot be read.
    pub(super) fn read_if_there(&mut self, path: &Path) -> Option<Vec<u8>> {
        // Other kinds, such as devices, may never end.
        if path.is_file() { self.read(path, None).ok() } else { None }
    }

    /// SHA-256 of everything read so far, in hexadecimal.
    pub fn content_hash(&self) -> String {
        self.hash.clone().finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
