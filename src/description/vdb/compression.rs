//! Compressed values of nodes. In go bytes, out comes a value for each place. Invariant: exactly the expected
//! number of bytes is decompressed. Source: `openvdb/io/Compression.h`, `readCompressedValues`.

use super::blosc;
use super::bytes::{Bytes, Mask, Number, Read, Value};
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

const ZIP: u32 = 0x1;
const ACTIVE_MASK: u32 = 0x2;
const BLOSC: u32 = 0x4;

/// Encoding of inactive values: the byte before the values of a node.
mod inactive {
    pub(super) const BACKGROUND: u8 = 0;
    pub(super) const ONE: u8 = 2;
    pub(super) const BACKGROUND_BY_MASK: u8 = 3;
    pub(super) const ONE_BY_MASK: u8 = 4;
    pub(super) const TWO_BY_MASK: u8 = 5;
    pub(super) const ALL_WRITTEN: u8 = 6;
}

/// Encoding of a grid's values.
pub(super) struct Encoding<V> {
    pub(super) flags: u32,
    /// Encoding of single numbers, and of lists of numbers.
    pub(super) one: Number,
    pub(super) many: Number,
    /// Value outside the tree.
    pub(super) background: V,
}

impl<V: Value> Encoding<V> {
    /// Reads the values of a node's places; `active` is the mask of active ones.
    pub(super) fn values(&self, bytes: &mut Bytes, active: Mask, count: usize) -> Read<Vec<V>> {
        let kind = bytes.u8()?;
        if kind > inactive::ALL_WRITTEN {
            return Err(bytes.fault(format!("values of a kind {kind} that OpenVDB does not have")));
        }
        let mut off = [self.background.negated(), self.background];
        match kind {
            inactive::BACKGROUND => off[0] = self.background,
            inactive::ONE | inactive::ONE_BY_MASK => off[0] = bytes.value(self.one)?,
            inactive::TWO_BY_MASK => off = [bytes.value(self.one)?, bytes.value(self.one)?],
            _ => {}
        }
        let chosen = match kind {
            inactive::BACKGROUND_BY_MASK | inactive::ONE_BY_MASK | inactive::TWO_BY_MASK => {
                Some(bytes.mask(count)?)
            }
            _ => None,
        };
        if self.flags & ACTIVE_MASK == 0 || kind == inactive::ALL_WRITTEN {
            return self.written(bytes, count);
        }
        let mut written = self.written(bytes, active.count())?.into_iter();
        let value = |place| {
            let which = chosen.is_some_and(|chosen| chosen.is_on(place));
            let of_active = if active.is_on(place) { written.next() } else { None };
            of_active.unwrap_or(off[usize::from(which)])
        };
        Ok((0..count).map(value).collect())
    }

    /// Reads `count` consecutive values.
    fn written(&self, bytes: &mut Bytes, count: usize) -> Read<Vec<V>> {
        let numbers = self.numbers(bytes, count * V::NUMBERS)?;
        Ok(numbers.chunks_exact(V::NUMBERS).map(V::of).collect())
    }

    fn numbers(&self, bytes: &mut Bytes, count: usize) -> Read<Vec<f32>> {
        // Nothing at all is written for no half, not even its length.
        if count == 0 && matches!(self.many, Number::Half) {
            return Ok(Vec::new());
        }
        let raw = self.raw(bytes, self.many.size() * count)?;
        Ok(raw.chunks_exact(self.many.size()).map(|bytes| self.many.of(bytes)).collect())
    }

    fn raw(&self, bytes: &mut Bytes, size: usize) -> Read<Vec<u8>> {
        if self.flags & (ZIP | BLOSC) == 0 {
            return bytes.take(size).map(<[u8]>::to_vec);
        }
        // A negative length is that of uncompressed values.
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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use half::f16;
    use miniz_oxide::deflate::compress_to_vec_zlib;

    const ACTIVE: [u8; 1] = [0b0101_0001];
    const BY_MASK: u8 = 0b0010_0010;

    fn floats(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    /// The values of a node of 8 places, read from what stands before them and their bytes.
    fn read(flags: u32, many: Number, before: &[u8], numbers: &[u8]) -> Vec<f32> {
        let all = [before, numbers].concat();
        let mut bytes = Bytes::new(&all);
        let active = Bytes::new(&ACTIVE).mask(8).unwrap();
        let encoding = Encoding { flags, one: Number::Float, many, background: 9.0_f32 };
        let values = encoding.values(&mut bytes, active, 8).unwrap();
        assert_eq!(bytes.place(), all.len() as i64, "all bytes are read");
        values
    }

    /// Behind its length, zipped, or as it is where that is shorter.
    fn zipped(raw: &[u8], is_shorter: bool) -> Vec<u8> {
        let bytes = if is_shorter { compress_to_vec_zlib(raw, 6) } else { raw.to_vec() };
        let length = if is_shorter { bytes.len() as i64 } else { -(bytes.len() as i64) };
        [&length.to_le_bytes()[..], &bytes].concat()
    }

    #[test]
    fn what_is_not_active_has_the_value_that_its_kind_says() {
        let numbers = floats(&[1.0, 2.0, 3.0]);
        let (one, two) = (floats(&[5.0]), floats(&[5.0, 6.0]));
        for (before, off, chosen) in [
            (vec![0], 9.0, 9.0),
            (vec![1], -9.0, -9.0),
            ([&[2][..], &one].concat(), 5.0, 5.0),
            (vec![3, BY_MASK], -9.0, 9.0),
            ([&[4][..], &one, &[BY_MASK]].concat(), 5.0, 9.0),
            ([&[5][..], &two, &[BY_MASK]].concat(), 5.0, 6.0),
        ] {
            let expected = [1.0, chosen, off, off, 2.0, chosen, 3.0, off];
            assert_eq!(read(ACTIVE_MASK, Number::Float, &before, &numbers), expected);
            for is_shorter in [true, false] {
                let numbers = zipped(&numbers, is_shorter);
                assert_eq!(read(ACTIVE_MASK | ZIP, Number::Float, &before, &numbers), expected);
            }
        }
    }

    #[test]
    fn all_values_may_be_written_and_as_half_floats() {
        let all = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, -4.0];
        assert_eq!(read(ACTIVE_MASK, Number::Float, &[6], &floats(&all)), all);
        assert_eq!(read(0, Number::Float, &[0], &floats(&all)), all);
        let halves: Vec<u8> = all.iter().flat_map(|&value| f16::from_f32(value).to_le_bytes()).collect();
        assert_eq!(read(0, Number::Half, &[0], &halves), all);
        assert_eq!(read(ZIP, Number::Half, &[0], &zipped(&halves, true)), all);
    }

    #[test]
    fn a_chunk_that_unzips_to_more_or_fewer_bytes_is_refused() {
        for count in [7, 9, 100_000] {
            let chunk = [&[6][..], &zipped(&floats(&vec![1.0; count]), true)].concat();
            let active = Bytes::new(&ACTIVE).mask(8).unwrap();
            let (one, many) = (Number::Float, Number::Float);
            let encoding = Encoding { flags: ZIP, one, many, background: 0.0_f32 };
            assert!(encoding.values(&mut Bytes::new(&chunk), active, 8).is_err(), "{count}");
        }
    }
}
