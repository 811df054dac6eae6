//! EXR files of any program. In go bytes, out come flat samples, the choice of the picture among them, its
//! colours, and reasons for refusal. Invariant: a refusal states a property that the file really has.

mod colors;
mod deep;
mod names;
mod raw;
mod sky;
mod subsampled;
mod unread;

pub use colors::ImageColors;
pub(crate) use deep::read as read_deep;
pub use names::{Picture, full_names, part_of_picture, stand_in};
pub(crate) use raw::{PREAMBLE, of_the_kind_of_its_flags, parts as raw_parts, record};
pub(super) use sky::{Fault, of_exr, size_of_exr};
pub(crate) use subsampled::{is_subsampled, read as read_subsampled};
pub use unread::Unread;
pub(crate) use unread::is_deep;

use ::exr::meta::header::Header;

/// Maximum bytes of pixels per byte of file. Deflate reaches at most 1032, so no valid file is refused.
pub(crate) const LARGEST_COMPRESSION: u64 = 4096;
/// Maximum bytes of pixels: an 8K picture with thirty float channels.
pub(crate) const LARGEST_PICTURE: u64 = 4 << 30;

/// Names of all parts and of their channels.
pub(crate) fn names_of(headers: &[Header]) -> Vec<(String, Vec<String>)> {
    let text = |text: &::exr::meta::attribute::Text| String::from_utf8_lossy(text.bytes()).into_owned();
    let part = |header: &Header| {
        let name = header.own_attributes.layer_name.as_ref().map(text).unwrap_or_default();
        (name, header.channels.list.iter().map(|channel| text(&channel.name)).collect())
    };
    headers.iter().map(part).collect()
}

/// Red, green and blue from luminance and chroma: RY = (R - Y) / Y and BY = (B - Y) / Y (OpenEXR, Technical
/// Introduction, Luminance/Chroma Images), with `weights` of luminance.
pub(crate) fn from_chroma([y, ry, by]: [f32; 3], weights: crate::color::Rgb) -> [f32; 3] {
    let (red, blue) = ((1.0 + ry) * y, (1.0 + by) * y);
    let green = (y - weights.x as f32 * red - weights.z as f32 * blue) / weights.y as f32;
    [red, green, blue]
}
