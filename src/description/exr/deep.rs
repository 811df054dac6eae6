//! Deep EXR files, whose pixels have any number of samples. In goes such a file, out comes a flat one:
//! samples composited as by OpenEXR's `CompositeDeepScanLine`. Invariant: memory is bounded by the contents
//! of existing chunks, and by pixels that the file's size allows.
//! Layout: <https://openexr.com/en/latest/OpenEXRFileLayout.html#deep-data-file-layout>

use super::Unread;
use super::raw::{self, RawPart};
use half::f16;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

/// Maximum bytes of pixels per byte of file. Deflate reaches at most 1032, so no valid file is refused.
pub(crate) const LARGEST_COMPRESSION: u64 = 4096;
/// Maximum bytes of pixels: an 8K picture with thirty float channels.
pub(crate) const LARGEST_PICTURE: u64 = 4 << 30;
/// Attributes of a header that are rewritten, or have no meaning in a flat part.
const OF_DEEP: [&[u8]; 8] = [
    b"channels",
    b"chunkCount",
    b"compression",
    b"lineOrder",
    b"maxSamplesPerPixel",
    b"tiles",
    b"type",
    b"version",
];
/// Bits of a file's flags: tiles, deep data.
const NOT_FLAT: u32 = 0x200 | 0x800;

/// Reason for a deep file that cannot be flattened.
pub(crate) enum Fault {
    /// The file is damaged.
    Damaged(String),
    /// The file is valid, but not supported.
    Unread(Unread),
}

impl From<&str> for Fault {
    fn from(reason: &str) -> Self {
        Self::Damaged(reason.to_owned())
    }
}

/// Flat file with a value a pixel and channel, uncompressed.
pub(crate) fn flattened(bytes: &[u8]) -> Result<Vec<u8>, Fault> {
    let (parts, mut table) = raw::parts(bytes).ok_or("the header is damaged")?;
    if !parts.iter().all(RawPart::is_deep) {
        return Err(Fault::Unread(Unread::of_deep("deep parts beside flat ones")));
    }
    let flags = u32_at(bytes, 4)?;
    let is_multipart = parts.len() > 1;
    let mut flat = [&bytes[..4], &(flags & !NOT_FLAT).to_le_bytes()].concat();
    let mut left = (bytes.len() as u64).saturating_mul(LARGEST_COMPRESSION).min(LARGEST_PICTURE);
    let (mut pictures, mut packed) = (Vec::new(), 0_usize);
    for (number, part) in parts.iter().enumerate() {
        let part = DeepPart::of(part, is_multipart.then_some(number))?;
        let size = (4 * part.channels.len() as u64).saturating_mul((part.width * part.height) as u64);
        left = left.checked_sub(size).ok_or("it claims more pixels than its size can hold")?;
        let chunks = part.chunks(bytes, &mut table)?;
        let mut picture = vec![[0; 4]; part.width * part.height * part.channels.len()];
        for chunk in chunks {
            // Chunks must not overlap, as a damaged table may name one of them many times.
            packed = packed.saturating_add(chunk.of_counts).saturating_add(chunk.of_samples);
            if packed > bytes.len() {
                return Err("its chunks lie in one another".into());
            }
            part.flatten(bytes, chunk, &mut picture)?;
        }
        part.write_header(&mut flat);
        pictures.push((part, picture));
    }
    if is_multipart {
        flat.push(0);
    }
    let lines: usize = pictures.iter().map(|(part, _)| part.height).sum();
    let mut chunk = (flat.len() + 8 * lines) as u64;
    for (part, _) in &pictures {
        let size = part.line_bytes() + 8 + if is_multipart { 4 } else { 0 };
        for _ in 0..part.height {
            flat.extend(chunk.to_le_bytes());
            chunk += size as u64;
        }
    }
    for (part, picture) in &pictures {
        for (row, line) in picture.chunks(part.width * part.channels.len()).enumerate() {
            if let Some(number) = part.number {
                flat.extend((number as u32).to_le_bytes());
            }
            flat.extend((part.top + row as i32).to_le_bytes());
            flat.extend((part.line_bytes() as u32).to_le_bytes());
            flat.extend(line.iter().flatten());
        }
    }
    Ok(flat)
}

