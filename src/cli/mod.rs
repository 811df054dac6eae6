//! Arguments in, exit code out. Invariant: only this module prints.

pub mod progress;
