//! An EXR file to a frame and its attributes. Invariant: a file can make us allocate no more than
//! a fixed multiple of its own size.

use super::pixel_hash::pixel_hash;
use super::provenance::PIXEL_HASH_NAME;
use super::{Attributes, FrameFileError, Provenance, file_hash};
use crate::description::read_regular;
use crate::film::{Channel, Frame, Precision};
use crate::scene::{Size, Window};
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::image::{AnyChannel, FlatSamples};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use std::io::Cursor;
use std::path::Path;

/// Pixels' bytes per byte of file. Deflate reaches 1032 at most, so that no honest file is refused.
const LARGEST_COMPRESSION: u64 = 4096;
/// Bytes of pixels that are read at all: an 8K picture with thirty float channels.
const LARGEST_PICTURE: u64 = 4 << 30;

/// What a file holds.
#[derive(Clone, Debug)]
pub struct FrameFile {
    /// The pixels. Integer channels become float ones, exact up to 2^24.
    pub frame: Frame,
    /// The header.
    pub attributes: Attributes,
    /// The pixels' hash, computed anew.
    pub pixel_hash: String,
}

impl FrameFile {
    /// True if the pixels are those that the header was written for.
    pub fn is_intact(&self) -> bool {
        self.attributes.get(PIXEL_HASH_NAME) == Some(&self.pixel_hash)
    }
}

/// Reads a flat EXR file, ours or anybody's. Of several parts the first one's data window counts, and
/// those with the same one are read, their channels called `part.channel`. Pixels outside of the display
/// window are left out.
///
/// # Errors
/// If it cannot be read, is damaged, is of another kind, or claims more pixels than its size can hold.
pub fn read(path: &Path) -> Result<FrameFile, FrameFileError> {
    let bytes =
        read_regular(path).map_err(|source| FrameFileError::Read { path: path.to_owned(), source })?;
    let invalid =
        |error: exr::error::Error| FrameFileError::Invalid { path: path.to_owned(), reason: reason(&error) };
    let meta = MetaData::read_from_buffered(bytes.as_slice(), false).map_err(invalid)?;
    check(path, &meta.headers, bytes.len() as u64)?;
    let unsupported =
        |what: &str| FrameFileError::Unsupported { path: path.to_owned(), what: what.to_owned() };
    let header = meta.headers.first().ok_or_else(|| unsupported("a file without parts"))?;
    let seen = Seen::of(header)
        .ok_or_else(|| unsupported("a picture whose pixels lie outside of its display window"))?;
    let attributes = Attributes::from_header(header);
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(&bytes))
        .map_err(invalid)?;
    let pixel_hash = pixel_hash(&image.layer_data[0].channel_data);
    let mut channels = Vec::new();
    for (index, (layer, header)) in image.layer_data.into_iter().zip(&meta.headers).enumerate() {
        if Seen::of(header) != Some(seen) {
            continue;
        }
        let part = layer.attributes.layer_name.filter(|_| index > 0);
        let part =
            part.map_or_else(String::new, |name| format!("{}.", String::from_utf8_lossy(name.bytes())));
        let named = |channel: Channel| Channel { name: format!("{part}{}", channel.name), ..channel };
        channels.extend(layer.channel_data.list.into_iter().map(|stored| named(seen.channel(stored))));
    }
    Ok(FrameFile { frame: Frame { full: seen.full, window: seen.window, channels }, attributes, pixel_hash })
}

/// True if `path` holds, whole and undamaged, what rendering with this provenance would write there.
pub fn is_valid(path: &Path, expected: &Provenance) -> bool {
    // The whole file's hash holds, so nothing need be decoded.
    let Ok(bytes) = read_regular(path) else { return false };
    let Ok(meta) = MetaData::read_from_buffered(bytes.as_slice(), false) else { return false };
    let fits = |header: &Header| expected.matches(&Attributes::from_header(header));
    meta.headers.first().is_some_and(fits) && file_hash::is_whole(&bytes)
}

