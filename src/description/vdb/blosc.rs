//! Blosc 1 with LZ4, as OpenVDB writes it. In goes a chunk, out come its bytes. Invariant: at most the
//! expected size is allocated. Layout: <https://github.com/Blosc/c-blosc/blob/main/README_CHUNK_FORMAT.rst>

use super::bytes::{Bytes, Read};

const SHUFFLED: u8 = 0x01;
const COPIED: u8 = 0x02;
const BITS_SHUFFLED: u8 = 0x04;
const NOT_SPLIT: u8 = 0x10;
const LZ4: u8 = 1;

/// Maximum number of splits, from c-blosc's `blosc.c`: values of more bytes, or blocks of fewer values,
/// are not split.
const MOST_SPLITS: usize = 16;
const LEAST_VALUES_OF_A_SPLIT: usize = 128;

struct Header {
    flags: u8,
    /// Bytes a value.
    stride: usize,
    block: usize,
}

/// Decompresses a chunk to `size` bytes.
pub(super) fn decompress(chunk: &[u8], size: usize) -> Read<Vec<u8>> {
    let mut bytes = Bytes::new(chunk);
    let (_version, _codec_version) = (bytes.u8()?, bytes.u8()?);
    let (flags, stride) = (bytes.u8()?, usize::from(bytes.u8()?));
    let (found, block, _compressed) = (bytes.u32()? as usize, bytes.u32()? as usize, bytes.u32()?);
    if found != size {
        return Err(bytes.fault(format!("a chunk of {found} bytes stands where {size} are expected")));
    }
    if flags & COPIED != 0 {
        return bytes.take(size).map(<[u8]>::to_vec);
    }
    if flags >> 5 != LZ4 || flags & BITS_SHUFFLED != 0 || stride == 0 || block == 0 {
        return Err(bytes.fault("its chunks are not compressed as OpenVDB does it, by Blosc with LZ4"));
    }
    let header = Header { flags, stride, block };
    let mut values = Vec::with_capacity(size);
    while values.len() < size {
        let start = i64::from(bytes.u32()?);
        let length = block.min(size - values.len());
        header.decompress_block(bytes.from(start)?, length, &mut values)?;
    }
    Ok(values)
}

impl Header {
    fn decompress_block(&self, mut bytes: Bytes, length: usize, out: &mut Vec<u8>) -> Read<()> {
        let is_split = self.flags & NOT_SPLIT == 0
            && self.stride <= MOST_SPLITS
            && self.block / self.stride >= LEAST_VALUES_OF_A_SPLIT
            && length == self.block;
        let parts = if is_split { self.stride } else { 1 };
        let part = length / parts;
        let mut block = vec![0; part * parts];
        for target in block.chunks_exact_mut(part) {
            let compressed = bytes.u32()? as usize;
            let source = bytes.take(compressed)?;
            if compressed == part {
                target.copy_from_slice(source);
            } else if lz4_flex::block::decompress_into(source, target).ok() != Some(part) {
                return Err(bytes.fault("a chunk cannot be decompressed"));
            }
        }
        if self.flags & SHUFFLED != 0 && self.stride > 1 {
            block = unshuffled(&block, self.stride);
        }
        block.resize(length, 0);
        out.append(&mut block);
        Ok(())
    }
}

/// Inverse of the shuffle, which stores the first bytes of all values, then the second ones, and so on.
fn unshuffled(block: &[u8], stride: usize) -> Vec<u8> {
    let count = block.len() / stride;
    let values = (0..count * stride).map(|at| block[at % stride * count + at / stride]);
    values.chain(block[count * stride..].iter().copied()).collect()
}
