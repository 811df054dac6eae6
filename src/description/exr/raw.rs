//! Attributes of an EXR file's parts, parsed without the decoder. In go bytes, out come names and values,
//! also of files that the decoder refuses. Invariant: only files whose flags and type disagree are copied.
//! Layout: <https://openexr.com/en/latest/OpenEXRFileLayout.html>

use ::exr::io::PeekRead;
use ::exr::meta::{Headers, MetaData, OffsetTables};
use std::borrow::Cow;

/// Magic number and version.
pub(crate) const PREAMBLE: usize = 8;
const MULTIPART: u8 = 0x10;
const DEEP: u8 = 0x08;
const TILED: u8 = 0x02;
/// An attribute's name and type.
const TYPE: &[u8] = b"type\0string\0";

pub(crate) struct RawPart<'a> {
    /// Name, type and value.
    pub(crate) attributes: Vec<(&'a [u8], &'a [u8], &'a [u8])>,
    is_multipart: bool,
    has_deep_flag: bool,
}

/// Parts of a file, and the position of their offset tables; `None` if the file is damaged or not EXR.
pub(crate) fn parts(bytes: &[u8]) -> Option<(Vec<RawPart<'_>>, usize)> {
    let flags = *bytes.get(5)?;
    let is_multipart = flags & MULTIPART != 0;
    let mut rest = bytes.get(PREAMBLE..)?;
    let mut parts = Vec::new();
    loop {
        let mut attributes = Vec::new();
        while *rest.first()? != 0 {
            let (name, behind) = text(rest)?;
            let (kind, behind) = text(behind)?;
            let size = u32::from_le_bytes(behind.get(..4)?.try_into().ok()?);
            let (value, behind) = behind.get(4..)?.split_at_checked(usize::try_from(size).ok()?)?;
            attributes.push((name, kind, value));
            rest = behind;
        }
        rest = &rest[1..];
        // An empty header ends the list.
        let is_end = attributes.is_empty() && !parts.is_empty();
        if !is_end {
            parts.push(RawPart { attributes, is_multipart, has_deep_flag: flags & DEEP != 0 });
        }
        if is_end || !is_multipart {
            return Some((parts, bytes.len() - rest.len()));
        }
    }
}

/// Places of every part's chunks; `None` if the file ends before.
pub(super) fn tables(bytes: &[u8], headers: &Headers) -> Option<OffsetTables> {
    let (parts, end) = parts(bytes)?;
    let tables = MetaData::read_offset_tables(&mut PeekRead::new(bytes.get(end..)?), headers);
    tables.ok().filter(|_| parts.len() == headers.len())
}

/// An attribute as it is stored.
pub(crate) fn record((name, kind, value): (&[u8], &[u8], &[u8])) -> Vec<u8> {
    [name, &[0], kind, &[0], &(value.len() as u32).to_le_bytes(), value].concat()
}

/// Renames a `type` attribute that contradicts the flags. In a file of one part the flags have precedence,
/// and OpenEXR ignores the attribute.
pub(crate) fn of_the_kind_of_its_flags(bytes: &[u8]) -> Cow<'_, [u8]> {
    let as_it_is = Cow::Borrowed(bytes);
    let Some((parts, end)) = parts(bytes) else { return as_it_is };
    let kind: &[u8] = if bytes[5] & TILED != 0 { b"tiledimage" } else { b"scanlineimage" };
    let is_wrong = |part: &RawPart| part.kind().is_some_and(|said| said != kind);
    if !matches!(&parts[..], [part] if !part.is_multipart && !part.has_deep_flag && is_wrong(part)) {
        return as_it_is;
    }
    let Some(at) = bytes[..end].windows(TYPE.len()).position(|part| part == TYPE) else { return as_it_is };
    let mut renamed = bytes.to_vec();
    renamed[at] = b'T';
    Cow::Owned(renamed)
}

/// Null-terminated text, and the bytes after it.
fn text(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().take(256).position(|&byte| byte == 0)?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

impl RawPart<'_> {
    fn attribute(&self, name: &[u8]) -> Option<&(&[u8], &[u8], &[u8])> {
        self.attributes.iter().find(|attribute| attribute.0 == name)
    }

    /// What its `type` says.
    fn kind(&self) -> Option<&[u8]> {
        self.attribute(b"type").filter(|(_, kind, _)| *kind == b"string").map(|(.., value)| *value)
    }

    /// Compression method, as OpenEXR's number.
    pub(super) fn compression(&self) -> Option<u8> {
        self.attribute(b"compression")?.2.first().copied()
    }

    /// Whether the part is deep.
    pub(super) fn is_deep(&self) -> bool {
        match self.kind() {
            Some(kind) if self.is_multipart => kind.starts_with(b"deep"),
            _ => self.has_deep_flag,
        }
    }
}
