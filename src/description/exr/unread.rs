//! EXR files that are whole and not read. In goes a file, out comes why, and what helps. Invariant: the
//! reason is true of the file: no such file is called damaged.

use super::raw;

/// Why a file is not read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Feature that is not read, as the subject of a sentence.
    pub what: String,
    /// Way to make a file of it that is read.
    pub remedy: String,
}

/// Compressions by number that the decoder does not know.
const COMPRESSIONS: [(u8, &str); 4] = [
    (10, "HTJ2K (htj2k256)"),
    (11, "HTJ2K (htj2k32)"),
    (12, "lossy JPEG 2000 (lj2k)"),
    (13, "Zstandard (zstd)"),
];
/// The last that it knows.
const LAST_KNOWN: u8 = 9;

/// Whether some part of a file is deep.
pub(crate) fn is_deep(bytes: &[u8]) -> bool {
    raw::parts(bytes).is_some_and(|(parts, _)| parts.iter().any(raw::RawPart::is_deep))
}

impl Unread {
    /// Feature of a file that is not read; `None` if nothing stands in the way, or it is damaged.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        if is_deep(bytes) { Some(Self::of_deep("deep data")) } else { Self::of_codec(bytes) }
    }

    /// Refusal of deep data.
    pub(super) fn of_deep(what: &str) -> Self {
        Self { what: what.to_owned(), remedy: remedy("flatten it", "--flatten --compression zip") }
    }

    /// Compression of a file, if it is not read.
    pub fn of_codec(bytes: &[u8]) -> Option<Self> {
        let (parts, _) = raw::parts(bytes)?;
        let codec = parts.iter().filter_map(raw::RawPart::compression).find(|codec| *codec > LAST_KNOWN)?;
        let name = COMPRESSIONS.iter().find(|(number, _)| *number == codec);
        let name = name.map_or_else(|| format!("number {codec}"), |(_, name)| String::from(*name));
        Some(Self {
            what: format!("the compression {name}"),
            remedy: remedy("save it with ZIP compression", "-a --compression zip"),
        })
    }
}

fn remedy(what: &str, flags: &str) -> String {
    format!("{what}: `oiiotool IN.exr {flags} -o OUT.exr` does (`pip install OpenImageIO`)")
}
