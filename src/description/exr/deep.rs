//! Deep EXR files, whose pixels have any number of samples, and which the decoder does not support. In goes
//! a file, out come its parts with a value a pixel: samples composited as by OpenEXR's
//! `CompositeDeepScanLine`. Invariant: memory is bounded by existing chunks and by the checked number of
//! pixels.
//! Layout: <https://openexr.com/en/latest/OpenEXRFileLayout.html#deep-data-file-layout>

use super::{raw, subsampled};
use ::exr::compression::Compression;
use ::exr::image::{AnyChannel, AnyChannels, FlatSamples};
use ::exr::io::Data;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{ChannelDescription, SampleType};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use half::f16;
use std::ops::Range;

/// Decodes and composites the channels of every part.
///
/// # Errors
/// With the reason if the file is damaged.
pub(crate) fn read(bytes: &[u8], meta: &MetaData) -> Result<Vec<AnyChannels<FlatSamples>>, String> {
    let tables = raw::tables(bytes, &meta.headers).ok_or("it ends within its table of chunks")?;
    let (mut read, mut packed) = (Vec::new(), 0_usize);
    for (number, (header, table)) in meta.headers.iter().zip(tables).enumerate() {
        let part = Part::of(header)?;
        let Vec2(width, height) = header.layer_size;
        let mut planes = vec![vec![0; width * height]; part.channels().len()];
        for offset in table {
            let number = meta.requirements.has_multiple_layers.then_some(number);
            let Some(chunk) = part.chunk(bytes, offset, number)? else { continue };
            // Chunks must not overlap, as a damaged table may name one of them many times.
            packed = packed.saturating_add(chunk.counts.len()).saturating_add(chunk.samples.len());
            if packed > bytes.len() {
                return Err(String::from("its chunks lie in one another"));
            }
            part.flatten(&chunk, &mut planes)?;
        }
        let channels = part.channels().iter().zip(planes).map(|(channel, plane)| {
            // All other types become floats.
            let samples = match channel.sample_type {
                SampleType::U32 => FlatSamples::U32(plane),
                _ => FlatSamples::F32(plane.into_iter().map(f32::from_bits).collect()),
            };
            AnyChannel::new(channel.name.clone(), samples)
        });
        read.push(AnyChannels::sort(channels.collect()));
    }
    Ok(read)
}

struct Part<'a> {
    header: &'a Header,
    /// Channels with the depths of a sample's front and back (Z, ZBack); without them samples keep the file's
    /// order.
    depth: Option<[usize; 2]>,
    /// Channel A; without it a sample is opaque.
    alpha: Option<usize>,
}

/// Pixels of a chunk, relative to the data window's corner, with their packed counts and samples.
struct Chunk<'a> {
    left: usize,
    top: usize,
    width: usize,
    height: usize,
    counts: &'a [u8],
    samples: &'a [u8],
    /// Bytes of the samples, unpacked.
    size: usize,
}

/// Number at the front of bytes, which move on.
fn next<T: Data>(bytes: &mut &[u8]) -> Result<T, String> {
    T::read_le(bytes).map_err(|_| String::from("it ends too early"))
}

impl<'a> Part<'a> {
    fn of(header: &'a Header) -> Result<Self, String> {
        let channels = &header.channels.list;
        if channels.is_empty() || channels.iter().any(|channel| channel.sampling != Vec2(1, 1)) {
            return Err(String::from("its list of channels is damaged"));
        }
        if !matches!(header.compression, Compression::Uncompressed | Compression::RLE | Compression::ZIP1) {
            return Err(String::from("deep data is compressed by none, RLE or ZIPS alone"));
        }
        let named = |name: &str| channels.iter().position(|channel| channel.name == *name);
        let depth = named("Z").map(|front| [front, named("ZBack").unwrap_or(front)]);
        Ok(Self { header, depth, alpha: named("A") })
    }

    fn channels(&self) -> &[ChannelDescription] {
        &self.header.channels.list
    }

