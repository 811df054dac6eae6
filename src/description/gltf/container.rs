//! The bytes of a `.glb` or `.gltf` file in, its JSON and binary chunk out. Invariant: an error
//! says which byte range, line or field is at fault.

use super::json::Document;
use super::{LoadError, field, invalid};
use crate::diagnostic::{Diagnostic, Place};
use std::path::Path;

/// Length of the header before a GLB file's first chunk.
const GLB_HEADER_BYTES: usize = 12;

/// Takes the container apart and parses the JSON. The second part is the GLB's binary chunk.
pub(super) fn open<'a>(bytes: &'a [u8], path: &Path) -> Result<(Document, Option<&'a [u8]>), LoadError> {
    if bytes.is_empty() {
        return Err(whole_file(path, String::from("the file is empty")).into());
    }
    if bytes.starts_with(b"glTF") {
        let (json, binary) = chunks(bytes, path)?;
        Ok((parse(json, path, false)?, binary))
    } else if bytes.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'{') || is_json(path) {
        Ok((parse(bytes, path, true)?, None))
    } else {
        Err(whole_file(path, String::from("this is no glTF file: it starts with neither `glTF` nor `{`"))
            .into())
    }
}

fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("gltf"))
}

fn chunks<'a>(bytes: &'a [u8], path: &Path) -> Result<(&'a [u8], Option<&'a [u8]>), Diagnostic> {
    let word = |at: usize| {
        bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize).unwrap_or(0)
    };
    let (version, length) = (word(4), word(8));
    if bytes.len() >= 8 && version != 2 {
        return Err(
            whole_file(path, format!("this is version {version} of the GLB container")).expected("version 2")
        );
    }
    // The crate subtracts the header from the length it finds without looking.
    if bytes.len() < GLB_HEADER_BYTES || length < GLB_HEADER_BYTES || length > bytes.len() {
        return Err(whole_file(
            path,
            format!("the file is cut short: it has {} bytes and says {length} in its header", bytes.len()),
        ));
    }
    match gltf::Glb::from_slice(&bytes[..length]) {
        Ok(glb) => Ok((borrowed(glb.json), glb.bin.map(borrowed))),
        Err(error) => Err(whole_file(path, format!("the GLB container is damaged: {error}"))),
    }
}

/// The crate lends what it was lent.
fn borrowed(bytes: std::borrow::Cow<'_, [u8]>) -> &[u8] {
    match bytes {
        std::borrow::Cow::Borrowed(bytes) => bytes,
        std::borrow::Cow::Owned(_) => &[],
    }
}

fn parse(json: &[u8], path: &Path, is_text_file: bool) -> Result<Document, Diagnostic> {
    let deserializer = &mut serde_json::Deserializer::from_slice(json);
    serde_path_to_error::deserialize(deserializer).map_err(|error| {
        let at = error.path().to_string();
        let error = error.into_inner();
        let damaged = error.is_syntax() || error.is_eof();
        let place = if damaged && is_text_file {
            Place::Text { file: path.to_owned(), line: error.line(), column: error.column() }
        } else if damaged || at == "." {
            Place::File(path.to_owned())
        } else {
            field(path, at)
        };
        if damaged {
            Diagnostic::error(place, format!("the JSON is damaged: {error}"))
                .expected("whole JSON")
                .remedy("export or copy the file again")
        } else {
            Diagnostic::error(place, error.to_string())
                .expected("JSON as the glTF 2.0 specification describes it")
                .remedy("export the file again, or check it with the Khronos glTF validator")
        }
    })
}

fn whole_file(path: &Path, found: String) -> Diagnostic {
    Diagnostic::error(Place::File(path.to_owned()), found)
        .expected("a whole glTF 2.0 file, .glb or .gltf")
        .remedy("export or copy the file again")
}

/// Refuses documents of other versions than 2.x.
pub(super) fn check_version(document: &Document, path: &Path) -> Result<(), Diagnostic> {
    let asset = &document.asset;
    let readable = |version: &str| version == "2.0" || version.starts_with("2.") && version.len() > 2;
    let required = asset.min_version.as_deref();
    match required.filter(|version| *version != "2.0") {
        Some(newer) => Err(invalid(path, "asset.minVersion", format!("glTF version `{newer}` is required"))
            .expected("2.0")
            .remedy("export as glTF 2.0")),
        None if !readable(&asset.version) => {
            Err(invalid(path, "asset.version", format!("this is glTF version `{}`", asset.version))
                .expected("2.0")
                .remedy("export as glTF 2.0"))
        }
        None => Ok(()),
    }
}
