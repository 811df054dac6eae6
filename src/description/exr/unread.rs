//! Valid EXR files that are not supported. In goes a file, out come the reason and a remedy. Invariant: the
//! reason is true, and no valid file is called damaged.

use super::raw;

/// Reason for a valid file that is not supported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unread {
    /// Unsupported feature, as the subject of a sentence.
    pub what: String,
    /// Way to convert the file to a supported one.
    pub remedy: String,
}

/// Compression methods that the decoder does not know, by number.
const COMPRESSIONS: [(u8, &str); 4] = [
    (10, "HTJ2K (htj2k256)"),
    (11, "HTJ2K (htj2k32)"),
    (12, "lossy JPEG 2000 (lj2k)"),
    (13, "Zstandard (zstd)"),
];
/// The last method that it knows.
const LAST_KNOWN: u8 = 9;

/// Whether some part of a file is deep.
pub(crate) fn is_deep(bytes: &[u8]) -> bool {
    raw::parts(bytes).is_some_and(|(parts, _)| parts.iter().any(raw::RawPart::is_deep))
}

impl Unread {
    /// Unsupported feature of a file; `None` if there is none, or the file is damaged.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        if is_deep(bytes) { Some(Self::of_deep("deep data")) } else { Self::of_codec(bytes) }
    }

    /// Reason for a file with deep parts beside flat ones.
    pub(crate) fn of_mixed(bytes: &[u8]) -> Option<Self> {
        let (parts, _) = raw::parts(bytes)?;
        let is_mixed = parts.iter().any(|part| part.is_deep() != parts[0].is_deep());
        is_mixed.then(|| Self::of_deep("deep parts beside flat ones"))
    }

    fn of_deep(what: &str) -> Self {
        Self { what: what.to_owned(), remedy: remedy("flatten it", "--flatten --compression zip") }
    }

    /// Reason for an unsupported compression.
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