    /// The chunk at a place of the file; `None` if it is of a coarser level. `number` is the part's in a
    /// multi-part file.
    fn chunk<'b>(
        &self,
        bytes: &'b [u8],
        offset: u64,
        number: Option<usize>,
    ) -> Result<Option<Chunk<'b>>, String> {
        let offset = usize::try_from(offset).unwrap_or(usize::MAX);
        let mut rest = bytes.get(offset..).ok_or("it ends too early")?;
        if let Some(number) = number
            && next::<u32>(&mut rest)? as usize != number
        {
            return Err(String::from("a chunk is of another part"));
        }
        let Vec2(width, height) = self.header.layer_size;
        let (corner, most) = match self.header.blocks {
            BlockDescription::ScanLines => {
                let top = i64::from(self.header.own_attributes.layer_position.1);
                (Vec2(0, i64::from(next::<i32>(&mut rest)?) - top), Vec2(width, 1))
            }
            BlockDescription::Tiles(tiles) => {
                let [column, row, level_x, level_y] = [(); 4].map(|()| next::<u32>(&mut rest).map(i64::from));
                if level_x? != 0 || level_y? != 0 {
                    return Ok(None);
                }
                let side = tiles.tile_size;
                (Vec2(column? * side.0 as i64, row? * side.1 as i64), side)
            }
        };
        let within = |at: i64, side: usize| usize::try_from(at).ok().filter(|&at| at < side);
        let left = within(corner.0, width).ok_or("a chunk lies elsewhere")?;
        let top = within(corner.1, height).ok_or("a chunk lies elsewhere")?;
        let sizes =
            [(); 3].map(|()| next::<u64>(&mut rest).map(|size| size.try_into().unwrap_or(usize::MAX)));
        let [of_counts, of_samples, size] = sizes;
        let (counts, rest) = rest.split_at_checked(of_counts?).ok_or("it ends too early")?;
        let samples = rest.get(..of_samples?).ok_or("it ends too early")?;
        let (width, height) = (most.0.min(width - left), most.1.min(height - top));
        Ok(Some(Chunk { left, top, width, height, counts, samples, size: size? }))
    }

    /// Composites a chunk's pixels into the planes: row by row, then by channel.
    fn flatten(&self, chunk: &Chunk, planes: &mut [Vec<u32>]) -> Result<(), String> {
        let (size, mut counts) = (4 * chunk.width * chunk.height, chunk.counts);
        // OpenEXR writes counts of whole tiles, also at the border, if they are not compressed.
        if self.header.compression == Compression::Uncompressed {
            counts = counts.get(..size).ok_or("a chunk is too short")?;
        }
        let counts = subsampled::unpacked(self.header, counts, size)?;
        let samples = subsampled::unpacked(self.header, chunk.samples, chunk.size)?;
        let (mut counts, mut samples) = (counts.as_slice(), samples.as_slice());
        for row in chunk.top..chunk.top + chunk.height {
            let mut ends = vec![0];
            for _ in 0..chunk.width {
                let end = next::<u32>(&mut counts)? as usize;
                if end < ends[ends.len() - 1] {
                    return Err(String::from("the counts of a chunk's samples are damaged"));
                }
                ends.push(end);
            }
            let mut values = Vec::with_capacity(planes.len());
            for channel in self.channels() {
                let size = ends[chunk.width].checked_mul(channel.sample_type.bytes_per_sample());
                let split = size.and_then(|size| samples.split_at_checked(size));
                let (own, behind) = split.ok_or("a chunk has fewer samples than it says")?;
                values.push((channel.sample_type, own));
                samples = behind;
            }
            let line = row * self.header.layer_size.0 + chunk.left;
            for (column, ends) in ends.windows(2).enumerate() {
                let value = |channel: usize, sample: usize| bits(values[channel], sample);
                for (plane, value) in planes.iter_mut().zip(self.composited(ends[0]..ends[1], value)) {
                    plane[line + column] = value;
                }
            }
        }
        Ok(())
    }

    /// Values of a pixel, in bits: its samples composited front to back; for integers the nearest sample's.
    fn composited(&self, samples: Range<usize>, value: impl Fn(usize, usize) -> u32) -> Vec<u32> {
        let number = |channel: usize, sample: usize| f32::from_bits(value(channel, sample));
        let mut order: Vec<usize> = samples.collect();
        if let Some(depth) = self.depth {
            let depths = |sample: usize| depth.map(|channel| number(channel, sample));
            order.sort_by(|&a, &b| {
                let ([near, far], [other_near, other_far]) = (depths(a), depths(b));
                near.total_cmp(&other_near).then(far.total_cmp(&other_far))
            });
        }
        let mut sums = vec![0.0_f32; self.channels().len()];
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
        let flat = |(channel, sum): (usize, f32)| match (self.channels()[channel].sample_type, order.first())
        {
            (SampleType::U32, Some(&nearest)) => value(channel, nearest),
            (SampleType::U32, None) => 0,
            _ => sum.to_bits(),
        };
        sums.into_iter().enumerate().map(flat).collect()
    }
}

/// Sample of a channel, in bits: those of a float, or an integer.
fn bits((kind, samples): (SampleType, &[u8]), sample: usize) -> u32 {
    if kind == SampleType::F16 {
        f16::from_le_bytes(samples.as_chunks().0[sample]).to_f32().to_bits()
    } else {
        u32::from_le_bytes(samples.as_chunks().0[sample])
    }
}
