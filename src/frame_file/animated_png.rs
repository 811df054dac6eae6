//! Animated PNG, of which viewers without animation show the first picture. In go pictures of one size and a
//! rate, out come the file's bytes. Invariant: only compressed pictures are kept.

use super::Picture;
use super::preview::png_size;
use crate::scene::{FrameRate, Size};
use png::{BitDepth, ColorType, Compression, Encoder, EncodingError, Writer};
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// Animated PNG under construction.
pub(super) struct AnimatedPng {
    bytes: Kept,
    writer: Writer<Kept>,
}

/// Bytes in memory, as the file is written when it is complete.
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

impl AnimatedPng {
    /// Starts a file for a number of pictures, at least one.
    pub(super) fn new(size: Size, pictures: usize, rate: FrameRate) -> Result<Self, String> {
        let (width, height) = png_size(size)?;
        let count = u32::try_from(pictures).map_err(|_| String::from("it has too many pictures"))?;
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
        Ok(Self { bytes, writer: begun.map_err(reason)? })
    }

    /// Appends a picture, up to the number of pictures.
    pub(super) fn push(&mut self, picture: &Picture) -> Result<(), String> {
        self.writer.write_image_data(&picture.bytes).map_err(reason)
    }

    /// Returns the file, unless pictures are missing.
    pub(super) fn finish(self) -> Result<Vec<u8>, String> {
        self.writer.finish().map_err(reason)?;
        Ok(std::mem::take(&mut *self.bytes.0.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

fn reason(error: EncodingError) -> String {
    error.to_string()
}

/// Duration of a picture: a fraction of 16-bit integers, if necessary the nearest in milliseconds.
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
        let rate = FrameRate { numerator: 24000, denominator: 1001 };
        let mut animation = AnimatedPng::new(size, pictures.len(), rate).unwrap();
        for picture in &pictures {
            animation.push(picture).unwrap();
        }
        let file = io::Cursor::new(animation.finish().unwrap());
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