fn array<const N: usize>(bytes: &[u8], at: usize) -> Result<[u8; N], Fault> {
    let found = bytes.get(at..).and_then(|rest| rest.first_chunk::<N>());
    found.copied().ok_or_else(|| "it ends too early".into())
}

fn u32_at(bytes: &[u8], at: usize) -> Result<u32, Fault> {
    array(bytes, at).map(u32::from_le_bytes)
}

fn size_at(bytes: &[u8], at: usize) -> Result<usize, Fault> {
    usize::try_from(u64::from_le_bytes(array(bytes, at)?)).map_err(|_| "a chunk is too large".into())
}

/// Channel of a part, with OpenEXR's number for its type.
struct Channel<'a> {
    name: &'a [u8],
    kind: u32,
}

impl Channel<'_> {
    const WHOLE: u32 = 0;
    const HALF: u32 = 1;

    fn bytes(&self) -> usize {
        if self.kind == Self::HALF { 2 } else { 4 }
    }
}

struct DeepPart<'a> {
    raw: &'a RawPart<'a>,
    /// Number of the part in a multi-part file.
    number: Option<usize>,
    channels: Vec<Channel<'a>>,
    top: i32,
    width: usize,
    height: usize,
    compression: u8,
    tile: Option<[usize; 2]>,
    /// Channels with the depths of a sample's front and back (Z, ZBack); without them samples keep the file's
    /// order.
    depth: Option<[usize; 2]>,
    /// Channel A; without it a sample is opaque.
    alpha: Option<usize>,
}

/// Pixels of a chunk, relative to the data window's corner, and its place in the file.
struct Chunk {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
    at: usize,
    /// Bytes of its counts and of its samples.
    of_counts: usize,
    of_samples: usize,
}

impl<'a> DeepPart<'a> {
    fn of(raw: &'a RawPart<'a>, number: Option<usize>) -> Result<Self, Fault> {
        let value = |name: &str| raw.value(name).ok_or("a header lacks an attribute");
        let mut channels = Vec::new();
        let mut rest = value("channels")?;
        while rest.first().is_some_and(|first| *first != 0) {
            let (name, behind) = raw::text(rest).ok_or("its list of channels is damaged")?;
            let (kind, sampling) = (u32_at(behind, 0)?, [u32_at(behind, 8)?, u32_at(behind, 12)?]);
            if kind > 2 || sampling != [1, 1] {
                return Err("its list of channels is damaged".into());
            }
            channels.push(Channel { name, kind });
            rest = &behind[16..];
        }
        let window = value("dataWindow")?;
        let [left, top, right, bottom] = [0, 4, 8, 12].map(|at| u32_at(window, at).map(|edge| edge as i32));
        let (left, top) = (left?, top?);
        let side = |from: i32, to: i32| usize::try_from(i64::from(to) - i64::from(from) + 1).ok();
        let (width, height) =
            side(left, right?).zip(side(top, bottom?)).ok_or("its data window is damaged")?;
        if width.max(height) > i32::MAX as usize / 4 || width == 0 || height == 0 {
            return Err("its data window is damaged".into());
        }
        let tile = match raw.value("tiles") {
            Some(tiles) => Some([u32_at(tiles, 0)?.max(1) as usize, u32_at(tiles, 4)?.max(1) as usize]),
            None => None,
        };
        let named = |name: &str| channels.iter().position(|channel| channel.name == name.as_bytes());
        let depth = named("Z").map(|front| [front, named("ZBack").unwrap_or(front)]);
        let alpha = named("A");
        let compression = *value("compression")?.first().ok_or("a header is damaged")?;
        Ok(Self { raw, number, channels, top, width, height, compression, tile, depth, alpha })
    }

    fn line_bytes(&self) -> usize {
        4 * self.width * self.channels.len()
    }

