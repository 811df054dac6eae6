//! Header of a file, before the trees: its version, and each grid's name, type and place. Source:
//! `openvdb/io/Archive.cc` and `GridDescriptor.cc`.

use super::bytes::{Bytes, Read};

const MAGIC: &[u8] = b" BDV\0\0\0\0";
/// Versions from the first with compression for each grid (OpenVDB 3) to that of Blender 5.3.
const VERSIONS: std::ops::RangeInclusive<u32> = 222..=225;
const HALF: &str = "_HalfFloat";
/// Stands between a grid's name and a number, where several have one name.
const NUMBERED: char = '\x1e';

/// A grid, as the file's directory has it.
pub(super) struct Entry {
    pub(super) name: String,
    /// Such as `Tree_float_5_4_3`.
    pub(super) kind: String,
    pub(super) is_half: bool,
    /// Name of the grid whose tree it has too; empty if it has its own.
    pub(super) parent: String,
    /// Bytes from the file's start.
    pub(super) start: i64,
}

/// The grids of a file, in its order.
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
    // The next entry stands behind the grid: further on, so that entries end with the file.
    if end < bytes.place() {
        return Err(bytes.fault("a grid ends before it begins"));
    }
    *bytes = bytes.from(end)?;
    let name = name.split(NUMBERED).next().unwrap_or_default().to_owned();
    let is_half = kind.ends_with(HALF);
    Ok(Entry { name, kind: kind.trim_end_matches(HALF).to_owned(), is_half, parent, start })
}

/// Passes names, types and values of metadata. Out comes whether they say that vectors are staggered: each
/// number is of its voxel's face.
pub(super) fn is_staggered(bytes: &mut Bytes) -> Read<bool> {
    let mut is_staggered = false;
    for _ in 0..bytes.u32()? {
        let (name, _kind, size) = (bytes.text()?, bytes.text()?, bytes.u32()?);
        is_staggered |= bytes.take(size as usize)? == b"staggered" && name == "class";
    }
    Ok(is_staggered)
}
