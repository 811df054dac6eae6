//! OpenEXR image for a sky, in linear Rec. 709. In go bytes, out come texels. Invariant: beside its result
//! the decoder takes at most three quarters of that, and 1 GiB for the parts, channels and tiles that a file
//! declares.

use super::{ImageColors, Picture, Unread, names, subsampled};
use crate::color::Rgb;
use crate::description::decoded_image::DecodedImage;
use ::exr::block::chunk::TileCoordinates;
use ::exr::block::reader::ChunksReader;
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::image::{AnyChannels, FlatSamples};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{EnvironmentMap, SampleType};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use half::f16;
use std::io::Cursor;

/// Maximum bytes of a part's samples, or of a tile's.
const MOST_PART_BYTES: u64 = 1 << 30;

/// Reason for refusing an image, and a remedy unless it is the common one.
pub(in crate::inside::description) struct Fault {
    pub(in crate::inside::description) found: String,
    pub(in crate::inside::description) remedy: Option<String>,
}

impl From<String> for Fault {
    fn from(found: String) -> Self {
        Self { found, remedy: None }
    }
}

impl From<Unread> for Fault {
    fn from(unread: Unread) -> Self {
        Self { found: format!("{} cannot be read", unread.what), remedy: Some(unread.remedy) }
    }
}

/// Width and height of an image, as its header claims.
pub(in crate::inside::description) fn size_of_exr(bytes: &[u8]) -> Result<(u32, u32), Fault> {
    if let Some(unread) = Unread::of(bytes) {
        return Err(unread.into());
    }
    let meta = meta_of(bytes)?;
    let first = meta.headers.first();
    if first.is_some_and(|first| first.own_attributes.environment_map == Some(EnvironmentMap::Cube)) {
        return Err(Fault {
            found: String::from("the image shows the six sides of a cube (`envmap`)"),
            remedy: Some(String::from(
                "unfold it by longitude and latitude: `exrenvmap -latlong IN.exr OUT.exr` of OpenEXR's own tools does",
            )),
        });
    }
    let Vec2(width, height) = first.map_or(Vec2(0, 0), |header| header.shared_attributes.display_window.size);
    let side = |texels: usize| u32::try_from(texels).unwrap_or(u32::MAX);
    Ok((side(width), side(height)))
}

fn meta_of(bytes: &[u8]) -> Result<MetaData, Fault> {
    Ok(MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(said)?)
}

fn said(error: ::exr::error::Error) -> String {
    format!("the image cannot be decoded: {error}")
}

/// Picture of an OpenEXR image, black outside its data window.
pub(in crate::inside::description) fn of_exr(bytes: &[u8], most_texels: u64) -> Result<DecodedImage, Fault> {
    let meta = meta_of(bytes)?;
    check(&meta.headers, most_texels)?;
    let parts = super::names_of(&meta.headers);
    let part = names::part_of_picture(&parts);
    let (header, channels) = (&meta.headers[part], &parts[part].1);
    let picture = Picture::among(channels).ok_or_else(|| no_picture(&parts))?;
    let colors = ImageColors::of(&meta.headers, part)?;
    let alpha = channels.iter().position(|name| name == "A");
    let places = match picture {
        Picture::Colors([red, green, blue]) => [Some(red), Some(green), Some(blue), alpha],
        Picture::Luminance(grey) => [Some(grey), None, None, alpha],
        Picture::Chroma([y, ry, by]) => [Some(y), Some(ry), Some(by), alpha],
    };
    let mut texels = vec![[0.0, 0.0, 0.0, 1.0]; header.layer_size.area()];
    if subsampled::is_subsampled(&meta.headers) {
        let mut read = subsampled::read(bytes, &meta)
            .map_err(|error| format!("the image cannot be decoded: {error}"))?;
        fill_whole(&mut texels, read.swap_remove(part), places);
    } else {
        fill(&mut texels, bytes, part, places)?;
    }
    convert(&mut texels, picture, &colors);
    let seen = header.shared_attributes.display_window;
    let begin = header.own_attributes.layer_position - seen.position;
    if begin != Vec2(0, 0) || header.layer_size != seen.size {
        texels = placed(&texels, header.layer_size, begin, seen.size);
    }
    let Vec2(width, height) = seen.size;
    Ok(DecodedImage { width, height, texels: texels.into(), doubt: colors.doubt })
}