    /// Writes the header of the flat part.
    fn write_header(&self, flat: &mut Vec<u8>) {
        let mut write = |name: &[u8], kind: &[u8], value: &[u8]| {
            flat.extend(raw::record((name, kind, value)));
        };
        for (name, kind, value) in &self.raw.attributes {
            if !OF_DEEP.contains(name) {
                write(name, kind, value);
            }
        }
        let mut list = Vec::new();
        for channel in &self.channels {
            // All other types become floats.
            let kind = if channel.kind == Channel::WHOLE { 0_u32 } else { 2 };
            list.extend([channel.name, &[0]].concat());
            list.extend([kind, 0, 1, 1].map(u32::to_le_bytes).concat());
        }
        list.push(0);
        write(b"channels", b"chlist", &list);
        write(b"compression", b"compression", &[0]);
        write(b"lineOrder", b"lineOrder", &[0]);
        if self.number.is_some() {
            write(b"type", b"string", b"scanlineimage");
            write(b"chunkCount", b"int", &(self.height as u32).to_le_bytes());
        }
        flat.push(0);
    }

    /// Chunks of the finest level, from the offset table.
    fn chunks(&self, bytes: &[u8], table: &mut usize) -> Result<Vec<Chunk>, Fault> {
        let count = match (self.raw.value("chunkCount"), self.tile) {
            (Some(count), _) => u32_at(count, 0)? as usize,
            (None, None) => self.height,
            (None, Some(tile)) => self.width.div_ceil(tile[0]) * self.height.div_ceil(tile[1]),
        };
        let offsets = bytes.get(*table..).and_then(|rest| rest.get(..count.checked_mul(8)?));
        let offsets = offsets.ok_or("it ends within its table of chunks")?;
        *table += offsets.len();
        let mut chunks = Vec::new();
        for number in 0..count {
            let mut at = size_at(offsets, 8 * number)?;
            if let Some(part) = self.number {
                if u32_at(bytes, at)? as usize != part {
                    return Err("a chunk is of another part".into());
                }
                at += 4;
            }
            let place = |index: usize| Ok::<_, Fault>(u32_at(bytes, at + 4 * index)? as usize);
            let ([left, top], size, at) = match self.tile {
                None => {
                    let top = i64::from(u32_at(bytes, at)? as i32) - i64::from(self.top);
                    ([Some(0), usize::try_from(top).ok()], [self.width, 1], at + 4)
                }
                // A coarser level.
                Some(_) if place(2)? != 0 || place(3)? != 0 => continue,
                Some([width, height]) => {
                    let corner = [place(0)?.checked_mul(width), place(1)?.checked_mul(height)];
                    (corner, [width, height], at + 16)
                }
            };
            let left = left.filter(|&left| left < self.width).ok_or("a chunk lies elsewhere")?;
            let top = top.filter(|&top| top < self.height).ok_or("a chunk lies elsewhere")?;
            chunks.push(Chunk {
                left,
                top,
                width: size[0].min(self.width - left),
                height: size[1].min(self.height - top),
                at: at + 24,
                of_counts: size_at(bytes, at)?,
                of_samples: size_at(bytes, at + 8)?,
            });
        }
        Ok(chunks)
    }

    /// Composites a chunk's pixels into the picture: row by row, then by channel.
    fn flatten(&self, bytes: &[u8], chunk: Chunk, picture: &mut [[u8; 4]]) -> Result<(), Fault> {
        let unpacked = size_at(bytes, chunk.at - 8)?;
        let rest = bytes.get(chunk.at..).ok_or("it ends too early")?;
        let (counts, rest) = rest.split_at_checked(chunk.of_counts).ok_or("it ends too early")?;
        let samples = rest.get(..chunk.of_samples).ok_or("it ends too early")?;
        let counts = unpack(self.compression, counts, 4 * chunk.width * chunk.height)?;
        let samples = unpack(self.compression, samples, unpacked)?;
        let mut at = 0_usize;
        for row in 0..chunk.height {
            let mut ends = Vec::with_capacity(chunk.width);
            for column in 0..chunk.width {
                let end = u32_at(&counts, 4 * (row * chunk.width + column))? as usize;
                if end < ends.last().copied().unwrap_or(0) {
                    return Err("the counts of a chunk's samples are damaged".into());
                }
                ends.push(end);
            }
            let all = ends.last().copied().unwrap_or(0);
            let mut starts = Vec::with_capacity(self.channels.len());
            for channel in &self.channels {
                starts.push(at);
                at = all
                    .checked_mul(channel.bytes())
                    .and_then(|size| at.checked_add(size))
                    .unwrap_or(usize::MAX);
            }
            if at > samples.len() {
                return Err("a chunk has fewer samples than it says".into());
            }
            let value = |channel: usize, sample: usize| {
                let Channel { kind, .. } = self.channels[channel];
                let bytes = &samples[starts[channel] + sample * self.channels[channel].bytes()..];
                match kind {
                    Channel::HALF => f16::from_le_bytes([bytes[0], bytes[1]]).to_f32().to_le_bytes(),
                    _ => [bytes[0], bytes[1], bytes[2], bytes[3]],
                }
            };
            let line = (chunk.top + row) * self.width * self.channels.len() + chunk.left;
            let mut begin = 0;
            for (column, end) in ends.into_iter().enumerate() {
                for (channel, value) in self.composited(begin..end, value).into_iter().enumerate() {
                    picture[line + channel * self.width + column] = value;
                }
                begin = end;
            }
        }
        Ok(())
    }

