//! Encoding of EXR files. In go a frame and its provenance, out come bytes. Invariant: equal frames and equal
//! provenance give equal bytes.

use super::pixel_hash::pixel_hash;
use super::provenance::{COLOR_ID, REC_709, text};
use super::{FrameFileError, Provenance, atomic, cryptomatte, file_hash};
use crate::description::exr::{PREAMBLE, raw_parts, record};
use crate::film::{Channel, Frame, Precision};
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Compression, IntegerBounds, LineOrder};
use exr::meta::header::{ImageAttributes, LayerAttributes};
use std::io::Cursor;
use std::path::Path;

/// Writes a frame to `path`, whole or not at all; folders are created. Values beyond the range of half
/// channels are stored as the largest half; NaN and infinity are stored as they are; the caller has to refuse
/// them.
///
/// # Errors
/// If the file cannot be written, or the frame has no pixels.
pub fn write(path: &Path, frame: &Frame, provenance: &Provenance) -> Result<(), FrameFileError> {
    let bytes = encode(frame, provenance)
        .map_err(|reason| FrameFileError::Encode { path: path.to_owned(), reason })?;
    atomic::write(path, &bytes)
}

pub(super) fn encode(frame: &Frame, provenance: &Provenance) -> Result<Vec<u8>, String> {
    let window = frame.window;
    if frame.channels.iter().any(|channel| channel.pixels.len() != window.width * window.height) {
        return Err(String::from("a channel has more or fewer values than the window has pixels"));
    }
    let channels = AnyChannels::sort(frame.channels.iter().map(stored).collect());
    let mut attributes = LayerAttributes {
        layer_position: Vec2(position(window.x)?, position(window.y)?),
        ..provenance.layer_attributes(&pixel_hash(&channels))
    };
    for (name, value) in cryptomatte::attributes(frame, &provenance.object_names) {
        attributes.other.insert(text(&name), AttributeValue::Text(text(&value)));
    }
    // Programs that support ids, such as OpenImageIO 3.2, ignore chromaticities; others support these alone.
    attributes.other.insert(text("colorInteropID"), AttributeValue::Text(text(COLOR_ID)));
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let mut image_attributes =
        ImageAttributes::new(IntegerBounds::new((0, 0), (frame.full.width, frame.full.height)));
    image_attributes.chromaticities = Some(REC_709);
    let layer = Layer::new((window.width, window.height), attributes, encoding, channels);
    let mut bytes = Vec::new();
    Image::new(image_attributes, layer)
        .write()
        .non_parallel()
        .to_buffered(Cursor::new(&mut bytes))
        .map_err(|error| error.to_string())?;
    sort_attributes(&mut bytes)
        .and_then(|()| file_hash::seal(&mut bytes))
        .ok_or("the encoder wrote a header that cannot be read")?;
    Ok(bytes)
}

fn position(pixel: usize) -> Result<i32, String> {
    i32::try_from(pixel).map_err(|_| format!("the window begins at pixel {pixel}, beyond what EXR can say"))
}

fn stored(channel: &Channel) -> AnyChannel<FlatSamples> {
    let samples = match channel.precision {
        Precision::Half => {
            FlatSamples::F16(channel.pixels.iter().map(|&value| Precision::half_from(value)).collect())
        }
        Precision::Float => FlatSamples::F32(channel.pixels.clone()),
    };
    AnyChannel::new(text(&channel.name), samples)
}

/// Sorts the header's attributes by name: the encoder keeps some of them in a hash map, whose order differs
/// from run to run. The header's length stays the same, so offsets stay valid.
fn sort_attributes(file: &mut [u8]) -> Option<()> {
    let mut attributes = raw_parts(file)?.0.into_iter().next()?.attributes;
    attributes.sort_unstable_by_key(|(name, ..)| *name);
    let sorted: Vec<u8> = attributes.into_iter().flat_map(record).collect();
    file.get_mut(PREAMBLE..PREAMBLE + sorted.len())?.copy_from_slice(&sorted);
    Some(())
}
