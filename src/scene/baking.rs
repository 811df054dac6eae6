//! Callbacks for baking a scene's falls: progress, and a cache. In go leaves, out come reports and stored
//! bytes. Invariant: neither changes a bake, and a stored one is validated before use.

use std::fmt;
use std::io::Read;

/// Callback for the number of finished leaves of a fall, and of all. Any thread may call it.
type Ear<'a> = &'a (dyn Fn(u32, u32) + Sync);

/// Callbacks for progress and the cache of bakes.
#[derive(Clone, Copy)]
pub struct Baking<'a> {
    /// Reports progress.
    pub tell: Ear<'a>,
    /// Reads the bytes stored under a name, if they exist.
    pub recall: &'a dyn Fn(&str) -> Option<Box<dyn Read>>,
    /// Stores bytes, in parts, under a name, if it can.
    pub keep: &'a dyn Fn(&str, &[&[u8]]),
}

impl Baking<'_> {
    /// No reports and no cache.
    pub const ALONE: Self = Self { tell: &|_, _| {}, recall: &|_| None, keep: &|_, _| {} };
}

impl fmt::Debug for Baking<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Baking")
    }
}
