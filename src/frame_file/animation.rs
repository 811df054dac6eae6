//! Animations that browsers play in a loop. In go pictures of one size and a rate, out comes an animated PNG
//! or WebP. Invariant: only compressed pictures are kept, and the file is whole or absent.

use super::animated_png::AnimatedPng;
use super::animated_webp::AnimatedWebP;
use super::{FrameFileError, Picture, atomic};
use crate::scene::{FrameRate, Size};
use std::path::{Path, PathBuf};

/// Animation under construction.
pub struct Animation {
    path: PathBuf,
    size: Size,
    bytes: Bytes,
}

/// Contents of the file.
enum Bytes {
    Png(AnimatedPng),
    WebP(AnimatedWebP),
}

/// Whether a path has this extension.
fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending))
}

impl Animation {
    /// Whether a file's name is that of an animation: `.apng` or `.webp`.
    pub fn is_named(path: &Path) -> bool {
        ends_in(path, "apng") || ends_in(path, "webp")
    }

    /// Starts an animation of a number of pictures, at least one: a WebP for that extension, else a PNG.
    ///
    /// # Errors
    /// If the format cannot hold it.
    pub fn new(path: &Path, size: Size, pictures: usize, rate: FrameRate) -> Result<Self, FrameFileError> {
        let bytes = if ends_in(path, "webp") {
            AnimatedWebP::new(size, rate).map(Bytes::WebP)
        } else {
            AnimatedPng::new(size, pictures, rate).map(Bytes::Png)
        };
        let bytes = bytes.map_err(|reason| FrameFileError::Animation { path: path.to_owned(), reason })?;
        Ok(Self { path: path.to_owned(), size, bytes })
    }

    /// Appends a picture.
    ///
    /// # Errors
    /// If its size differs from the others', or there are too many.
    pub fn push(&mut self, picture: &Picture) -> Result<(), FrameFileError> {
        let (Size { width, height }, other) = (self.size, picture.size);
        let pushed = if other != self.size {
            Err(format!("a picture of {}x{} is no {width}x{height}", other.width, other.height))
        } else {
            match &mut self.bytes {
                Bytes::Png(png) => png.push(picture),
                Bytes::WebP(webp) => webp.push(picture),
            }
        };
        pushed.map_err(|reason| FrameFileError::Animation { path: self.path.clone(), reason })
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// If pictures are missing or the file cannot be written.
    pub fn finish(self) -> Result<(), FrameFileError> {
        let bytes = match self.bytes {
            Bytes::Png(png) => png.finish(),
            Bytes::WebP(webp) => Ok(webp.finish()),
        };
        let bytes = bytes.map_err(|reason| FrameFileError::Animation { path: self.path.clone(), reason })?;
        atomic::write(&self.path, &bytes)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn a_file_appears_when_it_is_whole_and_is_what_its_name_says() {
        let folder = tempfile::tempdir().unwrap();
        let size = Size { width: 5, height: 3 };
        let rate = FrameRate { numerator: 24, denominator: 1 };
        for (name, begins) in [("a.apng", &b"\x89PNG"[..]), ("a.WebP", b"RIFF")] {
            let path = folder.path().join(name);
            assert!(Animation::is_named(&path));
            let mut animation = Animation::new(&path, size, 1, rate).unwrap();
            assert!(animation.push(&Picture::black(Size { width: 3, height: 5 })).is_err());
            animation.push(&Picture::black(size)).unwrap();
            assert!(!path.exists());
            animation.finish().unwrap();
            assert!(std::fs::read(&path).unwrap().starts_with(begins));
        }
        assert!(!Animation::is_named(Path::new("webp")) && !Animation::is_named(Path::new("a.png")));
    }
}
