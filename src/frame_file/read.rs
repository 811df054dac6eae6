//! An EXR file to a frame and its attributes. Invariant: a file can make us allocate no more than
//! a fixed multiple of its own size.

use super::pixel_hash::pixel_hash;
use super::provenance::PIXEL_HASH_NAME;
use super::region::{self, Region};
use super::{Attributes, FrameFileError, Provenance, file_hash};
use crate::description::exr::{self as exr_input, DeepFault, ImageColors, Unread};
use crate::description::read_regular;
use crate::film::Frame;
use crate::scene::Window;
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::image::{AnyChannels, FlatSamples};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header;
use std::borrow::Cow;
use std::io::Cursor;
use std::path::Path;

/// Pixels' bytes per byte of file. Deflate reaches 1032 at most, so that no honest file is refused.
const LARGEST_COMPRESSION: u64 = 4096;
/// Bytes of pixels that are read at all: an 8K picture with thirty float channels.
const LARGEST_PICTURE: u64 = 4 << 30;

/// Contents of a file.
#[derive(Clone, Debug)]
pub struct FrameFile {
    /// The pixels. Integer channels become float ones, exact up to 2^24.
    pub frame: Frame,
    /// The header.
    pub attributes: Attributes,
    /// The pixels' hash, computed anew.
    pub pixel_hash: String,
    /// Meaning of the picture's colours.
    pub colors: ImageColors,
}

impl FrameFile {
    /// True if the pixels are those that the header was written for.
    pub fn is_intact(&self) -> bool {
        self.attributes.get(PIXEL_HASH_NAME) == Some(&self.pixel_hash)
    }
}

/// Reads an EXR file, ours or anybody's, in its display window. Channels of several parts are called
/// `part.channel`, but for those of the picture's part. Parts of other windows are filled up with 0. Samples
/// that stand for several pixels are repeated, deep ones lie over those behind them.
///
/// # Errors
/// If it cannot be read, is damaged, is of another kind, or claims more pixels than its size can hold.
pub fn read(path: &Path) -> Result<FrameFile, FrameFileError> {
    let (bytes, meta) = header_of(path)?;
    let display = Region::displayed(&meta.headers[0]);
    read_in(path, &bytes, &meta, display)
}

/// Reads two files that are to be compared. Where their display windows are the same, pixels outside of these
/// count as well.
///
/// # Errors
/// As [`read`] has them.
pub fn read_both(paths: [&Path; 2]) -> Result<[FrameFile; 2], FrameFileError> {
    let [one, other] = paths.map(header_of);
    let [one, other] = [one?, other?];
    let regions = [&one, &other].map(|(_, meta)| Region::displayed(&meta.headers[0]));
    let is_same = regions[0] == regions[1];
    let headers = one.1.headers.iter().chain(&other.1.headers);
    let whole = headers.map(Region::stored).fold(regions[0], Region::joined);
    let read = |path: &Path, (bytes, meta): &(Vec<u8>, MetaData), region: Region| {
        read_in(path, bytes, meta, if is_same { whole } else { region })
    };
    Ok([read(paths[0], &one, regions[0])?, read(paths[1], &other, regions[1])?])
}

fn unsupported(path: &Path, Unread { what, remedy }: Unread) -> FrameFileError {
    FrameFileError::Unsupported { path: path.to_owned(), what, remedy }
}

/// A file's bytes and its headers, at least one, once it is known that they can be read.
fn header_of(path: &Path) -> Result<(Vec<u8>, MetaData), FrameFileError> {
    let mut bytes =
        read_regular(path).map_err(|source| FrameFileError::Read { path: path.to_owned(), source })?;
    if let Some(unread) = Unread::of_codec(&bytes) {
        return Err(unsupported(path, unread));
    }
    let invalid = |reason: String| FrameFileError::Invalid { path: path.to_owned(), reason };
    if exr_input::is_deep(&bytes) {
        bytes = exr_input::flattened(&bytes).map_err(|fault| match fault {
            DeepFault::Damaged(reason) => invalid(reason),
            DeepFault::Unread(unread) => unsupported(path, unread),
        })?;
    }
    if let Cow::Owned(renamed) = exr_input::of_the_kind_of_its_flags(&bytes) {
        bytes = renamed;
    }
    let meta = MetaData::read_from_buffered(bytes.as_slice(), false);
    let meta = meta.map_err(|error| invalid(reason(&error)))?;
    if meta.headers.is_empty() {
        return Err(invalid(String::from("it has no part")));
    }
    check(path, &meta.headers, bytes.len() as u64)?;
    Ok((bytes, meta))
}

fn read_in(path: &Path, bytes: &[u8], meta: &MetaData, region: Region) -> Result<FrameFile, FrameFileError> {
    let invalid = |reason: String| FrameFileError::Invalid { path: path.to_owned(), reason };
    let parts = exr_input::names_of(&meta.headers);
    let (picture, names) = (exr_input::part_of_picture(&parts), exr_input::full_names(&parts));
    let stored = if exr_input::is_subsampled(&meta.headers) {
        exr_input::read_subsampled(bytes, meta).map_err(invalid)?
    } else {
        decoded(bytes).map_err(|error| invalid(reason(&error)))?
    };
    let pixel_hash = pixel_hash(&stored[0]);
    let windows: Vec<Window> = meta.headers.iter().map(|header| region.seen(header)).collect();
    let window = windows.iter().copied().reduce(region::around).unwrap_or(windows[0]);
    let (channels, pixels) = (names.iter().flatten().count(), (window.width * window.height) as u64);
    let (bytes_of_pixels, limit) = (pixels.saturating_mul(4 * channels as u64), LARGEST_PICTURE);
    if windows.iter().any(|one| *one != window) && bytes_of_pixels > limit {
        return Err(FrameFileError::TooLarge { path: path.to_owned(), bytes: bytes_of_pixels, limit });
    }
    let mut channels = Vec::with_capacity(channels);
    for ((part, header), names) in stored.into_iter().zip(&meta.headers).zip(names) {
        for (stored, name) in part.list.into_iter().zip(names) {
            channels.push(region.channel(header, window, name, stored));
        }
    }
    Ok(FrameFile {
        frame: Frame { full: region.size, window, channels },
        attributes: Attributes::from_header(&meta.headers[picture]),
        pixel_hash,
        colors: exr_input::colors_of(bytes, picture),
    })
}

fn decoded(bytes: &[u8]) -> exr::error::Result<Vec<AnyChannels<FlatSamples>>> {
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))?;
    Ok(image.layer_data.into_iter().map(|layer| layer.channel_data).collect())
}

/// True if `path` holds, whole and undamaged, what rendering with this provenance would write there.
pub fn is_valid(path: &Path, expected: &Provenance) -> bool {
    // The whole file's hash holds, so nothing need be decoded.
    let Ok(bytes) = read_regular(path) else { return false };
    let Ok(meta) = MetaData::read_from_buffered(bytes.as_slice(), false) else { return false };
    let fits = |header: &Header| expected.matches(&Attributes::from_header(header));
    meta.headers.first().is_some_and(fits) && file_hash::is_whole(&bytes)
}

/// Refuses what would take too much memory to try.
fn check(path: &Path, headers: &[Header], file_bytes: u64) -> Result<(), FrameFileError> {
    let mut bytes = 0_u64;
    for header in headers {
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
