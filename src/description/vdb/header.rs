//! Header of a file: its version, and each grid's name, type and offset. In go bytes, out come entries.
//! Invariant: every entry ends after it begins, so reading ends. Source: `openvdb/io/Archive.cc` and
//! `GridDescriptor.cc`.

use super::bytes::{Bytes, Read};

const MAGIC: &[u8] = b" BDV\0\0\0\0";
/// Supported versions, from the first with compression for each grid (OpenVDB 3) to that of Blender 5.3.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
const HALF: &str = "_HalfFloat";
/// Separator between a grid's name and its number, where several have one name.
const NUMBERED: char = '\x1e';

/// Directory entry of a grid.
pub(super) struct Entry {
    pub(super) name: String,
    /// Type, such as `Tree_float_5_4_3`.
    pub(super) kind: String,
    pub(super) is_half: bool,
    /// Name of the grid that shares its tree; empty if it has its own.
    pub(super) parent: String,
    /// Offset from the file's start in bytes.
    pub(super) start: i64,
}

/// Reads the entries of a file's grids, in order.
pub(super) fn read(bytes: &mut Bytes) -> Read<Vec<Entry>> {
    if bytes.take(MAGIC.len())? != MAGIC {
        return Err(bytes.fault("the first bytes are not those of an OpenVDB file"));
    }
    let version = bytes.u32()?;
    if !VERSIONS.contains(&version) {
        let (oldest, newest) = (VERSIONS.start(), VERSIONS.end());
        return Err(bytes.fault(format!("file version {version}, of which {oldest} to {newest} are read")));
    }
    let _library = (bytes.u32()?, bytes.u32()?);
    let has_places = bytes.u8()? != 0;
    let _identifier = bytes.take(36)?;
    is_staggered(bytes)?;
    if !has_places {
        return Err(bytes.fault("it was written as a stream, without the places of its grids"));
    }
    let count = bytes.u32()?;
    (0..count).map(|_| entry(bytes)).collect()
}

fn entry(bytes: &mut Bytes) -> Read<Entry> {
    let (name, kind, parent) = (bytes.text()?, bytes.text()?, bytes.text()?);
    let (start, _values, end) = (bytes.i64()?, bytes.i64()?, bytes.i64()?);
    // The next entry has to lie behind this one, so that the loop ends.
    if end < bytes.place() {
        return Err(bytes.fault("a grid ends before it begins"));
    }
    *bytes = bytes.from(end)?;
    let name = name.split(NUMBERED).next().unwrap_or_default().to_owned();
    let is_half = kind.ends_with(HALF);
    Ok(Entry { name, kind: kind.trim_end_matches(HALF).to_owned(), is_half, parent, start })
}

/// Skips names, types and values of metadata. Returns whether vectors are staggered: each component then
/// belongs to a face of its voxel.
pub(super) fn is_staggered(bytes: &mut Bytes) -> Read<bool> {
    let mut is_staggered = false;
    for _ in 0..bytes.u32()? {
        let (name, _kind, size) = (bytes.text()?, bytes.text()?, bytes.u32()?);
        is_staggered |= bytes.take(size as usize)? == b"staggered" && name == "class";
    }
    Ok(is_staggered)
}
