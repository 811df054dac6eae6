//! Warnings about files' colours that are not honoured. In go files, out come warnings. Invariant: each kind
//! is reported once a run.

use super::tell;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};
use sunfleck::diagnostic::{Diagnostic, Loss, Place, shown};
use sunfleck::frame_file::FrameFile;

/// Kinds reported so far.
#[derive(Default)]
pub(super) struct ColorDoubts {
    told: Mutex<BTreeSet<Loss>>,
    conversion: OnceLock<()>,
}

impl ColorDoubts {
    /// Reports a file's doubtful colours, unless the kind was reported.
    pub(super) fn tell(&self, path: &Path, file: &FrameFile) {
        if let Some((loss, found)) = &file.colors.doubt {
            self.tell_of(*loss, path, found.clone());
        }
    }

    /// Reports a shown file's doubtful colours, and the channels shown in place of a picture; returns whether
    /// it has a picture.
    pub(super) fn tell_shown(&self, path: &Path, file: &FrameFile) -> bool {
        self.tell(path, file);
        let instead = file.shown_instead();
        let has_picture = instead.is_none();
        instead.into_iter().for_each(|found| self.tell_of(Loss::NoPicture, path, found));
        has_picture
    }

    fn tell_of(&self, loss: Loss, path: &Path, found: String) {
        if self.told.lock().unwrap_or_else(PoisonError::into_inner).insert(loss) {
            tell(&Diagnostic::warning(loss, Place::File(path.to_owned()), found).to_string());
        }
    }

    /// Converts two files to a common colour space, and reports it.
    pub(super) fn in_one_space(&self, paths: [&Path; 2], files: &mut [FrameFile; 2]) {
        for (path, file) in paths.into_iter().zip(&*files) {
            self.tell(path, file);
        }
        if files[0].colors.space.is_same(&files[1].colors.space) {
            return;
        }
        let [one, other] =
            [0, 1].map(|index| format!("{} of {}", files[index].colors.name, shown(paths[index])));
        self.conversion.get_or_init(|| {
            tell(&format!(
                "note: the pictures are in different colour spaces, {one} and {other}: R, G and B are compared in \
                 linear Rec. 709, other channels as they are stored"
            ));
        });
        files.iter_mut().for_each(FrameFile::convert_colors);
    }
}
