//! Where this checkout and its program lie. Cargo tells tests when they run, and so does `tools/test places`:
//! what was built in one checkout is run in others. Else it is where they were built.
#![allow(dead_code, reason = "not every crate of tests asks for both")]

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A file or folder of the checkout.
pub(crate) fn file(name: impl AsRef<Path>) -> PathBuf {
    let root = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    PathBuf::from(root).join(name)
}

/// The program, for tests from outside.
pub(crate) fn program() -> PathBuf {
    const NAME: &str = "CARGO_BIN_EXE_sunfleck";
    let built = option_env!("CARGO_BIN_EXE_sunfleck").map(OsString::from);
    std::env::var_os(NAME).or(built).expect("a test from outside").into()
}
