//! Attributes of an EXR file's parts, parsed without the decoder. In go bytes, out come names and values,
//! also of files that the decoder refuses. Invariant: only files whose flags and type disagree are copied.
//! Layout: <https://openexr.com/en/latest/OpenEXRFileLayout.html>

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

/// An attribute as it is stored.
pub(crate) fn record((name, kind, value): (&[u8], &[u8], &[u8])) -> Vec<u8> {
    [name, &[0], kind, &[0], &(value.len() as u32).to_le_bytes(), value].concat()
}

/// Renames a `type` attribute that contradicts the flags. In a file of one part the flags have precedence,
/// and OpenEXR ignores the attribute.
pub(crate) fn of_the_kind_of_its_flags(bytes: &[u8]) -> Cow<'_, [u8]> {
    let as_it_is = Cow::Borrowed(bytes);
    let Some((parts, end)) = parts(bytes) else { return as_it_is };
    let kind = if bytes[5] & TILED != 0 { "tiledimage" } else { "scanlineimage" };
    let is_wrong = |part: &RawPart| part.text("type").is_some_and(|said| said != kind);
    if !matches!(&parts[..], [part] if !part.is_multipart && !part.has_deep_flag && is_wrong(part)) {
        return as_it_is;
    }
    let Some(at) = bytes[..end].windows(TYPE.len()).position(|part| part == TYPE) else { return as_it_is };
    let mut renamed = bytes.to_vec();
    renamed[at] = b'T';
    Cow::Owned(renamed)
}

/// Null-terminated text, and the bytes after it.
pub(super) fn text(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().take(256).position(|&byte| byte == 0)?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

impl RawPart<'_> {
    /// Value of an attribute of any type.
    pub(super) fn value(&self, name: &str) -> Option<&[u8]> {
        let found = self.attributes.iter().find(|(its_name, ..)| *its_name == name.as_bytes());
        found.map(|(.., value)| *value)
    }

    /// Value of a text attribute.
    pub(super) fn text(&self, name: &str) -> Option<String> {
        let found = self.attributes.iter().find(|(its_name, ..)| *its_name == name.as_bytes());
        let text = found.filter(|(_, kind, _)| *kind == b"string");
        text.map(|(.., value)| String::from_utf8_lossy(value).into_owned())
    }

    /// Compression method, as OpenEXR's number.
    pub(super) fn compression(&self) -> Option<u8> {
        self.value("compression")?.first().copied()
    }

    /// Whether the part is deep.
    pub(super) fn is_deep(&self) -> bool {
        match self.text("type") {
            Some(kind) if self.is_multipart => kind.starts_with("deep"),
            _ => self.has_deep_flag,
        }
    }

    /// Whether it is a cube map.
    pub(super) fn is_cube(&self) -> bool {
        self.value("envmap").and_then(|value| value.first()) == Some(&1)
    }

    /// x and y of red, green, blue and white.
    pub(super) fn chromaticities(&self) -> Option<[f32; 8]> {
        let value = self.value("chromaticities")?;
        let numbers = value.first_chunk::<32>()?.as_chunks::<4>().0;
        Some(std::array::from_fn(|index| f32::from_le_bytes(numbers[index])))
    }
}