fn no_picture(parts: &[(String, Vec<String>)]) -> Fault {
    let names: Vec<&str> =
        parts.iter().flat_map(|(_, channels)| channels).map(String::as_str).take(12).collect();
    Fault {
        found: format!("the image has no picture (R, G and B of a layer, or Y), only {}", names.join(", ")),
        remedy: Some(String::from("save it with its colours as R, G and B")),
    }
}

/// Refuses files that the decoder cannot handle, and parts or tiles so large that it would exceed its memory
/// limit.
fn check(headers: &[Header], most_texels: u64) -> Result<(), String> {
    let area = |Vec2(width, height): Vec2<usize>| (width as u64).saturating_mul(height as u64);
    let fits = |header: &Header| {
        let is_small = |size: Vec2<usize>| {
            area(size).saturating_mul(4 * header.channels.list.len() as u64) <= MOST_PART_BYTES
        };
        let tile_is_small = match header.blocks {
            BlockDescription::Tiles(tiles) => is_small(tiles.tile_size),
            BlockDescription::ScanLines => true,
        };
        tile_is_small && is_small(header.layer_size)
    };
    if headers.is_empty() || !headers.iter().all(fits) {
        return Err(String::from("the image has a part of more than 1 GiB"));
    }
    // Pixels outside the picture take memory too.
    let held = |header: &Header| {
        let seen = header.shared_attributes.display_window;
        let is_same = header.layer_size == seen.size && header.own_attributes.layer_position == seen.position;
        area(header.layer_size).saturating_add(if is_same { 0 } else { area(seen.size) })
    };
    match headers.iter().map(held).max() {
        Some(texels) if texels > most_texels => {
            Err(format!("the image and its parts have {texels} texels, of {most_texels} at most"))
        }
        _ => Ok(()),
    }
}

/// Copies the channels of these indices, block by block, into red, green, blue and alpha.
fn fill(
    texels: &mut [[f32; 4]],
    bytes: &[u8],
    part: usize,
    places: [Option<usize>; 4],
) -> Result<(), String> {
    let is_wanted = |_: &MetaData, tile: TileCoordinates, block: BlockIndex| {
        block.layer == part && tile.is_largest_resolution_level()
    };
    let reader = ::exr::block::read(Cursor::new(bytes), false).map_err(said)?;
    let reader = reader.filter_chunks(false, is_wanted).map_err(said)?;
    let header = reader.meta_data().headers[part].clone();
    let mut blocks = reader.sequential_decompressor(false);
    while let Some(block) = blocks.decompress_next_block() {
        let block: UncompressedBlock = block.map_err(said)?;
        for line in block.lines(&header.channels) {
            let Some(component) = places.iter().position(|place| *place == Some(line.location.channel))
            else {
                continue;
            };
            let Vec2(x, y) = line.location.position;
            let begin = y * header.layer_size.0 + x;
            let Some(row) = texels.get_mut(begin..begin + line.location.sample_count) else { continue };
            let samples = floats(line.value, header.channels.list[line.location.channel].sample_type);
            for (texel, sample) in row.iter_mut().zip(samples) {
                texel[component] = sample;
            }
        }
    }
    Ok(())
}

/// Samples in native byte order.
fn floats(bytes: &[u8], kind: SampleType) -> impl Iterator<Item = f32> + '_ {
    let size = kind.bytes_per_sample();
    bytes.chunks_exact(size).map(move |sample| match (kind, sample) {
        (SampleType::F16, &[a, b]) => f16::from_ne_bytes([a, b]).to_f32(),
        (SampleType::F32, &[a, b, c, d]) => f32::from_ne_bytes([a, b, c, d]),
        (SampleType::U32, &[a, b, c, d]) => u32::from_ne_bytes([a, b, c, d]) as f32,
        _ => 0.0,
    })
}

