//! Container of a `.glb` or `.gltf` file. In go bytes, out come JSON and the binary chunk. Invariant: an
//! error names the byte range, line or field at fault.

use super::json::Document;
use super::report::Report;
use super::{LoadError, field, invalid};
use crate::diagnostic::{Diagnostic, Loss, Place};
use serde_json::Value;
use std::path::Path;

/// Length of the header before a GLB file's first chunk.
const GLB_HEADER_BYTES: usize = 12;
/// Length and type before the data of a chunk.
const CHUNK_HEADER_BYTES: usize = 8;
/// Types of the two chunks that glTF defines.
const JSON_CHUNK: &[u8] = b"JSON";
const BINARY_CHUNK: &[u8] = b"BIN\0";
/// UTF-8 byte order mark, which readers may ignore (RFC 8259, section 8.1).
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// Integers up to here are exact in double precision.
const MOST_EXACT: f64 = (1_u64 << 53) as f64;

/// Parses the JSON of a file, and returns the binary chunk of a GLB.
pub(super) fn open<'a>(
    bytes: &'a [u8],
    path: &Path,
    report: &mut Report,
) -> Result<(Document, Option<&'a [u8]>), LoadError> {
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    if bytes.is_empty() {
        return Err(whole_file(path, String::from("the file is empty")).into());
    }
    if bytes.starts_with(b"glTF") {
        let (json, binary) = chunks(bytes, path, report)?;
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

struct Chunks<'a> {
    json: &'a [u8],
    binary: Option<&'a [u8]>,
    /// Bytes of other chunks.
    unknown: usize,
}

fn chunks<'a>(
    bytes: &'a [u8],
    path: &Path,
    report: &mut Report,
) -> Result<(&'a [u8], Option<&'a [u8]>), Diagnostic> {
    let word = |at: usize| {
        bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize).unwrap_or(0)
    };
    let (version, length) = (word(4), word(8));
    if bytes.len() >= 8 && version != 2 {
        let found = format!("this is version {version} of the GLB container");
        return Err(whole_file(path, found).expected("version 2").remedy(OF_VERSION_1));
    }
    // The crate subtracts the header's length from the declared one without a check.
    if bytes.len() < GLB_HEADER_BYTES || length < GLB_HEADER_BYTES || length > bytes.len() {
        return Err(whole_file(
            path,
            format!("the file is cut short: it has {} bytes and says {length} in its header", bytes.len()),
        ));
    }
    let Chunks { json, binary, unknown } = match gltf::Glb::from_slice(&bytes[..length]) {
        Ok(glb) => {
            let (json, binary) = (borrowed(glb.json), glb.bin.map(borrowed));
            let chunk = |data: &[u8]| CHUNK_HEADER_BYTES + data.len().next_multiple_of(4);
            let known = GLB_HEADER_BYTES + chunk(json) + binary.map_or(0, chunk);
            Chunks { json, binary, unknown: length.saturating_sub(known) }
        }
        Err(_) => among_unknown(&bytes[GLB_HEADER_BYTES..length], path)?,
    };
    let rests = [(unknown, "in chunks that glTF does not know"), (bytes.len() - length, "after the end")];
    for (count, place) in rests.into_iter().filter(|(count, _)| *count > 0) {
        report.not_honoured(Loss::ContainerRest, &format!("{count} bytes {place}"));
    }
    Ok((unpadded(json), binary))
}

/// Borrowed bytes; the crate copies none of those that it borrows.
fn borrowed(bytes: std::borrow::Cow<'_, [u8]>) -> &[u8] {
    match bytes {
        std::borrow::Cow::Borrowed(bytes) => bytes,
        std::borrow::Cow::Owned(_) => &[],
    }
}

/// Finds JSON and binary data among chunks in any order, and counts the bytes of others. The crate refuses
/// unknown chunks before these two.
fn among_unknown<'a>(mut rest: &'a [u8], path: &Path) -> Result<Chunks<'a>, Diagnostic> {
    let (mut json, mut binary, mut unknown) = (None, None, 0);
    while !rest.is_empty() {
        let (kind, data, after) = match next_chunk(rest) {
            Some(chunk) => chunk,
            // All required chunks are found; up to three bytes are padding of the last one.
            None if binary.is_some() => {
                unknown += if rest.len() < 4 { 0 } else { rest.len() };
                break;
            }
            None => return Err(damaged(path, "its last chunk is cut short")),
        };
        match kind {
            JSON_CHUNK if json.is_none() => json = Some(data),
            BINARY_CHUNK if json.is_some() && binary.is_none() => binary = Some(data),
            BINARY_CHUNK if json.is_none() => {
                return Err(damaged(path, "was not expecting BIN before its JSON"));
            }
            _ => unknown += CHUNK_HEADER_BYTES + data.len(),
        }
        rest = after;
    }
    let json = json.ok_or_else(|| damaged(path, "it has no JSON"))?;
    Ok(Chunks { json, binary, unknown })
}

/// Type and data of the next chunk, and the rest; `None` if it is truncated.
fn next_chunk(bytes: &[u8]) -> Option<(&[u8], &[u8], &[u8])> {
    let (head, rest) = bytes.split_at_checked(CHUNK_HEADER_BYTES)?;
    let (length, kind) = head.split_at_checked(4)?;
    let length = u32::from_le_bytes(length.try_into().ok()?);
    let (data, rest) = rest.split_at_checked(usize::try_from(length).ok()?)?;
    Some((kind, data, rest))
}

