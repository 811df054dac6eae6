//! Buffers and views: from the binary chunk, data URIs and files, decompressed where needed. In go indices,
//! out come bytes. Invariant: a returned view lies inside its buffer. A missing buffer is an error for each
//! of its users.

use super::json::{self, Document};
use super::meshopt;
use super::report::Report;
use super::{Files, LoadError, invalid};
use crate::description::files;
use crate::diagnostic::{Diagnostic, Loss, readable, shown};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub(super) struct Buffers<'a> {
    file: &'a Path,
    document: &'a Document,
    /// `None` if the buffer is missing, which is reported already.
    buffers: Vec<Option<Cow<'a, [u8]>>>,
    /// Decompressed views by index, or their errors.
    unpacked: BTreeMap<usize, Result<Vec<u8>, Diagnostic>>,
    /// Error of the first file that could not be read.
    pub(super) missing: Option<LoadError>,
}

/// Loads every buffer that a view refers to.
pub(super) fn load<'a>(
    document: &'a Document,
    binary: Option<&'a [u8]>,
    file: &'a Path,
    files: &mut Files,
    report: &mut Report,
) -> Buffers<'a> {
    let mut needed = vec![false; document.buffers.len()];
    for view in &document.buffer_views {
        // The fallback of a compressed view may be missing.
        let buffer = view.extensions.meshopt.as_ref().map_or(view.buffer, |packed| packed.buffer);
        if let Some(needed) = needed.get_mut(buffer) {
            *needed = true;
        }
    }
    let mut missing = None;
    let mut buffers = Vec::with_capacity(document.buffers.len());
    for (index, buffer) in document.buffers.iter().enumerate() {
        if !needed[index] {
            buffers.push(None);
            continue;
        }
        let path = format!("buffers[{index}]");
        let bytes = match (&buffer.uri, binary) {
            (Some(uri), _) => {
                let referrer = format!("{}: {path}.uri", file.display());
                match fetch(uri, file, files, &referrer) {
                    Ok(bytes) => bytes.map_err(|found| invalid(file, format!("{path}.uri"), found)),
                    Err(error) => {
                        let damage = unreadable(&error, file, &format!("{path}.uri"));
                        missing = missing.or(Some(error));
                        Err(damage)
                    }
                }
            }
            (None, Some(binary)) if index == 0 => Ok(Cow::Borrowed(binary)),
            (None, _) => {
                Err(invalid(file, path.as_str(), "the buffer has no data: no URI and no binary chunk"))
            }
        };
        if let Some(short) =
            bytes.as_ref().ok().map(|bytes| bytes.len()).filter(|len| *len < buffer.byte_length)
        {
            let found = format!("the buffer is to have {} bytes and has {short}", buffer.byte_length);
            let damage = invalid(file, format!("{path}.byteLength"), found)
                .expected("a buffer of that length")
                .remedy("export or copy the file again; it is cut short");
            report.leave_out(Loss::BufferUnreadable, damage);
        }
        buffers.push(report.spare(Loss::BufferUnreadable, bytes));
    }
    let mut buffers = Buffers { file, document, buffers, unpacked: BTreeMap::new(), missing };
    let unpack = |(index, view): (usize, &json::BufferView)| {
        let packed = view.extensions.meshopt.as_ref()?;
        Some((index, buffers.unpack(packed, &format!("bufferViews[{index}]"))))
    };
    buffers.unpacked = document.buffer_views.iter().enumerate().filter_map(unpack).collect();
    buffers
}

/// Diagnostic of a file that cannot be read, at the path that refers to it.
pub(super) fn unreadable(error: &LoadError, file: &Path, path: &str) -> Diagnostic {
    let found = match error {
        LoadError::Io { path, source, .. } => {
            format!("{} cannot be read: {source}", shown(&readable(path)))
        }
        LoadError::Invalid(diagnostics) => diagnostics.to_string(),
    };
    invalid(file, path, found).remedy("put the file where this one names it, or pack it in (as .glb)")
}

/// Bytes of a URI: a data URI's, or those of a file beside the glTF file.
pub(super) fn fetch<'a>(
    uri: &str,
    file: &Path,
    files: &mut Files,
    referrer: &str,
) -> Result<Result<Cow<'a, [u8]>, String>, LoadError> {
    if let Some(data) = uri.strip_prefix("data:") {
        return Ok(data_uri(data).map(Cow::Owned));
    }
    match file_beside(uri, file) {
        Ok(path) => files.read(&path, Some(referrer)).map(|bytes| Ok(Cow::Owned(bytes))),
        Err(found) => Ok(Err(found)),
    }
}

/// Path of the file that a URI refers to. Text that is not a URI counts as a file name.
pub(super) fn file_beside(uri: &str, file: &Path) -> Result<PathBuf, String> {
    let name = percent_decoded(uri).unwrap_or_else(|| uri.to_owned());
    let has_root = name.starts_with(['/', '\\']);
    if uri.contains("://") || uri.starts_with("data:") || has_root || Path::new(&name).has_root() {
        return Err(format!("`{uri}` is not a file beside this one"));
    }
    Ok(files::beside(file.parent().unwrap_or(Path::new("")), Path::new(&name)))
}

