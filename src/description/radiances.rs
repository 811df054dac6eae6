//! Images of radiances, OpenEXR and Radiance HDR, to linear Rec. 709. Invariant: beside its result a
//! decoder takes no more memory than three quarters of that, and 1 GiB for what a file claims of
//! parts, channels and tiles.

use super::decoded_image::DecodedImage;
use crate::color::Primaries;
use ::image::DynamicImage;
use exr::image::read::image::ReadLayers;
use exr::image::read::layers::ReadChannels;
use exr::math::Vec2;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use glam::{DMat3, DVec2, Vec3};
use std::io::Cursor;

/// Elements of a matrix between primaries that are the same, but for the digits that files give.
const SAME_PRIMARIES: f64 = 1e-3;

/// Larger radiances are refused, as larger numbers are everywhere.
const MOST_RADIANCE: f32 = 1e15;

/// Most bytes of a part's samples, or of a tile's.
const MOST_PART_BYTES: u64 = 1 << 30;

/// Width and height of an OpenEXR image, as its header claims.
///
/// # Errors
/// With the reason if the header is damaged.
pub(super) fn size_of_exr(bytes: &[u8]) -> Result<(u32, u32), String> {
    let meta = meta_of(bytes)?;
    let Vec2(width, height) =
        meta.headers.first().map_or(Vec2(0, 0), |header| header.shared_attributes.display_window.size);
    let side = |texels: usize| u32::try_from(texels).unwrap_or(u32::MAX);
    Ok((side(width), side(height)))
}

fn meta_of(bytes: &[u8]) -> Result<MetaData, String> {
    MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(said)
}

fn said(error: exr::error::Error) -> String {
    format!("the image cannot be decoded: {error}")
}

/// The first part of an OpenEXR image that has red, green and blue, black where its pixels do not reach.
///
/// # Errors
/// With the reason if it is damaged, of a kind that is not read, or too large.
pub(super) fn of_exr(bytes: &[u8], most_texels: u64) -> Result<DecodedImage, String> {
    let meta = meta_of(bytes)?;
    check(&meta.headers, most_texels)?;
    let ours_from_its = ours_from_its(&meta.headers)?;
    let image = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |Vec2(width, height), _| (width, vec![[0.0, 0.0, 0.0, 1.0]; width * height]),
            |(width, texels), Vec2(x, y), (red, green, blue, alpha): (f32, f32, f32, f32)| {
                texels[y * *width + x] = [red, green, blue, alpha];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(said)?;
    let (seen, layer) = (image.attributes.display_window, image.layer_data);
    let begin = layer.attributes.layer_position - seen.position;
    let (_, texels) = layer.channel_data.pixels;
    let Vec2(width, height) = seen.size;
    let texels = if begin == Vec2(0, 0) && layer.size == seen.size {
        texels
    } else {
        placed(&texels, layer.size, begin, seen.size)
    };
    checked(DecodedImage { width, height, texels: converted(texels, ours_from_its).into() })
}

/// The same of a Radiance HDR image.
///
/// # Errors
/// With the first texel whose radiance is none.
pub(super) fn of_hdr(decoded: DynamicImage) -> Result<DecodedImage, String> {
    let rgb = decoded.into_rgb32f();
    let (width, height) = (rgb.width() as usize, rgb.height() as usize);
    let texel = |pixel: &::image::Rgb<f32>| [pixel[0], pixel[1], pixel[2], 1.0];
    checked(DecodedImage { width, height, texels: rgb.pixels().map(texel).collect() })
}

/// Refuses what the decoder cannot do, and what would make it take more memory than the limits, which it does
/// not keep to: parts and tiles of any size, and channels that have fewer samples than the picture.
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
        let is_whole = header.channels.list.iter().all(|channel| channel.sampling == Vec2(1, 1));
        !header.deep && is_whole && tile_is_small && is_small(header.layer_size)
    };
    if !headers.iter().all(fits) {
        return Err(String::from(
            "the image has deep data, a subsampled channel, or a part of more than 1 GiB",
        ));
    }
    // Pixels that lie elsewhere than the picture are held beside it.
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

