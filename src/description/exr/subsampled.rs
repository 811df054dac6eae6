//! EXR files with subsampled channels, such as chroma, which the decoder does not support. In goes a file,
//! out come its parts with a value a pixel, by repeating samples. Invariant: memory is bounded by existing
//! chunks and by the checked number of pixels.

use super::{LARGEST_COMPRESSION, raw};
use ::exr::compression::Compression;
use ::exr::image::{AnyChannel, AnyChannels, FlatSamples};
use ::exr::math::Vec2;
use ::exr::meta::attribute::{ChannelDescription, IntegerBounds, SampleType};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use half::f16;

/// Maximum bytes of a decompressed chunk: the decoder takes fewer than 2^30 - 1 pixels, here of two bytes.
const LARGEST_CHUNK: u64 = (1 << 31) - 4;

/// Whether a file has a subsampled channel.
pub(crate) fn is_subsampled(headers: &[Header]) -> bool {
    headers.iter().any(|header| header.channels.list.iter().any(|channel| channel.sampling != Vec2(1, 1)))
}

/// Decodes the channels of every part.
///
/// # Errors
/// With the reason if the file is damaged, or has tiles as well.
pub(crate) fn read(bytes: &[u8], meta: &MetaData) -> Result<Vec<AnyChannels<FlatSamples>>, String> {
    let tables = raw::tables(bytes, &meta.headers).ok_or("the file ends within its table of chunks")?;
    let is_multipart = meta.requirements.has_multiple_layers;
    let mut read = Vec::new();
    for (number, (header, table)) in meta.headers.iter().zip(tables).enumerate() {
        if header.blocks != BlockDescription::ScanLines || header.deep {
            return Err(String::from("tiles beside channels that have fewer samples than the picture"));
        }
        if header.channels.list.iter().any(|channel| channel.sampling.0.min(channel.sampling.1) == 0) {
            return Err(String::from("a channel has a sample every 0 pixels"));
        }
        let mut planes: Vec<Plane> =
            header.channels.list.iter().map(|channel| Plane::new(channel, header)).collect();
        for offset in table {
            let chunk =
                Chunk::at(bytes, offset, is_multipart.then_some(number)).ok_or("a chunk is damaged")?;
            chunk.decode(header, &mut planes)?;
        }
        let channels = planes.into_iter().zip(&header.channels.list);
        read.push(AnyChannels::sort(channels.map(|(plane, channel)| plane.whole(channel, header)).collect()));
    }
    Ok(read)
}

/// Samples of a channel, as stored.
struct Plane {
    columns: usize,
    bytes: Vec<u8>,
}

impl Plane {
    fn new(channel: &ChannelDescription, header: &Header) -> Self {
        let Vec2(width, height) = header.layer_size;
        let (columns, rows) = (width.div_ceil(channel.sampling.0), height.div_ceil(channel.sampling.1));
        Self { columns, bytes: vec![0; columns * rows * channel.sample_type.bytes_per_sample()] }
    }

    /// Channel at full resolution.
    fn whole(self, channel: &ChannelDescription, header: &Header) -> AnyChannel<FlatSamples> {
        let samples = match channel.sample_type {
            SampleType::F16 => FlatSamples::F16(self.repeated(channel, header, f16::from_ne_bytes)),
            SampleType::F32 => FlatSamples::F32(self.repeated(channel, header, f32::from_ne_bytes)),
            SampleType::U32 => FlatSamples::U32(self.repeated(channel, header, u32::from_ne_bytes)),
        };
        AnyChannel::new(channel.name.clone(), samples)
    }

    fn repeated<T: Copy, const N: usize>(
        &self,
        channel: &ChannelDescription,
        header: &Header,
        value: impl Fn([u8; N]) -> T,
    ) -> Vec<T> {
        let (Vec2(width, height), Vec2(across, down)) = (header.layer_size, channel.sampling);
        let sample = |x: usize, y: usize| {
            let at = N * (y / down * self.columns + x / across);
            let mut bytes = [0; N];
            bytes.copy_from_slice(&self.bytes[at..at + N]);
            value(bytes)
        };
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| sample(x, y)).collect()
    }
}

/// Rows that are stored together.
struct Chunk<'a> {
    y: i32,
    data: &'a [u8],
}

impl<'a> Chunk<'a> {
    fn at(bytes: &'a [u8], offset: u64, part: Option<usize>) -> Option<Self> {
        let mut rest = bytes.get(usize::try_from(offset).ok()?..)?;
        let mut number = || {
            let (number, behind) = rest.split_first_chunk::<4>()?;
            rest = behind;
            Some(i32::from_le_bytes(*number))
        };
        if let Some(part) = part
            && usize::try_from(number()?).ok()? != part
        {
            return None;
        }
        let (y, size) = (number()?, number()?);
        Some(Self { y, data: rest.get(..usize::try_from(size).ok()?)? })
    }

