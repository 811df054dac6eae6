//! Parser of RON files. In goes text, out comes a typed document or a diagnostic. Invariant: every error has
//! the line and column of the value at fault, an expectation and a remedy.

use super::{SceneFile, SequenceFields};
use super::{misplaced, suggest};
use crate::diagnostic::{Diagnostic, Place};
use ::ron::Options;
use ::ron::error::{Error, SpannedError};
use ::ron::extensions::Extensions;
use serde::Deserialize;
use std::path::Path;

/// Kind of a file.
#[derive(Debug, Deserialize)]
pub(super) enum Document {
    Scene(SceneFile),
    Sequence(SequenceFields),
}

/// Parses the bytes of the file at `path`.
pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Document, Diagnostic> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        Diagnostic::error(place_of(path, bytes, error.valid_up_to()), "this is not text in UTF-8")
            .expected("a RON file in UTF-8")
            .remedy("save the file as UTF-8")
    })?;
    // Editors may write a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        let place = place_of(path, bytes, 0);
        return Err(Diagnostic::error(place, "the file is empty")
            .expected("`Scene(version: 1, ..)` or `Sequence(version: 1, ..)`")
            .remedy("docs/scene-format.md has examples"));
    }
    let document = Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME)
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES)
        .from_str(text)
        .map_err(|error| diagnostic(path, text, &error))?;
    let Some(name) = misplaced::misnamed_keys(text) else { return Ok(document) };
    let place = place_of(path, text.as_bytes(), name.start);
    Err(Diagnostic::error(place, format!("there is no `{}`", &text[name]))
        .expected("`Keyed(keys: [(at_s: .., value: ..), ..])`")
        .remedy("call it `Keyed`"))
}

fn place_of(path: &Path, bytes: &[u8], offset: usize) -> Place {
    let before = &bytes[..offset];
    let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
    let column = 1 + before.iter().rev().take_while(|&&byte| byte != b'\n').count();
    Place::Text { file: path.to_owned(), line, column }
}

fn diagnostic(path: &Path, text: &str, error: &SpannedError) -> Diagnostic {
    let start = error.span.start;
    let place = Place::Text { file: path.to_owned(), line: start.line, column: start.col };
    // `Document` is an internal name that no file contains; the type of keys is named after their value.
    let inside = |outer: &Option<String>| match outer.as_deref() {
        _ if is_of_keys(&error.code) => String::from(" in `Keyed`"),
        None | Some("Document") => String::new(),
        Some(outer) => format!(" in `{outer}`"),
    };
    if let Some(misplaced) = misplaced::diagnostic(&place, text, error) {
        return misplaced;
    }
    match &error.code {
        Error::NoSuchStructField { expected, found, outer } => {
            Diagnostic::error(place, format!("there is no field `{found}`{}", inside(outer)))
                .expected(format!("one of {}", suggest::list(expected.iter().copied())))
                .remedy(suggest::remedy(found, expected.iter().copied()))
        }
        Error::NoSuchEnumVariant { expected, found, outer } => {
            Diagnostic::error(place, format!("there is no `{found}`{}", inside(outer)))
                .expected(format!("one of {}", suggest::list(expected.iter().copied())))
                .remedy(suggest::remedy(found, expected.iter().copied()))
        }
        Error::MissingStructField { field, outer } => {
            Diagnostic::error(place, format!("the field `{field}`{} is missing", inside(outer)))
                .expected(format!("`{field}: ..` somewhere between these brackets"))
                .remedy(format!("add `{field}`; docs/scene-format.md says what it may be"))
        }
        Error::DuplicateStructField { field, outer } => {
            Diagnostic::error(place, format!("the field `{field}`{} occurs twice", inside(outer)))
                .expected("every field once")
                .remedy("take one of the two out")
        }
        Error::InvalidValueForType { expected, found } => {
            Diagnostic::error(place, format!("{} does not belong here", plain(found)))
                .expected(spoken(expected))
                .remedy("change the value; docs/scene-format.md has every field's unit and range")
        }
        Error::ExpectedDifferentLength { expected, found } => {
            Diagnostic::error(place, format!("the number of values here, {found}, is wrong"))
                .expected(expected.replace("a tuple of size", "as many as"))
                .remedy("count the values between the brackets; one alone stands without them")
        }
        Error::ExceededRecursionLimit => Diagnostic::error(place, "the brackets are nested too deeply")
            .expected("at most 128 brackets within each other")
            .remedy("close brackets that were left open before this place"),
        Error::InvalidEscape(found) => Diagnostic::error(place, lower_first(found))
            .expected("a backslash twice in a text, `\\\\`")
            .remedy("write paths with `/`"),
        Error::Message(message) => Diagnostic::error(place, message.clone())
            .expected("what docs/scene-format.md says of this field")
            .remedy("change the value"),
        other => Diagnostic::error(place, lower_first(&other.to_string()))
            .expected("RON as docs/scene-format.md describes it")
            .remedy("look for a missing comma, bracket, colon or quote at this place or just before it"),
    }
}

fn is_of_keys(error: &Error) -> bool {
    match error {
        Error::NoSuchStructField { expected, .. } => *expected == ["keys", "extend"],
        Error::MissingStructField { field, .. } | Error::DuplicateStructField { field, .. } => {
            *field == "keys" || *field == "extend"
        }
        _ => false,
    }
}

/// Names the kind of number in place of its Rust type.
fn plain(found: &str) -> String {
    let kinds =
        ["the unsigned integer ", "the signed integer ", "the integer ", "the floating point number "];
    let number = kinds.iter().find_map(|kind| found.strip_prefix(kind));
    number.map_or_else(|| found.to_owned(), |number| format!("the number {number}"))
}

/// Names in the format of types of this program.
fn spoken(expected: &str) -> String {
    match expected {
        "f64" | "f32" => String::from("a number"),
        "u8" | "u16" | "u32" | "u64" | "usize" => String::from("a whole number, 0 or more"),
        "i32" | "i64" => String::from("a whole number"),
        other => other.to_owned(),
    }
}

fn lower_first(message: &str) -> String {
    let mut characters = message.chars();
    characters.next().map(|first| first.to_lowercase().chain(characters).collect()).unwrap_or_default()
}