    /// Values of a pixel: its samples composited front to back; for integers the nearest sample's.
    fn composited(
        &self,
        samples: std::ops::Range<usize>,
        value: impl Fn(usize, usize) -> [u8; 4],
    ) -> Vec<[u8; 4]> {
        let number = |channel: usize, sample: usize| f32::from_le_bytes(value(channel, sample));
        let mut order: Vec<usize> = samples.collect();
        if let Some(depth) = self.depth {
            let depths = |sample: usize| depth.map(|channel| number(channel, sample));
            order.sort_by(|&a, &b| {
                let ([near, far], [other_near, other_far]) = (depths(a), depths(b));
                near.total_cmp(&other_near).then(far.total_cmp(&other_far))
            });
        }
        let mut sums = vec![0.0_f32; self.channels.len()];
        for (number_in_front, &sample) in order.iter().enumerate() {
            let covered = self.alpha.map_or(number_in_front.min(1) as f32, |alpha| sums[alpha]);
            let left = 1.0 - covered;
            if left <= 0.0 {
                break;
            }
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum += left * number(channel, sample);
            }
        }
        let flat = |(channel, sum): (usize, f32)| match (self.channels[channel].kind, order.first()) {
            (Channel::WHOLE, Some(&nearest)) => value(channel, nearest),
            (Channel::WHOLE, None) => [0; 4],
            _ => sum.to_le_bytes(),
        };
        sums.into_iter().enumerate().map(flat).collect()
    }
}

/// Decompresses a chunk to `size` bytes. A chunk of that size is not compressed.
fn unpack(compression: u8, packed: &[u8], size: usize) -> Result<Vec<u8>, Fault> {
    const NONE: u8 = 0;
    const RLE: u8 = 1;
    const ZIPS: u8 = 2;
    if packed.len() == size || compression == NONE {
        return packed.get(..size).map(<[u8]>::to_vec).ok_or_else(|| "a chunk is too short".into());
    }
    let halves = match compression {
        RLE => run_lengths(packed, size),
        ZIPS => decompress_to_vec_zlib_with_limit(packed, size).ok(),
        _ => return Err("deep data is compressed by none, RLE or ZIPS alone".into()),
    };
    let mut halves = halves.filter(|halves| halves.len() == size).ok_or("a chunk cannot be unpacked")?;
    // Each byte is a difference from its predecessor, and bytes at even places come before the others.
    for at in 1..size {
        halves[at] = halves[at - 1].wrapping_add(halves[at]).wrapping_sub(128);
    }
    let odd = size.div_ceil(2);
    Ok((0..size).map(|at| halves[if at % 2 == 0 { at / 2 } else { odd + at / 2 }]).collect())
}

/// Run-length decoding: a negative count precedes as many literal bytes, any other count one byte, repeated
/// once more than the count.
fn run_lengths(mut packed: &[u8], size: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    while let Some((&count, rest)) = packed.split_first() {
        if count >= 128 {
            let (run, rest) = rest.split_at_checked(usize::from(count.wrapping_neg()))?;
            bytes.extend(run);
            packed = rest;
        } else {
            let (&byte, rest) = rest.split_first()?;
            bytes.resize(bytes.len() + usize::from(count) + 1, byte);
            packed = rest;
        }
        if bytes.len() > size {
            return None;
        }
    }
    Some(bytes)
}