    /// Decodes the chunk into the planes.
    fn decode(&self, header: &Header, planes: &mut [Plane]) -> Result<(), String> {
        let Vec2(width, height) = header.layer_size;
        let top = i64::from(self.y) - i64::from(header.own_attributes.layer_position.1);
        let top = usize::try_from(top).ok().filter(|&top| top < height).ok_or("a chunk lies elsewhere")?;
        let rows = header.compression.scan_lines_per_block().min(height - top);
        if matches!(header.compression, Compression::B44 | Compression::B44A) {
            return self.decode_b44(header, (top, rows), planes);
        }
        // Whether the chunk has samples of a channel in a row: the file has every n-th row.
        let has = |channel: &ChannelDescription, row: usize| (top + row).is_multiple_of(channel.sampling.1);
        let list = &header.channels.list;
        let row_bytes = |channel: &ChannelDescription| {
            width.div_ceil(channel.sampling.0) * channel.sample_type.bytes_per_sample()
        };
        let size: usize = (0..rows)
            .flat_map(|row| list.iter().filter(move |channel| has(channel, row)))
            .map(row_bytes)
            .sum();
        let data = self.decompressed(header, (top, rows), size)?;
        let mut rest = data.get(..size).ok_or("a chunk is too short")?;
        for row in 0..rows {
            for (channel, plane) in
                list.iter().zip(planes.iter_mut()).filter(|(channel, _)| has(channel, row))
            {
                let (line, behind) = rest.split_at(row_bytes(channel));
                rest = behind;
                let at = (top + row) / channel.sampling.1 * line.len();
                plane.bytes[at..at + line.len()].copy_from_slice(line);
            }
        }
        Ok(())
    }

    /// Decodes channels one after the other, each in blocks of 4x4 samples: 3 bytes for a constant block,
    /// else 14. The decoder gets each as a channel at full resolution.
    fn decode_b44(
        &self,
        header: &Header,
        (top, rows): (usize, usize),
        planes: &mut [Plane],
    ) -> Result<(), String> {
        const FLAT: u8 = 13 << 2;
        let mut at = 0;
        for (channel, plane) in header.channels.list.iter().zip(planes) {
            let row_bytes = plane.columns * channel.sample_type.bytes_per_sample();
            let lines = (top..top + rows).filter(|row| row % channel.sampling.1 == 0).count();
            let begin = top.div_ceil(channel.sampling.1) * row_bytes;
            let size = lines * row_bytes;
            let target = plane.bytes.get_mut(begin..begin + size).ok_or("a chunk is too long")?;
            let start = at;
            if channel.sample_type == SampleType::F16 {
                for _ in 0..plane.columns.div_ceil(4) * lines.div_ceil(4) {
                    at += if *self.data.get(at + 2).ok_or("a chunk is too short")? >= FLAT { 3 } else { 14 };
                }
            } else {
                at += size;
            }
            let mut piece = self.data.get(start..at).ok_or("a chunk is too short")?.to_vec();
            if size == 0 {
                continue;
            }
            // The decoder would take a piece of this size for uncompressed samples; bytes after it are
            // ignored.
            if channel.sample_type == SampleType::F16 && piece.len() == size {
                piece.push(0);
            }
            let mut alone = header.clone();
            alone.channels.list = std::iter::once(channel.clone()).collect();
            alone.channels.list[0].sampling = Vec2(1, 1);
            alone.channels.bytes_per_pixel = channel.sample_type.bytes_per_sample();
            alone.layer_size = Vec2(plane.columns, lines);
            let section = IntegerBounds::new((0, 0), (plane.columns, lines));
            let data = header.compression.decompress_image_section_from_le(&alone, piece, section, false);
            let data = data.map_err(|error| error.to_string())?;
            target.copy_from_slice(data.get(..size).ok_or("a chunk is too short")?);
        }
        Ok(())
    }

    /// Decompresses to `size` bytes in native order, by a part of that size for the decoder.
    fn decompressed(
        &self,
        header: &Header,
        (top, rows): (usize, usize),
        size: usize,
    ) -> Result<Vec<u8>, String> {
        if size == 0 {
            return Ok(Vec::new());
        }
        if self.data.len() == size && cfg!(target_endian = "little") {
            return Ok(self.data.to_vec());
        }
        let mut header = header.clone();
        let section = match header.compression {
            Compression::Uncompressed | Compression::RLE | Compression::ZIP1 | Compression::ZIP16 => {
                return unpacked(&header, self.data, size);
            }
            Compression::PIZ => {
                let area = header.layer_size.0 * rows;
                if !size.is_multiple_of(area) {
                    return Err(String::from(
                        "channels that have fewer samples than the picture, in this size",
                    ));
                }
                header.channels.bytes_per_pixel = size / area;
                let y = header.own_attributes.layer_position.1 + top as i32;
                IntegerBounds::new((header.own_attributes.layer_position.0, y), (header.layer_size.0, rows))
            }
            other => {
                return Err(format!(
                    "channels that have fewer samples than the picture, compressed as {other}"
                ));
            }
        };
        let compression = header.compression;
        let data = compression.decompress_image_section_from_le(&header, self.data.to_vec(), section, false);
        data.map_err(|error| error.to_string())
    }
}

/// Decompresses any samples to `size` bytes, by a part of that many for the decoder. A chunk of that size is
/// not compressed.
pub(super) fn unpacked(header: &Header, packed: &[u8], size: usize) -> Result<Vec<u8>, String> {
    if packed.len() == size {
        return Ok(packed.to_vec());
    }
    if size == 0 || size as u64 > (packed.len() as u64).saturating_mul(LARGEST_COMPRESSION).min(LARGEST_CHUNK)
    {
        return Err(String::from("a chunk cannot be unpacked"));
    }
    // A channel of bytes, of the right number.
    let mut header = header.clone();
    header.deep = false;
    header.blocks = BlockDescription::ScanLines;
    header.channels.list.truncate(1);
    header.channels.list[0].sample_type = SampleType::F16;
    header.channels.list[0].sampling = Vec2(1, 1);
    header.channels.bytes_per_pixel = 2;
    header.layer_size = Vec2(size / 2, 1);
    let section = IntegerBounds::new((0, 0), (size / 2, 1));
    let data = header.compression.decompress_image_section_from_le(&header, packed.to_vec(), section, false);
    data.map_err(|error| error.to_string())
}
