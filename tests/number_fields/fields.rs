//! Files in, the numbers in them out, each with a way to the file in which another number takes its
//! place. Invariant: every number of the text or the JSON is one of them. Only the versions that files
//! have to say are not.

use crate::checkout;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Number, Value};
use std::collections::BTreeSet;
use std::ops::Range;
use std::path::PathBuf;

/// What takes the place of every number: the smallest and largest of both precisions, and what
/// lies around the limits.
const NUMBERS: [&str; 9] =
    ["0", "-1", "5e-324", "1e-30", "1e15", "-1e15", "1e30", "3.4028235e38", "1.7976931348623157e308"];

/// And of every whole one: the largest of 32 and 64 bits.
const WHOLE_NUMBERS: [&str; 2] = ["4294967295", "18446744073709551615"];

/// And of every float of a buffer.
const FLOATS: [&str; 10] =
    ["-1", "1e-30", "1e-45", "1e15", "-1e15", "1e30", "3.4028235e38", "-3.4028235e38", "nan", "inf"];

/// Makes a file of the number that is to stand in it.
type FileWith = Box<dyn Fn(&str) -> Vec<u8> + Send + Sync>;

/// A number of a file.
pub(crate) struct Field {
    /// The file, below tests/data.
    pub(crate) file: &'static str,
    /// Where in the file it is, and what it is there.
    pub(crate) name: String,
    /// Whether only whole numbers can stand there.
    pub(crate) is_whole: bool,
    /// Whether it says how many of a thing there are: as many as are allowed take the time that so many take.
    pub(crate) is_count: bool,
    /// What takes its place.
    pub(crate) numbers: Vec<&'static str>,
    /// The file with another number in its place.
    pub(crate) file_with: FileWith,
}

pub(crate) fn data(name: &str) -> PathBuf {
    checkout::file("tests/data").join(name)
}

fn numbers(is_whole: bool) -> Vec<&'static str> {
    NUMBERS.into_iter().chain(WHOLE_NUMBERS.into_iter().filter(|_| is_whole)).collect()
}

/// The numbers of a RON file but its version's.
pub(crate) fn of_ron(file: &'static str) -> Vec<Field> {
    let text = std::fs::read_to_string(data(file)).unwrap();
    let places = places_in_ron(&text).into_iter();
    let places = places.filter(|place| !text[..place.start].ends_with("version: "));
    let field = |place: Range<usize>| {
        let (before, number, after) = (&text[..place.start], &text[place.clone()], &text[place.end..]);
        let (line, column) = (before.lines().count(), before.len() - before.rfind('\n').unwrap_or(0));
        let is_whole = number.parse::<i64>().is_ok();
        let (before, after) = (before.to_owned(), after.to_owned());
        Field {
            file,
            name: format!("{line}:{column}: {number}"),
            is_whole,
            is_count: before.ends_with("count: "),
            numbers: numbers(is_whole),
            file_with: Box::new(move |to| format!("{before}{to}{after}").into_bytes()),
        }
    };
    places.map(field).collect()
}

/// Where a RON file has its numbers: not in names, strings and comments.
fn places_in_ron(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let rest = &bytes[at..];
        let length = |is_within: &dyn Fn(&u8) -> bool| rest.iter().take_while(|byte| is_within(byte)).count();
        at += match rest {
            [b'"', after @ ..] => 2 + after.iter().take_while(|byte| **byte != b'"').count(),
            [b'/', b'/', ..] => length(&|byte| *byte != b'\n'),
            [b'a'..=b'z' | b'A'..=b'Z' | b'_', ..] => {
                length(&|byte| byte.is_ascii_alphanumeric() || *byte == b'_')
            }
            [b'-' | b'0'..=b'9', ..] => {
                let length = length(&|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(byte));
                found.push(at..at + length);
                length
            }
            _ => 1,
        };
    }
    found
}

/// The numbers of a glTF file, in its JSON and its buffer, but those that are the same in a file
/// that was `seen` before.
pub(crate) fn of_gltf(file: &'static str, seen: &mut BTreeSet<(String, String)>) -> Vec<Field> {
    let json: Value = serde_json::from_slice(&std::fs::read(data(file)).unwrap()).unwrap();
    let mut pointers = Vec::new();
    numbers_of_json(&json, String::new(), &mut pointers);
    let pointers = pointers.into_iter();
    let new =
        pointers.filter(|pointer| seen.insert((pointer.clone(), json.pointer(pointer).unwrap().to_string())));
    let field = |pointer: String| {
        let number = json.pointer(&pointer).unwrap();
        let is_whole = number.is_u64();
        let (name, json) = (format!("{pointer}: {number}"), json.clone());
        let file_with = move |to: &str| {
            let mut changed = json.clone();
            let to: Number = serde_json::from_str(to).unwrap();
            *changed.pointer_mut(&pointer).unwrap() = Value::Number(to);
            changed.to_string().into_bytes()
        };
        Field {
            file,
            name,
            is_whole,
            is_count: false,
            numbers: numbers(is_whole),
            file_with: Box::new(file_with),
        }
    };
    new.map(field).chain(floats_of_buffer(file, &json)).collect()
}

/// JSON pointers to all numbers.
fn numbers_of_json(value: &Value, pointer: String, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(pointer),
        Value::Array(items) => {
            let items = items.iter().enumerate();
            items.for_each(|(index, item)| numbers_of_json(item, format!("{pointer}/{index}"), found));
        }
        Value::Object(fields) => fields.iter().for_each(|(name, field)| {
            numbers_of_json(field, format!("{pointer}/{}", name.replace('/', "~1")), found);
        }),
        _ => {}
    }
}

/// The first, the middle and the last float of every accessor.
fn floats_of_buffer(file: &'static str, json: &Value) -> Vec<Field> {
    const FLOAT: u64 = 5126;
    let at = |value: &Value, field: &str| value.get(field).and_then(Value::as_u64).unwrap_or(0) as usize;
    let uri = json["buffers"][0]["uri"].as_str().unwrap();
    let (head, encoded) = uri.split_once(',').unwrap();
    let bytes = BASE64_STANDARD.decode(encoded).unwrap();
    let accessors = json["accessors"].as_array().unwrap().iter().enumerate();
    let of_accessor = |(index, accessor): (usize, &Value)| {
        let view = &json["bufferViews"][at(accessor, "bufferView")];
        let (start, floats) = (at(view, "byteOffset"), at(view, "byteLength") / 4);
        let places = BTreeSet::from([0, floats / 2, floats - 1]).into_iter();
        places.map(move |float| (format!("float {float} of accessor {index}"), start + 4 * float))
    };
    let places = accessors.filter(|(_, accessor)| accessor["componentType"] == FLOAT).flat_map(of_accessor);
    let field = |(name, start): (String, usize)| {
        let (bytes, json, head) = (bytes.clone(), json.clone(), head.to_owned());
        let file_with = move |to: &str| {
            let to: f32 = to.parse().unwrap();
            let (mut bytes, mut json) = (bytes.clone(), json.clone());
            bytes[start..][..4].copy_from_slice(&to.to_le_bytes());
            json["buffers"][0]["uri"] = format!("{head},{}", BASE64_STANDARD.encode(&bytes)).into();
            json.to_string().into_bytes()
        };
        Field {
            file,
            name,
            is_whole: false,
            is_count: false,
            numbers: FLOATS.into(),
            file_with: Box::new(file_with),
        }
    };
    places.map(field).collect()
}
