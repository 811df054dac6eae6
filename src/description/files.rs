//! Paths in, bytes out, every byte hashed. Invariant: the content hash depends on the files'
//! bytes and the order of reading, never on where they lie.

use super::LoadError;
use sha2::{Digest, Sha256};
use std::path::Path;

/// Reads files and remembers what was in them.
#[derive(Default)]
pub struct Files {
    hash: Sha256,
}

impl Files {
    /// The bytes of a file; `referrer` says who asked for it ("scene.ron: meshes.leaf").
    ///
    /// # Errors
    /// [`LoadError::Io`] if it cannot be read.
    pub fn read(&mut self, path: &Path, referrer: Option<&str>) -> Result<Vec<u8>, LoadError> {
        let bytes = std::fs::read(path).map_err(|source| LoadError::Io {
            path: path.to_owned(),
            referrer: referrer.map(str::to_owned),
            source,
        })?;
        self.hash.update((bytes.len() as u64).to_le_bytes());
        self.hash.update(&bytes);
        Ok(bytes)
    }

    /// The bytes of a file that the picture can do without; `None` if there is none, or it cannot be read.
    pub(super) fn read_if_there(&mut self, path: &Path) -> Option<Vec<u8>> {
        // Anything but a plain file, such as a device, may never end.
        if path.is_file() { self.read(path, None).ok() } else { None }
    }

    /// SHA-256 of everything read so far, in hexadecimal.
    pub fn content_hash(&self) -> String {
        self.hash.clone().finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }
}
