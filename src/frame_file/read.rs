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

/// Reads a flat, single-part EXR file, ours or anybody's.
///
/// # Errors
/// If it cannot be read, is damaged, is of another kind, or claims more pixels than its size can hold.
pub fn read(path: &Path) -> Result<FrameFile, FrameFileError> {
    let bytes =
        read_regular(path).map_err(|source| FrameFileError::Read { path: path.to_owned(), source })?;
    let invalid =
        |error: exr::error::Error| FrameFileError::Invalid { path: path.to_owned(), reason: reason(&error) };
    let meta = MetaData::read_from_buffered(bytes.as_slice(), false).map_err(invalid)?;
    let [header] = meta.headers.as_slice() else {
        return Err(FrameFileError::Unsupported {
            path: path.to_owned(),
            what: String::from("a file of several parts"),
        });
    };
    check(path, header, bytes.len() as u64)?;
    let (full, window) = windows(header).ok_or_else(|| FrameFileError::Unsupported {
        path: path.to_owned(),
        what: String::from("a data window that begins outside of the display window"),
    })?;
    let attributes = Attributes::from_header(header);
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(&bytes))
        .map_err(invalid)?;
    let channels = image.layer_data.channel_data;
    let pixel_hash = pixel_hash(&channels);
    let channels = channels.list.into_iter().map(channel).collect();
    Ok(FrameFile { frame: Frame { full, window, channels }, attributes, pixel_hash })
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
fn check(path: &Path, header: &Header, file_bytes: u64) -> Result<(), FrameFileError> {
    let unsupported =
        |what: &str| Err(FrameFileError::Unsupported { path: path.to_owned(), what: what.to_owned() });
    if header.deep {
        return unsupported("deep data");
    }
    if header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
        return unsupported("a subsampled channel");
    }
    let Vec2(width, height) = header.layer_size;
    // Decoded, integers and halves take as much as floats: four bytes.
    let bytes = (width as u64)
        .saturating_mul(height as u64)
        .saturating_mul(4)
        .saturating_mul(header.channels.list.len() as u64);
    let limit = file_bytes.saturating_mul(LARGEST_COMPRESSION).min(LARGEST_PICTURE);
    if bytes > limit {
        return Err(FrameFileError::TooLarge { path: path.to_owned(), bytes, limit });
    }
    Ok(())
}

/// Size of the full picture and the part of it that the file holds.
fn windows(header: &Header) -> Option<(Size, Window)> {
    let display = header.shared_attributes.display_window;
    let data = header.own_attributes.layer_position;
    let offset = |data: i32, display: i32| usize::try_from(i64::from(data) - i64::from(display)).ok();
    let window = Window {
        x: offset(data.0, display.position.0)?,
        y: offset(data.1, display.position.1)?,
        width: header.layer_size.0,
        height: header.layer_size.1,
    };
    Some((Size { width: display.size.0, height: display.size.1 }, window))
}

fn channel(channel: AnyChannel<FlatSamples>) -> Channel {
    let (precision, pixels) = match channel.sample_data {
        FlatSamples::F16(values) => (Precision::Half, values.into_iter().map(f32::from).collect()),
        FlatSamples::F32(values) => (Precision::Float, values),
        FlatSamples::U32(values) => {
            (Precision::Float, values.into_iter().map(|value| value as f32).collect())
        }
    };
    Channel { name: String::from_utf8_lossy(channel.name.bytes()).into_owned(), precision, pixels }
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
