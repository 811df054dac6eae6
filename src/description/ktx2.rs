//! KTX2 images with Basis Universal (KHR_texture_basisu). In go compressed bytes, out come codes. Invariant:
//! nothing beyond the limits is decompressed, whatever the file declares.

use ::image::{DynamicImage, RgbaImage};
use basisu::{DecodeFlags, TargetFormat, Transcoder};

/// Identifier at the start of a KTX2 file (KTX 2.0 specification, 3.1).
const IDENTIFIER: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
/// Offset of the width. The height, the depth, and the numbers of layers, faces and levels follow, four bytes
/// each (3.4 to 3.9).
const SIZES: usize = 20;
/// Offset of the largest level's offset. Its compressed and uncompressed lengths follow, eight bytes each
/// (3.12).
const LEVEL: usize = 80;

/// Whether `bytes` are a KTX2 file.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(IDENTIFIER)
}

/// Decodes the largest level, of at most `most_side` texels a side and `most_texels` in all.
pub(super) fn decode(bytes: &[u8], most_side: u32, most_texels: u64) -> Result<DynamicImage, String> {
    let size = |number: usize| {
        let bytes = bytes.get(SIZES + 4 * number..)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    };
    let sizes: Option<Vec<u32>> = (0..6).map(size).collect();
    let Some(&[width, height, depth, layers, faces, levels]) = sizes.as_deref() else {
        return Err(String::from("the KTX2 image is cut short"));
    };
    let is_in_range = |side: u32| (1..=most_side).contains(&side);
    if !is_in_range(width) || !is_in_range(height) || u64::from(width) * u64::from(height) > most_texels {
        return Err(format!("the image has {width}x{height} texels"));
    }
    // KHR_texture_basisu, "KTX v2 Images with Basis Universal supercompression".
    if depth > 0 || layers > 1 || faces != 1 || levels > 16 {
        return Err(String::from("the KTX2 image is no plain picture, but a volume, an array or a cube"));
    }
    check_level(bytes, width, height).ok_or_else(|| String::from("the KTX2 image is damaged"))?;
    let damaged = |error: basisu::Error| format!("the KTX2 image cannot be decoded: {error:?}");
    let transcoder = Transcoder::new(bytes).map_err(damaged)?;
    let texels = transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(damaged)?;
    let image = RgbaImage::from_raw(width, height, texels);
    image.map(DynamicImage::from).ok_or_else(|| String::from("the KTX2 image has other texels than it says"))
}

/// Checks that the largest level lies in the file, and expands to at most 16 bytes for 4 x 4 texels, the
/// maximum of all codecs. The decoder itself does not check this.
fn check_level(bytes: &[u8], width: u32, height: u32) -> Option<()> {
    let number = |number: usize| {
        let bytes = bytes.get(LEVEL + 8 * number..)?.first_chunk()?;
        Some(u64::from_le_bytes(*bytes))
    };
    let end = number(0)?.checked_add(number(1)?)?;
    let most = u64::from(width.next_multiple_of(4)) * u64::from(height.next_multiple_of(4));
    (end <= bytes.len() as u64 && number(2)? <= most).then_some(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A file of blocks of one colour each (UASTC, mode 8: a code of five bits, then red,
    /// green, blue and alpha).
    fn file(width: u32, height: u32, colors: &[[u8; 4]]) -> Vec<u8> {
        let mut descriptor = Vec::new();
        // Khronos Data Format 1.3, chapter 5: a basic descriptor of one sample of 128
        // bits in the model UASTC.
        for word in [
            44,
            0,
            2 | 40 << 16,
            166 | 1 << 8 | 2 << 16,
            3 | 3 << 8,
            16,
            0,
            127 << 16 | 3 << 24,
            0,
            0,
            u32::MAX,
        ] {
            descriptor.extend(u32::to_le_bytes(word));
        }
        let block = |[red, green, blue, alpha]: &[u8; 4]| {
            (0x17 | u128::from(u32::from_le_bytes([*red, *green, *blue, *alpha])) << 5).to_le_bytes()
        };
        let blocks: Vec<u8> = colors.iter().flat_map(block).collect();
        let (first, length) = (LEVEL + 24, descriptor.len());
        let mut file = IDENTIFIER.to_vec();
        for word in [0, 1, width, height, 0, 0, 1, 1, 0, first as u32, length as u32, 0, 0, 0, 0, 0, 0] {
            file.extend(u32::to_le_bytes(word));
        }
        for number in [first + length, blocks.len(), blocks.len()] {
            file.extend((number as u64).to_le_bytes());
        }
        [file, descriptor, blocks].concat()
    }

    #[test]
    fn blocks_of_one_colour_are_read() {
        let (left, right) = ([255, 128, 0, 255], [10, 20, 30, 40]);
        let image = decode(&file(7, 3, &[left, right]), 16384, 1 << 26).unwrap().into_rgba8();
        assert_eq!((image.width(), image.height()), (7, 3));
        for (x, _, texel) in image.enumerate_pixels() {
            assert_eq!(texel.0, if x < 4 { left } else { right });
        }
    }

    #[test]
    fn what_claims_too_much_is_refused() {
        let good = file(4, 4, &[[1, 2, 3, 4]]);
        for (at, value) in
            [(20, 20_000), (24, 0), (32, 9), (36, 6), (LEVEL, 5000), (LEVEL + 20, 1), (LEVEL + 4, u32::MAX)]
        {
            let mut bad = good.clone();
            bad[at..at + 4].copy_from_slice(&u32::to_le_bytes(value));
            assert!(decode(&bad, 16384, 1 << 26).is_err(), "{at}");
        }
    }

    proptest! {
        #[test]
        fn changed_bytes_never_panic(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            kept in prop::option::weighted(0.2, any::<prop::sample::Index>()),
        ) {
            let mut bytes = file(8, 4, &[[1, 2, 3, 4], [5, 6, 7, 8]]);
            for (at, byte) in changes {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            bytes.truncate(kept.map_or(bytes.len(), |kept| kept.index(bytes.len())));
            let _ = decode(&bytes, 16384, 1 << 26);
        }
    }
}
