//! Baking of a scene's falls: who hears of progress, and where bakes are kept. Invariant: neither changes a
//! bake, and a kept one is checked before it is used.

use std::fmt;
use std::io::Read;

/// Hears how many leaves of a fall are done, of how many. From any thread.
type Ear<'a> = &'a (dyn Fn(u32, u32) + Sync);

/// Who hears of bakes, and where they are kept.
#[derive(Clone, Copy)]
pub struct Baking<'a> {
    /// Hears of progress.
    pub tell: Ear<'a>,
    /// Bytes kept under a name, if they are still there.
    pub recall: &'a dyn Fn(&str) -> Option<Box<dyn Read>>,
    /// Keeps bytes, in parts, under a name, or does not.
    pub keep: &'a dyn Fn(&str, &[&[u8]]),
}

impl Baking<'_> {
    /// Tells nobody and keeps nothing.
    pub const ALONE: Self = Self { tell: &|_, _| {}, recall: &|_| None, keep: &|_, _| {} };
}

impl fmt::Debug for Baking<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Baking")
    }
}
