//! Hash of values as text. In go formatted values, out comes their SHA-256. Invariant: it is that of all the
//! text, which never exists as a whole: tables take megabytes.

use sha2::{Digest, Sha256};
use std::fmt::{Arguments, Result, Write};

/// Hasher of text.
pub struct Hashed(pub Sha256);

impl Hashed {
    /// Adds text, see `format_args!`.
    pub fn add(&mut self, text: Arguments) {
        let written = self.write_fmt(text);
        debug_assert!(written.is_ok());
    }
}

impl Write for Hashed {
    fn write_str(&mut self, text: &str) -> Result {
        self.0.update(text);
        Ok(())
    }
}
