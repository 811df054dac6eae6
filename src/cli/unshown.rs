//! Pixels of files that no picture can show, said once a run. In go files, out come warnings. Invariant: what
//! can be shown of a file is shown.

use super::tell;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use sunfleck::diagnostic::shown;
use sunfleck::film::Frame;

/// Files with such pixels.
#[derive(Default)]
pub(super) struct Unshown(Mutex<Files>);

#[derive(Default)]
struct Files {
    /// Without a pixel in their display windows.
    outside: BTreeSet<PathBuf>,
    /// With pixels that are no numbers, or without end.
    not_finite: BTreeSet<PathBuf>,
}

impl Unshown {
    /// Looks at a file: whether it `has_pixels`, and what is shown. May be called from any thread.
    pub(super) fn count(&self, path: &Path, has_pixels: bool, shown: &Frame) {
        let is_finite =
            shown.channels.iter().all(|channel| channel.pixels.iter().all(|value| value.is_finite()));
        if has_pixels && is_finite {
            return;
        }
        let files = &mut *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let kind = if has_pixels { &mut files.not_finite } else { &mut files.outside };
        kind.insert(path.to_owned());
    }

    /// Says which files there were.
    pub(super) fn tell(&self) {
        let Files { outside, not_finite } = &*self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for (files, found, remedy) in [
            (
                outside,
                "all pixels lie outside the display window: the picture is black",
                "set the display window right where the file was made",
            ),
            (
                not_finite,
                "pixels are not finite: NaN is shown black, infinity white",
                "sunfleck-tools validate says where; render these frames again",
            ),
        ] {
            let Some(first) = files.first() else { continue };
            let more = match files.len() {
                1 => String::new(),
                count => format!(" (and {} more)", count - 1),
            };
            tell(&format!("{}: warning: {found}{more}\n  remedy: {remedy}", shown(first)));
        }
    }
}
