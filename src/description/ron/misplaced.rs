//! Values in a form that their field does not take. In go a parser's error and the text, out comes a
//! diagnostic in the format's terms. Invariant: keys in a wrong form give an error that shows the right one.

use super::meant::{is_word, tokens};
use super::suggest;
use crate::diagnostic::{Diagnostic, Place};
use ::ron::error::{Error, SpannedError};
use std::ops::Range;

/// Diagnostic of an error about a value's form; `None` for others.
pub(super) fn diagnostic(place: &Place, text: &str, error: &SpannedError) -> Option<Diagnostic> {
    let (rest, word) = (at(text, error), word(text, error));
    Some(match &error.code {
        Error::ExpectedComma if rest.starts_with('.') => told(place, word, "a whole number"),
        Error::ExpectedComma => told_unit(place, text, error)?,
        Error::IntegerOutOfBounds | Error::InvalidIntegerDigit { .. } => {
            told(place, word, "a whole number in the field's range")
        }
        Error::ExpectedFloat | Error::ExpectedInteger => told(place, rest, "a number"),
        // A bracket may be missing before such a place.
        Error::ExpectedArray | Error::ExpectedIdentifier | Error::ExpectedString
            if rest.is_empty() || rest.starts_with([')', ']', '}', ',', ':']) =>
        {
            return None;
        }
        Error::ExpectedArray => told(place, rest, "a list in square brackets, `[.., ..]`"),
        Error::ExpectedIdentifier => told(place, rest, "a name without quotes"),
        Error::ExpectedString => told(place, rest, "a text in double quotes")
            .remedy("write it in double quotes, or look for a missing bracket just before it"),
        Error::ExpectedStructLike | Error::ExpectedNamedStructLike(_) => {
            told(place, rest, "values in round brackets, `(.., ..)` or `(field: .., ..)`")
        }
        Error::ExpectedDifferentStructName { found, .. } if found == "Keyed" => {
            told(place, "Keyed", "fields in round brackets, `(field: value, ..)`")
                .remedy("give keys to its fields one by one; docs/scene-format.md says which may be keyed")
        }
        Error::SuggestRawIdentifier(name) | Error::InvalidIdentifier(name) => {
            Diagnostic::error(place.clone(), format!("`{name}` does not belong here"))
                .expected("the name of a field, or a value without names")
                .remedy("write `field: value`; keys are `Keyed(keys: [(at_s: 0.0, value: ..), ..])`")
        }
        Error::InvalidValueForType { expected, found } if found == "a map" || found == "a sequence" => {
            told(place, rest, if expected == "f64" { "a number" } else { expected })
        }
        // A word that is no value, and a number too large for any.
        Error::InvalidValueForType { expected, found }
            if found == "a unit value" || found.ends_with("inf`") =>
        {
            told(place, word, expected)
        }
        code => return misplaced_name(place, code),
    })
}

/// Diagnostic of a name that is right elsewhere; `None` for others.
fn misplaced_name(place: &Place, error: &Error) -> Option<Diagnostic> {
    Some(match error {
        Error::NoSuchStructField { found, outer: Some(outer), .. }
            if found == "motion" && outer == "Leaves" =>
        {
            Diagnostic::error(place.clone(), "the leaves of `leaves` do not move by themselves")
                .expected("leaves that fall in a block of `fall`, or no `motion`")
                .remedy(
                    "write `fall: { \"name\": (count: .., species: [(meshes: [..], length_m: ..)], \
                     emitter: Box(min_m: .., max_m: ..), release_s: -1.0) }`",
                )
        }
        Error::NoSuchStructField { found, outer: Some(outer), .. }
            if found == "materials" && outer == "Object" =>
        {
            Diagnostic::error(place.clone(), "an object has no `materials`: its mesh has them by name")
                .expected("`material`, for all of the mesh, or other materials where the mesh is")
                .remedy("write `ObjWith(file: \"tree.obj\", materials: { \"leaf\": .. })` in `meshes`")
        }
        Error::NoSuchEnumVariant { expected, found, outer: Some(outer) }
            if outer == "Pass" && found.eq_ignore_ascii_case("all") =>
        {
            Diagnostic::error(place.clone(), "a file names its passes one by one")
                .expected(format!("some of {}", suggest::list(expected.iter().copied())))
                .remedy("name them, or take `passes` out and render with `--passes all`")
        }
        _ => return None,
    })
}

