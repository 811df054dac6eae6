//! Values of a node, as its grid compresses them. In go bytes, out comes a value for each place.
//! Source: `openvdb/io/Compression.h`, `readCompressedValues`.

use super::blosc;
use super::bytes::{Bytes, Mask, Read};
use half::f16;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

const ZIP: u32 = 0x1;
const ACTIVE_MASK: u32 = 0x2;
const BLOSC: u32 = 0x4;

/// How what is not active is written: the byte before the values of a node.
mod inactive {
    pub(super) const BACKGROUND: u8 = 0;
    pub(super) const ONE: u8 = 2;
    pub(super) const BACKGROUND_BY_MASK: u8 = 3;
    pub(super) const ONE_BY_MASK: u8 = 4;
    pub(super) const TWO_BY_MASK: u8 = 5;
    pub(super) const ALL_WRITTEN: u8 = 6;
}

/// How a grid writes its values.
pub(super) struct Encoding {
    /// The grid's flags of compression.
    pub(super) flags: u32,
    /// Whether values have 16 bits.
    pub(super) is_half: bool,
    /// Value of what is not in the tree.
    pub(super) background: f32,
}

impl Encoding {
    /// The values of a node's places, of which `active` says which are active.
    pub(super) fn values(&self, bytes: &mut Bytes, active: Mask, count: usize) -> Read<Vec<f32>> {
        let kind = bytes.u8()?;
        if kind > inactive::ALL_WRITTEN {
            return Err(bytes.fault(format!("values of a kind {kind} that OpenVDB does not have")));
        }
        let mut off = [-self.background, self.background];
        match kind {
            inactive::BACKGROUND => off[0] = self.background,
            inactive::ONE | inactive::ONE_BY_MASK => off[0] = bytes.f32()?,
            inactive::TWO_BY_MASK => off = [bytes.f32()?, bytes.f32()?],
            _ => {}
        }
        let chosen = match kind {
            inactive::BACKGROUND_BY_MASK | inactive::ONE_BY_MASK | inactive::TWO_BY_MASK => {
                Some(bytes.mask(count)?)
            }
            _ => None,
        };
        if self.flags & ACTIVE_MASK == 0 || kind == inactive::ALL_WRITTEN {
            return self.numbers(bytes, count);
        }
        let mut written = self.numbers(bytes, active.count())?.into_iter();
        let value = |place| {
            let which = chosen.is_some_and(|chosen| chosen.is_on(place));
            let of_active = if active.is_on(place) { written.next() } else { None };
            of_active.unwrap_or(off[usize::from(which)])
        };
        Ok((0..count).map(value).collect())
    }

    /// `count` numbers that are written one after the other.
    fn numbers(&self, bytes: &mut Bytes, count: usize) -> Read<Vec<f32>> {
        if self.is_half {
            // Nothing at all is written for no number, not even its length.
            let raw = if count == 0 { Vec::new() } else { self.raw(bytes, 2 * count)? };
            return Ok(raw
                .chunks_exact(2)
                .map(|two| f16::from_le_bytes([two[0], two[1]]).to_f32())
                .collect());
        }
        let raw = self.raw(bytes, 4 * count)?;
        let number = |four: &[u8]| f32::from_le_bytes([four[0], four[1], four[2], four[3]]);
        Ok(raw.chunks_exact(4).map(number).collect())
    }

    fn raw(&self, bytes: &mut Bytes, size: usize) -> Read<Vec<u8>> {
        if self.flags & (ZIP | BLOSC) == 0 {
            return bytes.take(size).map(<[u8]>::to_vec);
        }
        // What compression would not make shorter is written as it is, and its length negative.
        let length = bytes.i64()?;
        if length <= 0 {
            if length.unsigned_abs() != size as u64 {
                return Err(
                    bytes.fault(format!("{size} bytes are expected, {} are written", -i128::from(length)))
                );
            }
            return bytes.take(size).map(<[u8]>::to_vec);
        }
        let before = bytes.clone();
        let chunk = bytes.take(usize::try_from(length).unwrap_or(usize::MAX))?;
        if self.flags & BLOSC != 0 {
            return blosc::decompress(chunk, size).map_err(|fault| before.fault(fault.what));
        }
        let unzipped = decompress_to_vec_zlib_with_limit(chunk, size).ok();
        unzipped
            .filter(|unzipped| unzipped.len() == size)
            .ok_or_else(|| before.fault("a chunk cannot be unzipped"))
    }
}