fn fill_whole(texels: &mut [[f32; 4]], channels: AnyChannels<FlatSamples>, places: [Option<usize>; 4]) {
    for (component, place) in places.into_iter().enumerate() {
        let Some(channel) = place.and_then(|place| channels.list.get(place)) else { continue };
        for (texel, sample) in texels.iter_mut().zip(channel.sample_data.values_as_f32()) {
            texel[component] = sample;
        }
    }
}

/// Converts luminance and chroma to red, green and blue, and those to linear Rec. 709.
fn convert(texels: &mut [[f32; 4]], picture: Picture, colors: &ImageColors) {
    let (weights, is_ours) =
        (colors.space.luminances(), colors.space.is_same(&crate::color::ColorSpace::OURS));
    for [red, green, blue, _] in texels {
        match picture {
            Picture::Colors(_) => {}
            Picture::Luminance(_) => (*green, *blue) = (*red, *red),
            Picture::Chroma(_) => [*red, *green, *blue] = super::from_chroma([*red, *green, *blue], weights),
        }
        if !is_ours {
            let ours = colors.space.to_rec_709(Rgb::new((*red).into(), (*green).into(), (*blue).into()));
            [*red, *green, *blue] = ours.as_vec3().to_array();
        }
    }
}

/// Texels of a part whose data window differs from the picture, moved to the picture.
fn placed(
    texels: &[[f32; 4]],
    Vec2(columns, _): Vec2<usize>,
    Vec2(left, top): Vec2<i32>,
    Vec2(width, height): Vec2<usize>,
) -> Vec<[f32; 4]> {
    let mut picture = vec![[0.0, 0.0, 0.0, 0.0]; width * height];
    for (index, texel) in texels.iter().enumerate() {
        let (x, y) = ((index % columns) as i64 + i64::from(left), (index / columns) as i64 + i64::from(top));
        if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
            picture[y as usize * width + x as usize] = *texel;
        }
    }
    picture
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use ::exr::image::write::WritableImage;
    use ::exr::image::{Encoding, Image, Layer, SpecificChannels};
    use ::exr::meta::attribute::IntegerBounds;
    use ::exr::meta::header::LayerAttributes;

    /// A picture of 4x2 texels, of which a part holds its columns, rows and 1.
    fn exr(size: (usize, usize), layer_position: Vec2<i32>) -> Vec<u8> {
        let channels = SpecificChannels::rgb(|Vec2(x, y)| (x as f32, y as f32, 1.0_f32));
        let attributes = LayerAttributes { layer_position, ..LayerAttributes::default() };
        let mut image = Image::from_layer(Layer::new(size, attributes, Encoding::UNCOMPRESSED, channels));
        image.attributes.display_window = IntegerBounds::from_dimensions((4, 2));
        let mut bytes = Cursor::new(Vec::new());
        image.write().non_parallel().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn parts_lie_where_their_windows_say() {
        let whole = of_exr(&exr((4, 2), Vec2(0, 0)), 8).ok().unwrap();
        assert_eq!((whole.width, whole.height), (4, 2));
        let whole = whole.texels.into_floats();
        assert_eq!((whole[0], whole[7]), ([0.0, 0.0, 1.0, 1.0], [3.0, 1.0, 1.0, 1.0]));
        let part = of_exr(&exr((3, 2), Vec2(2, -1)), 14).ok().unwrap().texels.into_floats();
        let none = [0.0; 4];
        assert_eq!(part[..4], [none, none, [0.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]]);
        assert_eq!(part[4..], [none; 4]);
    }

    /// Known from the header, before anything is decoded.
    #[test]
    fn claims_of_too_many_texels_are_refused() {
        for (bytes, texels) in [(exr((4, 2), Vec2(0, 0)), 8), (exr((3, 2), Vec2(2, -1)), 14)] {
            assert!(of_exr(&bytes, texels).is_ok());
            let refused = of_exr(&bytes[..bytes.len() - 20], texels - 1).err().unwrap().found;
            assert!(refused.contains(&format!("{texels} texels")), "{refused}");
        }
    }
}