/// Decodes the part of a data URI after `data:` (RFC 2397, base64 only, as glTF demands).
fn data_uri(data: &str) -> Result<Vec<u8>, String> {
    let Some((_, encoded)) = data.split_once(";base64,") else {
        return Err(String::from("the data URI is not base64"));
    };
    STANDARD.decode(encoded).map_err(|error| format!("the data URI is damaged: {error}"))
}

/// Decodes `%20` and the like in a URI (RFC 3986, section 2.1).
fn percent_decoded(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        if byte == b'%' {
            let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
            bytes.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &rest[2..];
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok().filter(|name| !name.contains('\0'))
}

impl Buffers<'_> {
    pub(super) fn total_bytes(&self) -> usize {
        let read = self.buffers.iter().flatten().map(|buffer| buffer.len());
        let unpacked = self.unpacked.values().flatten().map(Vec::len);
        read.chain(unpacked).sum()
    }

    /// Bytes and stride of a view; `user` is the path that refers to it.
    pub(super) fn view(&self, index: usize, user: &str) -> Result<(&[u8], Option<usize>), Diagnostic> {
        let Some(view) = self.document.buffer_views.get(index) else {
            return Err(self.invalid(user, format!("buffer view {index} does not exist")));
        };
        let path = format!("bufferViews[{index}]");
        let bytes = match self.unpacked.get(&index) {
            Some(Ok(bytes)) => bytes,
            Some(Err(damage)) => return Err(damage.clone()),
            None => self.range(view.buffer, view.byte_offset, view.byte_length, &path)?,
        };
        Ok((bytes, view.byte_stride))
    }

    fn unpack(&self, packed: &json::MeshoptView, view: &str) -> Result<Vec<u8>, Diagnostic> {
        let path = format!("{view}.extensions.EXT_meshopt_compression");
        let source = self.range(packed.buffer, packed.byte_offset, packed.byte_length, &path)?;
        meshopt::unpack(packed, source).map_err(|found| {
            self.invalid(path, found).expected("data as gltfpack writes them").remedy(
                "compress the original file again, or export it without compression (gltfpack: without -c)",
            )
        })
    }

    /// Bytes of a buffer; `path` is the place in the JSON that refers to them.
    fn range(&self, buffer: usize, offset: usize, length: usize, path: &str) -> Result<&[u8], Diagnostic> {
        let Some(bytes) = self.buffers.get(buffer) else {
            return Err(self.invalid(format!("{path}.buffer"), format!("buffer {buffer} does not exist")));
        };
        let Some(bytes) = bytes else {
            return Err(self.invalid(path, format!("buffer {buffer} could not be read")));
        };
        let whole = self.document.buffers[buffer].byte_length.min(bytes.len());
        match offset.checked_add(length).filter(|end| *end <= whole) {
            Some(end) => Ok(&bytes[offset..end]),
            None => Err(self.invalid(
                path,
                format!("the view spans {length} bytes from {offset}, beyond the buffer's {whole}"),
            )),
        }
    }

    /// Error at a place in this file.
    pub(super) fn invalid(&self, path: impl Into<String>, found: impl Into<String>) -> Diagnostic {
        invalid(self.file, path, found)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn file_names_with_spaces_and_umlauts_are_found() {
        assert_eq!(percent_decoded("oak%20leaf.png").unwrap(), "oak leaf.png");
        assert_eq!(percent_decoded("Bl%C3%A4tter.bin").unwrap(), "Bl\u{e4}tter.bin");
        assert_eq!(percent_decoded("oak leaf.png").unwrap(), "oak leaf.png");
        for damaged in ["%", "%2", "%zz", "%ff", "%00"] {
            assert_eq!(percent_decoded(damaged), None, "{damaged}");
        }
    }

    #[test]
    fn names_that_are_no_uris_are_taken_as_they_stand() {
        let folder = tempfile::tempdir().unwrap();
        let (file, sub) = (folder.path().join("a.gltf"), folder.path().join("Texturen"));
        std::fs::create_dir(&sub).unwrap();
        for name in ["50%.png", "oak leaf.png"] {
            std::fs::write(sub.join(name), name).unwrap();
        }
        for (uri, name) in [
            ("Texturen/50%.png", "50%.png"),
            ("Texturen/50%25.png", "50%.png"),
            ("Texturen\\50%.png", "50%.png"),
            (".\\Texturen\\oak%20leaf.png", "oak leaf.png"),
        ] {
            let found = std::fs::read(file_beside(uri, &file).unwrap()).unwrap();
            assert_eq!(found, name.as_bytes(), "{uri}");
        }
        for uri in ["\\\\share\\leaf.png", "//share/leaf.png"] {
            file_beside(uri, &file).unwrap_err();
        }
    }

    #[test]
    fn data_uris_are_decoded() {
        assert_eq!(data_uri("image/png;base64,AQID").unwrap(), [1, 2, 3]);
        assert!(data_uri(";base64,").unwrap().is_empty());
        assert!(data_uri("text/plain,leaf").is_err());
    }

    #[test]
    fn files_elsewhere_are_not_opened() {
        for uri in ["/dev/zero", "file:///dev/zero", "https://example.org/leaf.bin"] {
            let fetched = fetch(uri, Path::new("leaf.gltf"), &mut Files::default(), "").unwrap();
            assert!(fetched.is_err(), "{uri}");
        }
    }
}
