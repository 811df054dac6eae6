//! Reader of EXR files. In goes a file, out come a frame and its attributes. Invariant: memory is at most a
//! fixed multiple of the file's size.

use super::pixel_hash::pixel_hash;
use super::provenance::PIXEL_HASH_NAME;
use super::region::{self, Region};
use super::{Attributes, FrameFileError, Provenance, file_hash};
use crate::description::exr::{self as exr_input, ImageColors, LARGEST_COMPRESSION, LARGEST_PICTURE, Unread};
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

/// Contents of a file.
#[derive(Clone, Debug)]
pub struct FrameFile {
    /// Pixels. Integer channels become float ones, exact up to 2^24.
    pub frame: Frame,
    /// Attributes of the header.
    pub attributes: Attributes,
    /// Hash of the pixels, computed from the pixels.
    pub pixel_hash: String,
    /// Colour space of the picture.
    pub colors: ImageColors,
    /// Width of a pixel by its height (`pixelAspectRatio`), 1 where the file says nothing that can be.
    pub pixel_aspect: f64,
}

/// Maximum width of a pixel by its height, and height by its width. Larger ratios count as mistakes.
const WIDEST_PIXEL: f64 = 16.0;

impl FrameFile {
    /// Whether the pixels are those of the stored hash.
    pub fn is_intact(&self) -> bool {
        self.attributes.get(PIXEL_HASH_NAME) == Some(&self.pixel_hash)
    }
}

/// Reads an EXR file of any program, in its display window. In a multi-part file, channels are named
/// `part.channel`, except in the picture's part. Smaller windows are padded with 0, subsampled channels are
/// repeated, and deep samples are composited.
///
/// # Errors
/// If it cannot be read, is damaged or not supported, or declares more pixels than its size can hold.
pub fn read(path: &Path) -> Result<FrameFile, FrameFileError> {
    let (bytes, meta) = header_of(path)?;
    let display = Region::displayed(&meta.headers[0]);
    read_in(path, &bytes, &meta, display)
}

/// Reads two files for a comparison. If their display windows are equal, pixels outside them are read as
/// well.
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

/// Bytes of a file and its headers, at least one, once the file is known to be readable.
fn header_of(path: &Path) -> Result<(Vec<u8>, MetaData), FrameFileError> {
    let mut bytes =
        read_regular(path).map_err(|source| FrameFileError::Read { path: path.to_owned(), source })?;
    if let Some(unread) = Unread::of_codec(&bytes).or_else(|| Unread::of_mixed(&bytes)) {
        return Err(unsupported(path, unread));
    }
    let invalid = |reason: String| FrameFileError::Invalid { path: path.to_owned(), reason };
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
    let stored = if exr_input::is_deep(bytes) {
        exr_input::read_deep(bytes, meta).map_err(invalid)?
    } else if exr_input::is_subsampled(&meta.headers) {
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
        colors: ImageColors::of(&meta.headers, picture).unwrap_or_else(|_| ImageColors::unsaid()),
        pixel_aspect: pixel_aspect(&meta.headers[0]),
    })
}

fn pixel_aspect(header: &Header) -> f64 {
    let aspect = f64::from(header.shared_attributes.pixel_aspect);
    if (1.0 / WIDEST_PIXEL..=WIDEST_PIXEL).contains(&aspect) { aspect } else { 1.0 }
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

/// Whether `path` holds, undamaged, the file that rendering with this provenance would write.
pub fn is_valid(path: &Path, expected: &Provenance) -> bool {
    // The hash of the whole file suffices, without decoding.
    let Ok(bytes) = read_regular(path) else { return false };
    let Ok(meta) = MetaData::read_from_buffered(bytes.as_slice(), false) else { return false };
    let fits = |header: &Header| expected.matches(&Attributes::from_header(header));
    meta.headers.first().is_some_and(fits) && file_hash::is_whole(&bytes)
}

/// Refuses files that need too much memory.
fn check(path: &Path, headers: &[Header], file_bytes: u64) -> Result<(), FrameFileError> {
    let of_part = |header: &Header| {
        let Vec2(width, height) = header.layer_size;
        // Decoded integers and halves take four bytes, like floats.
        let bytes = 4 * header.channels.list.len() as u64;
        (width as u64).saturating_mul(height as u64).saturating_mul(bytes)
    };
    let bytes = headers.iter().map(of_part).fold(0, u64::saturating_add);
    let limit = file_bytes.saturating_mul(LARGEST_COMPRESSION).min(LARGEST_PICTURE);
    if bytes > limit {
        return Err(FrameFileError::TooLarge { path: path.to_owned(), bytes, limit });
    }
    Ok(())
}

/// Message of the decoder, in plainer words where necessary.
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