/// Range of keys with another name than `Keyed`. RON accepts any name where a plain value may occur as well.
pub(super) fn misnamed_keys(text: &str) -> Option<Range<usize>> {
    let bytes = text.as_bytes();
    let mut last: [Range<usize>; 4] = Default::default();
    for (at, token) in tokens(bytes) {
        let is_more = is_word(token[0]) && last[3].end == at && at > 0 && is_word(bytes[at - 1]);
        if !is_more {
            last.rotate_left(1);
            last[3].start = at;
        }
        last[3].end = at + token.len();
        if token != b":" {
            continue;
        }
        let [name, bracket, field, _] = last.clone().map(|range| &bytes[range]);
        let is_of_keys = bracket == b"(" && (field == b"keys" || field == b"extend");
        if is_of_keys && name.first().is_some_and(|&first| is_word(first)) && name != b"Keyed" {
            return Some(last[0].clone());
        }
    }
    None
}

/// Diagnostic of a unit after a number; `None` for other missing commas.
fn told_unit(place: &Place, text: &str, error: &SpannedError) -> Option<Diagnostic> {
    let rest = at(text, error);
    let before = text[..text.len() - rest.len()].trim_end();
    let is_after_number = before.ends_with(|last: char| last.is_ascii_digit() || last == '.');
    let is_unit =
        |letter: char| letter.is_alphabetic() || matches!(letter, '%' | '\u{b0}' | '"' | '\'' | '/' | '^');
    let unit = rest.split(|letter: char| !is_unit(letter)).next().filter(|unit| !unit.is_empty())?;
    is_after_number.then(|| {
        Diagnostic::error(place.clone(), format!("`{unit}` does not belong here, behind a number"))
            .expected("a number alone: its unit is in the field's name, such as `_m`, `_s` or `_deg`")
            .remedy(format!(
                "take `{unit}` out, and give the number in the unit of the field; or add a comma"
            ))
    })
}

fn at<'a>(text: &'a str, error: &SpannedError) -> &'a str {
    text[offset(text, error)..].trim_start()
}

/// The word or number in which an error lies, or at whose end.
fn word<'a>(text: &'a str, error: &SpannedError) -> &'a str {
    let (before, after) = text.split_at(offset(text, error));
    let ahead = before.bytes().rev().take_while(|&byte| is_word(byte)).count();
    let behind = after.bytes().take_while(|&byte| is_word(byte)).count();
    &text[before.len() - ahead..before.len() + behind]
}

fn offset(text: &str, error: &SpannedError) -> usize {
    let start = error.span.start;
    let before: usize = text.split_inclusive('\n').take(start.line.saturating_sub(1)).map(str::len).sum();
    let column = text[before..].char_indices().nth(start.col.saturating_sub(1));
    column.map_or(text.len(), |(column, _)| before + column)
}

/// Diagnostic of the text in a value's place.
fn told(place: &Place, text: &str, expected: &str) -> Diagnostic {
    let is_of_keys = |text: &str| ["Keyed", "Keys", "keys"].iter().any(|word| text.starts_with(word));
    let within = text.trim_start_matches(['(', '[']).trim_start();
    let (found, remedy) = match text.chars().next() {
        _ if is_of_keys(text) || is_of_keys(within) => (
            String::from("keys do not belong here: this does not change over time"),
            "write a plain value; docs/scene-format.md says which fields may be keyed",
        ),
        Some(bracket @ ('(' | '[' | '{')) => (
            format!("the bracket `{bracket}` does not belong here"),
            "write the value as docs/scene-format.md has it; keys are `Keyed(keys: [(at_s: 0.0, value: ..), ..])`",
        ),
        Some('"') => {
            (String::from("a text does not belong here"), "take the quotes out, or change the value")
        }
        _ => match text.split([',', ':', '(', ')', ']', '}', ' ', '\n']).next().unwrap_or_default() {
            "" => (String::from("there is no value here"), "write one, or take the field out"),
            word => (
                format!("`{word}` does not belong here"),
                "change the value; docs/scene-format.md says what it may be",
            ),
        },
    };
    Diagnostic::error(place.clone(), found).expected(expected).remedy(remedy)
}
