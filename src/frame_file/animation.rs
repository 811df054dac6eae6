//! Pictures one after another to an animated PNG, which browsers play and other viewers show the first picture of. In go
//! pictures of one size and a rate, out comes one file. Invariant: only compressed pictures are kept.

use super::preview::png_size;
use super::{FrameFileError, Picture, atomic};
use crate::scene::{FrameRate, Size};
use png::{BitDepth, ColorType, Compression, Encoder, Writer};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// An animation that grows picture by picture.
pub struct Animation {
    path: PathBuf,
    size: Size,
    bytes: Kept,
    writer: Writer<Kept>,
}

/// Bytes in memory: the file appears when it is whole.
#[derive(Clone, Default)]
struct Kept(Arc<Mutex<Vec<u8>>>);

impl Write for Kept {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Animation {
    /// Begins an animation of so many pictures, at least one, that plays over and over.
    ///
    /// # Errors
    /// If PNG cannot hold it.
    pub fn new(path: &Path, size: Size, pictures: usize, rate: FrameRate) -> Result<Self, FrameFileError> {
        let failed = |reason: String| FrameFileError::Encode { path: path.to_owned(), reason };
        let (width, height) = png_size(size).map_err(failed)?;
        let count = u32::try_from(pictures).map_err(|_| failed(String::from("it has too many pictures")))?;
        let bytes = Kept::default();
        let mut encoder = Encoder::new(bytes.clone(), width, height);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_compression(Compression::High);
        let (seconds, parts) = delay(rate);
        let begun = encoder
            .set_animated(count, 0)
            .and_then(|()| encoder.set_frame_delay(seconds, parts))
            .and_then(|()| encoder.write_header());
        let writer = begun.map_err(|error| failed(error.to_string()))?;
        Ok(Self { path: path.to_owned(), size, bytes, writer })
    }

    /// Appends a picture.
    ///
    /// # Errors
    /// If it is of another size than the others, or one too many.
    pub fn push(&mut self, picture: &Picture) -> Result<(), FrameFileError> {
        let (Size { width, height }, other) = (self.size, picture.size);
        if other != self.size {
            return Err(
                self.failed(format!("a picture of {}x{} is no {width}x{height}", other.width, other.height))
            );
        }
        self.writer.write_image_data(&picture.bytes).map_err(|error| self.failed(error.to_string()))
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// If pictures are missing or the disk says no.
    pub fn finish(self) -> Result<(), FrameFileError> {
        let Self { path, bytes, writer, .. } = self;
        writer
            .finish()
            .map_err(|error| FrameFileError::Encode { path: path.clone(), reason: error.to_string() })?;
        let bytes = bytes.0.lock().unwrap_or_else(PoisonError::into_inner);
        atomic::write(&path, &bytes)
    }

    fn failed(&self, reason: String) -> FrameFileError {
        FrameFileError::Encode { path: self.path.clone(), reason }
    }
}

/// How long a picture stands: a fraction of 16 bits a side, the nearest in milliseconds if it must be.
fn delay(rate: FrameRate) -> (u16, u16) {
    match (u16::try_from(rate.denominator), u16::try_from(rate.numerator)) {
        (Ok(seconds), Ok(parts)) => (seconds, parts),
        _ => ((1000.0 * rate.seconds(1.0)).round().clamp(1.0, f64::from(u16::MAX)) as u16, 1000),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_back_in_order_with_their_times() {
        let size = Size { width: 5, height: 3 };
        let pictures: Vec<Picture> = (0..4)
            .map(|number| Picture { size, bytes: (0..45).map(|byte| byte * 5 + number).collect() })
            .collect();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.apng");
        let rate = FrameRate { numerator: 24000, denominator: 1001 };
        let mut animation = Animation::new(&path, size, pictures.len(), rate).unwrap();
        for picture in &pictures {
            animation.push(picture).unwrap();
        }
        assert!(!path.exists(), "it appears when it is whole");
        assert!(animation.push(&Picture::black(Size { width: 3, height: 5 })).is_err());
        animation.finish().unwrap();

        let file = std::io::BufReader::new(std::fs::File::open(&path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
        for picture in &pictures {
            let mut bytes = vec![0; 45];
            reader.next_frame(&mut bytes).unwrap();
            assert_eq!(bytes, picture.bytes);
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), (1001, 24000));
        }
    }

    #[test]
    fn every_rate_has_a_delay() {
        assert_eq!(delay(FrameRate { numerator: 24, denominator: 1 }), (1, 24));
        assert_eq!(delay(FrameRate { numerator: 24_000_000, denominator: 1_000_000 }), (42, 1000));
        assert_eq!(delay(FrameRate { numerator: u32::MAX, denominator: 1 }), (1, 1000));
    }
}
