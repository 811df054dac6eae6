//! Pixels of files that cannot be shown. In go files, out comes one warning a run. Invariant: all other
//! pixels are shown.

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
    /// Files without a pixel in their display windows.
    outside: BTreeSet<PathBuf>,
    /// Files with NaN or infinite pixels.
    not_finite: BTreeSet<PathBuf>,
}

impl Unshown {
    /// Checks a file: `has_pixels` is whether its display window has any. Any thread may call it.
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

    /// Reports these files.
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
