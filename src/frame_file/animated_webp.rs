//! Lossless animated WebP. In go pictures of one size and a rate, out come the file's bytes. Invariant: a
//! picture begins within half a millisecond of its time, however many there are (up to 1000 a second).
//!
//! Each picture is a still WebP from the crate `image`, without its container. Chunks and fields are those of
//! the WebP Container Specification, <https://developers.google.com/speed/webp/docs/riff_container> (RFC
//! 9649, section 2); numbers are little-endian.

use super::Picture;
use crate::scene::{FrameRate, Size};
use image::ExtendedColorType;
use image::codecs::webp::WebPEncoder;

/// Maximum side in pixels: a lossless picture has 14 bits for it (RFC 9649, section 3.4).
const LONGEST_SIDE: usize = 1 << 14;

/// Maximum size of a file in bytes: RIFF's 32-bit size, which excludes 8 bytes.
const LARGEST_FILE: usize = u32::MAX as usize - 8;

/// Length of a still file's header: `RIFF`, the size of the rest, `WEBP`.
const FILE_HEADER: usize = 12;

/// `VP8X` flags: the file holds an animation, and no other feature.
const HAS_ANIMATION: u8 = 0b10;

/// `ANMF` flags: the picture replaces the last one, and stays.
const REPLACES: u8 = 0b10;

/// Animated WebP under construction; it plays in an endless loop.
pub(super) struct AnimatedWebP {
    size: Size,
    rate: FrameRate,
    pictures: u64,
    /// File so far, without its size.
    bytes: Vec<u8>,
}

impl AnimatedWebP {
    /// Starts a file.
    pub(super) fn new(size: Size, rate: FrameRate) -> Result<Self, String> {
        let Size { width, height } = size;
        if !(1..=LONGEST_SIDE).contains(&width) || !(1..=LONGEST_SIDE).contains(&height) {
            return Err(format!(
                "WebP has no pictures of {width}x{height}, but of up to {LONGEST_SIDE} pixels a side"
            ));
        }
        let mut bytes = Vec::from(*b"RIFF\0\0\0\0WEBP");
        let canvas = [u24(width as u64 - 1), u24(height as u64 - 1)].concat();
        put_chunk(&mut bytes, b"VP8X", &[&[HAS_ANIMATION, 0, 0, 0], &canvas]);
        // Background (black) and number of loops: 0 is endless.
        put_chunk(&mut bytes, b"ANIM", &[&[0, 0, 0, 255], &[0, 0]]);
        Ok(Self { size, rate, pictures: 0, bytes })
    }

    /// Appends a picture of the right size.
    pub(super) fn push(&mut self, picture: &Picture) -> Result<(), String> {
        let Size { width, height } = self.size;
        let mut still = Vec::new();
        WebPEncoder::new_lossless(&mut still)
            .encode(&picture.bytes, width as u32, height as u32, ExtendedColorType::Rgb8)
            .map_err(|error| error.to_string())?;
        let pixels = still.get(FILE_HEADER..).unwrap_or_default();
        let lasts_ms = begin_ms(self.rate, self.pictures + 1) - begin_ms(self.rate, self.pictures);
        let place = [u24(0), u24(0), u24(width as u64 - 1), u24(height as u64 - 1), u24(lasts_ms)].concat();
        put_chunk(&mut self.bytes, b"ANMF", &[&place, &[REPLACES], pixels]);
        self.pictures += 1;
        if self.bytes.len() > LARGEST_FILE {
            return Err(format!("{} pictures are more than a WebP of 4 GB can hold", self.pictures));
        }
        Ok(())
    }

    /// Returns the file.
    pub(super) fn finish(mut self) -> Vec<u8> {
        let counted = (self.bytes.len() - 8) as u32;
        self.bytes[4..8].copy_from_slice(&counted.to_le_bytes());
        self.bytes
    }
}

/// Start of a picture in milliseconds, rounded from the start of the animation, so that errors do not add up.
fn begin_ms(rate: FrameRate, picture: u64) -> u64 {
    let (parts, seconds) = (u128::from(rate.numerator), u128::from(rate.denominator));
    let begin = (2000 * u128::from(picture) * seconds + parts) / (2 * parts);
    u64::try_from(begin).unwrap_or(u64::MAX)
}

/// Number in three bytes, clamped to the largest.
fn u24(value: u64) -> [u8; 3] {
    let [low, middle, high, ..] = value.min((1 << 24) - 1).to_le_bytes();
    [low, middle, high]
}

/// Appends a chunk: four letters, the size of its contents, the contents, and padding to an even size.
fn put_chunk(bytes: &mut Vec<u8>, name: &[u8; 4], parts: &[&[u8]]) {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    bytes.extend_from_slice(name);
    bytes.extend_from_slice(&(length as u32).to_le_bytes());
    for part in parts {
        bytes.extend_from_slice(part);
    }
    bytes.resize(bytes.len() + length % 2, 0);
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use image::AnimationDecoder;
    use image::codecs::webp::WebPDecoder;
    use std::io::Cursor;

    const FILM: FrameRate = FrameRate { numerator: 24000, denominator: 1001 };

    #[test]
    fn pictures_come_back_in_order_with_their_times() {
        // An odd number of pixels a side, and pixel data of all kinds of lengths.
        let size = Size { width: 5, height: 3 };
        let pictures: Vec<Picture> = (0..50)
            .map(|number| Picture {
                size,
                bytes: (0..45_u32).map(|byte| (byte * byte * number / 7) as u8).collect(),
            })
            .collect();
        let mut animation = AnimatedWebP::new(size, FILM).unwrap();
        for picture in &pictures {
            animation.push(picture).unwrap();
        }
        let file = animation.finish();
        assert_eq!(u32::from_le_bytes(file[4..8].try_into().unwrap()) as usize, file.len() - 8);
        let decoder = WebPDecoder::new(Cursor::new(&file)).unwrap();
        assert!(decoder.has_animation());
        let frames = decoder.into_frames().collect_frames().unwrap();
        assert_eq!(frames.len(), pictures.len());
        let mut begins_ms = 0;
        for (number, (frame, picture)) in frames.iter().zip(&pictures).enumerate() {
            // Half a millisecond, in 24ths of one.
            assert!((24 * begins_ms as i64 - 1001 * number as i64).abs() <= 12);
            let (numerator, denominator) = frame.delay().numer_denom_ms();
            begins_ms += numerator / denominator;
            let pixels = frame.buffer();
            assert!(pixels.pixels().all(|pixel| pixel.0[3] == 255));
            let colors: Vec<u8> =
                pixels.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect();
            assert_eq!(colors, picture.bytes, "picture {number}");
        }
    }

    #[test]
    fn times_do_not_drift() {
        // A day of film: 24 / 1.001 pictures a second.
        assert_eq!(begin_ms(FILM, 24 * 3600 * 24), 86_486_400);
        assert_eq!(begin_ms(FrameRate { numerator: 3, denominator: 1 }, 2), 667);
        // Nothing overflows, whatever the rate; what lasts too long for the format stands as long as it can.
        let slow = FrameRate { numerator: 1, denominator: u32::MAX };
        assert_eq!(begin_ms(slow, u64::MAX), u64::MAX);
        assert_eq!(u24(begin_ms(slow, 1)), [255; 3]);
    }

    #[test]
    fn a_picture_too_large_is_refused() {
        assert!(AnimatedWebP::new(Size { width: LONGEST_SIDE, height: 1 }, FILM).is_ok());
        assert!(AnimatedWebP::new(Size { width: LONGEST_SIDE + 1, height: 1 }, FILM).is_err());
    }
}