/// Linear Rec. 709 from the image's colours, if it has others. Without the attribute they are Rec. 709
/// (OpenEXR, "Standard attributes").
fn ours_from_its(headers: &[Header]) -> Result<Option<DMat3>, String> {
    let said = headers.first().and_then(|header| header.shared_attributes.chromaticities);
    let Some(said) = said else { return Ok(None) };
    let place = |Vec2(x, y): Vec2<f32>| DVec2::new(x.into(), y.into());
    let [red, green, blue, white] = [said.red, said.green, said.blue, said.white].map(place);
    let matrix = Primaries { red, green, blue, white }.to_rec_709();
    let matrix = matrix.ok_or("the image's chromaticities span no colours")?;
    Ok(Some(matrix).filter(|matrix| !matrix.abs_diff_eq(DMat3::IDENTITY, SAME_PRIMARIES)))
}

fn converted(mut texels: Vec<[f32; 4]>, ours_from_its: Option<DMat3>) -> Vec<[f32; 4]> {
    if let Some(ours_from_its) = ours_from_its {
        for [red, green, blue, _] in &mut texels {
            let ours = ours_from_its * Vec3::new(*red, *green, *blue).as_dvec3();
            [*red, *green, *blue] = ours.as_vec3().to_array();
        }
    }
    texels
}

/// Texels of a part that begins somewhere else than the picture, in the picture's place.
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

/// What is wrong is said of the first texel concerned.
fn checked(image: DecodedImage) -> Result<DecodedImage, String> {
    let is_bad =
        |texel: &[f32; 4]| texel[..3].iter().any(|value| value.is_nan() || value.abs() > MOST_RADIANCE);
    let bad = image.texels.iter().enumerate().find(|(_, texel)| is_bad(texel));
    match bad {
        Some((bad, texel)) => Err(format!(
            "the texel in column {} of row {} has the radiance {:?}",
            bad % image.width,
            bad / image.width,
            &texel[..3]
        )),
        None => Ok(image),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use exr::image::write::WritableImage;
    use exr::image::{Encoding, Image, Layer, SpecificChannels};
    use exr::meta::attribute::IntegerBounds;
    use exr::meta::header::LayerAttributes;

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
        let whole = of_exr(&exr((4, 2), Vec2(0, 0)), 8).unwrap();
        assert_eq!((whole.width, whole.height), (4, 2));
        let whole = whole.texels.into_floats();
        assert_eq!((whole[0], whole[7]), ([0.0, 0.0, 1.0, 1.0], [3.0, 1.0, 1.0, 1.0]));
        let part = of_exr(&exr((3, 2), Vec2(2, -1)), 14).unwrap().texels.into_floats();
        let none = [0.0; 4];
        assert_eq!(part[..4], [none, none, [0.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]]);
        assert_eq!(part[4..], [none; 4]);
    }

    /// Known from the header, before anything is decoded.
    #[test]
    fn claims_of_too_many_texels_are_refused() {
        for (bytes, texels) in [(exr((4, 2), Vec2(0, 0)), 8), (exr((3, 2), Vec2(2, -1)), 14)] {
            assert!(of_exr(&bytes, texels).is_ok());
            let refused = of_exr(&bytes[..bytes.len() - 20], texels - 1).unwrap_err();
            assert!(refused.contains(&format!("{texels} texels")), "{refused}");
        }
    }

    #[test]
    fn a_texel_that_is_no_radiance_is_named() {
        let rgb = ::image::ImageBuffer::from_fn(2, 2, |x, y| ::image::Rgb([1.0, (x + y) as f32 * 6e14, 0.0]));
        let refused = of_hdr(DynamicImage::ImageRgb32F(rgb)).unwrap_err();
        assert!(refused.contains("column 1 of row 1"), "{refused}");
    }
}