/// Refuses what the decoder cannot do and what would take too much memory to try.
fn check(path: &Path, headers: &[Header], file_bytes: u64) -> Result<(), FrameFileError> {
    let unsupported = |what: String| Err(FrameFileError::Unsupported { path: path.to_owned(), what });
    let mut bytes = 0_u64;
    for header in headers {
        if header.deep {
            return unsupported(String::from("deep data"));
        }
        if let Some(channel) = header.channels.list.iter().find(|channel| channel.sampling != Vec2(1, 1)) {
            let name = String::from_utf8_lossy(channel.name.bytes());
            return unsupported(format!("the channel {name}, which has fewer samples than the picture,"));
        }
        let Vec2(width, height) = header.layer_size;
        // Decoded, integers and halves take as much as floats: four bytes.
        let of_part = (width as u64)
            .saturating_mul(height as u64)
            .saturating_mul(4)
            .saturating_mul(header.channels.list.len() as u64);
        bytes = bytes.saturating_add(of_part);
    }
    let limit = file_bytes.saturating_mul(LARGEST_COMPRESSION).min(LARGEST_PICTURE);
    if bytes > limit {
        return Err(FrameFileError::TooLarge { path: path.to_owned(), bytes, limit });
    }
    Ok(())
}

/// What of a part is seen.
#[derive(Clone, Copy, PartialEq)]
struct Seen {
    /// The display window's size.
    full: Size,
    /// The data window within the display window, from whose corner it is counted.
    window: Window,
    /// The data window's own columns, and how many of its columns and rows lie before the window.
    columns: usize,
    before: [usize; 2],
}

impl Seen {
    /// `None` if no pixel lies in the display window.
    fn of(header: &Header) -> Option<Self> {
        let display = header.shared_attributes.display_window;
        let (position, size) = (header.own_attributes.layer_position, header.layer_size);
        // Along one side: how much lies before the display window, where the seen part
        // begins, and how long it is.
        let side = |position: i32, from: i32, length: usize, full: usize| {
            let start = i64::from(position) - i64::from(from);
            let before = usize::try_from(-start).unwrap_or(0);
            let begin = usize::try_from(start).unwrap_or(0);
            let seen = length.checked_sub(before)?.min(full.checked_sub(begin)?);
            (seen > 0).then_some((before, begin, seen))
        };
        let across = side(position.0, display.position.0, size.0, display.size.0)?;
        let down = side(position.1, display.position.1, size.1, display.size.1)?;
        Some(Self {
            full: Size { width: display.size.0, height: display.size.1 },
            window: Window { x: across.1, y: down.1, width: across.2, height: down.2 },
            columns: size.0,
            before: [across.0, down.0],
        })
    }

    fn channel(&self, channel: AnyChannel<FlatSamples>) -> Channel {
        let name = String::from_utf8_lossy(channel.name.bytes()).into_owned();
        let (precision, pixels) = match channel.sample_data {
            FlatSamples::F16(values) => (Precision::Half, self.pixels(&values, |value| value.to_f32())),
            FlatSamples::F32(values) => (Precision::Float, self.pixels(&values, |value| value)),
            FlatSamples::U32(values) => (Precision::Float, self.pixels(&values, |value| value as f32)),
        };
        Channel { name, precision, pixels }
    }

    fn pixels<T: Copy>(&self, values: &[T], float: impl Fn(T) -> f32) -> Vec<f32> {
        let [left, top] = self.before;
        let rows = values.chunks_exact(self.columns).skip(top).take(self.window.height);
        rows.flat_map(|row| &row[left..left + self.window.width]).map(|value| float(*value)).collect()
    }
}

/// The decoder's words, made plain where they are not.
fn reason(error: &exr::error::Error) -> String {
    match error {
        exr::error::Error::Invalid(message) if message == "reference to missing bytes" => {
            String::from("it ends too early")
        }
        exr::error::Error::Invalid(message) if message == "file identifier missing" => {
            String::from("it does not begin like one")
        }
        other => other.to_string(),
    }
}