/// Removes padding by zeros, in place of the specification's spaces, and a byte order mark, as some exporters
/// write them.
fn unpadded(json: &[u8]) -> &[u8] {
    let json = json.strip_prefix(BYTE_ORDER_MARK).unwrap_or(json);
    let zeros = json.iter().rev().take_while(|byte| **byte == 0).count();
    &json[..json.len() - zeros]
}

fn damaged(path: &Path, found: &str) -> Diagnostic {
    whole_file(path, format!("the GLB container is damaged: {found}"))
}

fn parse(json: &[u8], path: &Path, is_text_file: bool) -> Result<Document, Diagnostic> {
    let mut value: Value = serde_json::from_slice(json).map_err(|error| {
        let place = match is_text_file {
            true => Place::Text { file: path.to_owned(), line: error.line(), column: error.column() },
            false => Place::File(path.to_owned()),
        };
        Diagnostic::error(place, format!("the JSON is damaged: {error}"))
            .expected("whole JSON")
            .remedy("export or copy the file again")
    })?;
    if let Some(version) = first_version(&value) {
        return Err(another_version(path, &version));
    }
    with_integers(&mut value);
    without_nulls(&mut value);
    serde_path_to_error::deserialize(value).map_err(|error| {
        let at = error.path().to_string();
        let place = if at == "." { Place::File(path.to_owned()) } else { field(path, at) };
        Diagnostic::error(place, error.into_inner().to_string())
            .expected("JSON as the glTF 2.0 specification describes it")
            .remedy("export the file again, or check it with the Khronos glTF validator")
    })
}

/// Makes integers of whole numbers: `3.0` and `1e2` are integers in JSON too (RFC 8259, section 6; glTF 2.0,
/// 2.7).
fn with_integers(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => {
            let whole = number.as_f64().filter(|number| number.fract() == 0.0 && number.abs() <= MOST_EXACT);
            // -0 keeps its sign.
            if let Some(whole) = whole.filter(|whole| *whole != 0.0 || whole.is_sign_positive()) {
                *value = Value::from(whole as i64);
            }
        }
        Value::Array(values) => values.iter_mut().for_each(with_integers),
        Value::Object(values) => values.values_mut().for_each(with_integers),
        _ => {}
    }
}

/// Removes members that are null, except in extras.
fn without_nulls(value: &mut Value) {
    match value {
        Value::Array(values) => values.iter_mut().for_each(without_nulls),
        Value::Object(values) => {
            values.retain(|_, value| !value.is_null());
            let ours = values.iter_mut().filter(|(name, _)| *name != "extras");
            ours.for_each(|(_, value)| without_nulls(value));
        }
        _ => {}
    }
}

fn whole_file(path: &Path, found: String) -> Diagnostic {
    Diagnostic::error(Place::File(path.to_owned()), found)
        .expected("a whole glTF 2.0 file, .glb or .gltf")
        .remedy("export or copy the file again")
}

/// Refuses versions other than 2.x.
pub(super) fn check_version(document: &Document, path: &Path) -> Result<(), Diagnostic> {
    let asset = &document.asset;
    let readable = |version: &str| version == "2.0" || version.starts_with("2.") && version.len() > 2;
    let required = asset.min_version.as_deref();
    match required.filter(|version| *version != "2.0") {
        Some(newer) => Err(invalid(path, "asset.minVersion", format!("glTF version `{newer}` is required"))
            .expected("2.0")
            .remedy("export as glTF 2.0")),
        None if !readable(&asset.version) => Err(another_version(path, &asset.version)),
        None => Ok(()),
    }
}

/// Version of a glTF 1 document, where objects with names as keys stand in place of arrays.
fn first_version(document: &Value) -> Option<String> {
    match &document["asset"]["version"] {
        Value::String(version) if version.starts_with("1.") => Some(version.clone()),
        // The version is optional in 1.0.
        Value::String(_) => None,
        _ => document["nodes"].is_object().then(|| String::from("1.0")),
    }
}

const OF_VERSION_1: &str = "export as glTF 2.0; of version 1.0, gltf-pipeline converts it";

fn another_version(path: &Path, version: &str) -> Diagnostic {
    invalid(path, "asset.version", format!("this is glTF version `{version}`"))
        .expected("2.0")
        .remedy(OF_VERSION_1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn the_first_version_is_called_by_its_name() {
        let said = json!({ "asset": { "version": "1.0.1" }, "nodes": {} });
        let unsaid = json!({ "nodes": { "a": {} }, "meshes": {} });
        assert_eq!(first_version(&said).as_deref(), Some("1.0.1"));
        assert_eq!(first_version(&unsaid).as_deref(), Some("1.0"));
        for second in
            [json!({ "asset": { "version": "2.0" }, "nodes": {} }), json!({ "nodes": [] }), json!([])]
        {
            assert_eq!(first_version(&second), None);
        }
    }

    #[test]
    fn whole_numbers_are_integers_however_they_are_written() {
        let mut value: Value =
            serde_json::from_str("[3.0, 0.0, 1e2, [{\"a\": 2.50e1}], -4.0]").unwrap_or_default();
        with_integers(&mut value);
        assert_eq!(value, json!([3, 0, 100, [{ "a": 25 }], -4]));
        for kept in ["1.5", "1e300", "-0.0", "\"3.0\"", "true"] {
            let mut value: Value = serde_json::from_str(kept).unwrap_or_default();
            let before = value.clone();
            with_integers(&mut value);
            assert_eq!(value, before);
        }
    }
}
