//! List of frame numbers. In goes text of the command line, out come numbers. Invariant: each frame occurs
//! once, in the order of first mention.
//!
//! | written | means |
//! |---|---|
//! | `7`, `-3` | one frame |
//! | `1-48`, `1..48`, `-5--1`, `-5..-1` | from ... to, both included |
//! | `1-48x2`, `1-48:2`, `1..48x2` | every second of them |
//! | `all` | all frames of the sequence |
//! | `1-10,20,30-40x5` | one after the other |
//! | `none` alone | no frame, as `sunfleck-tools validate --list-missing` says where none is missing |

use crate::diagnostic::{Diagnostic, Place};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// Maximum number of frames, a quarter of two days of film at 24 frames a second.
const MOST_FRAMES: usize = 1_000_000;

/// Frames in the order in which they are rendered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameList(Vec<i64>);

impl FrameList {
    /// Parses a list; `all` are the frames of the sequence, `none` is an empty list.
    ///
    /// # Errors
    /// If some part of it is no frame, range or `all`, or there are more frames than a million.
    pub fn parse(text: &str, all: RangeInclusive<i64>) -> Result<Self, Diagnostic> {
        if text.trim() == "none" {
            return Ok(Self(Vec::new()));
        }
        let mut frames = Vec::new();
        let mut seen = BTreeSet::new();
        for item in text.split(',') {
            let (range, step) = parse_item(item.trim(), &all)?;
            let (first, last) = (*range.start(), *range.end());
            if (last - first) / step >= MOST_FRAMES as i64 {
                return Err(error(item, "it has more than a million frames").remedy("render it in parts"));
            }
            let mut frame = first;
            while frame <= last {
                if seen.insert(frame) {
                    frames.push(frame);
                }
                frame += step;
            }
            if frames.len() > MOST_FRAMES {
                return Err(error(text, "it has more than a million frames").remedy("render it in parts"));
            }
        }
        Ok(Self(frames))
    }

    /// The frames.
    pub fn as_slice(&self) -> &[i64] {
        &self.0
    }

    /// Refuses frames that the sequence does not have.
    ///
    /// # Errors
    /// Names the first such frame.
    pub fn check_within(&self, sequence: &RangeInclusive<i64>) -> Result<(), Diagnostic> {
        match self.0.iter().find(|frame| !sequence.contains(frame)) {
            None => Ok(()),
            Some(frame) => {
                let (first, last) = (sequence.start(), sequence.end());
                Err(Diagnostic::error(Place::Nowhere, format!("frame {frame} is not part of the sequence"))
                    .expected(format!("frames from {first} to {last}"))
                    .remedy("choose other --frames, or widen the range: `frames` of a sequence, the frame range in Blender"))
            }
        }
    }
}

fn parse_item(item: &str, all: &RangeInclusive<i64>) -> Result<(RangeInclusive<i64>, i64), Diagnostic> {
    if item == "all" {
        return Ok((all.clone(), 1));
    }
    let none = if item.is_empty() { "nothing is there" } else { "it is no frame number" };
    let (first, rest) = split_number(item).ok_or_else(|| unread(item, item, none))?;
    if rest.is_empty() {
        return Ok((first..=first, 1));
    }
    let rest = rest
        .strip_prefix("..")
        .or_else(|| rest.strip_prefix('-'))
        .ok_or_else(|| error(item, "what follows the first number is no range"))?;
    let (last, rest) = split_number(rest).ok_or_else(|| unread(item, rest, "the range has no end"))?;
    if last < first {
        let found = "the range ends before it begins";
        return Err(error(item, found).remedy(format!("write {last}..{first}{rest}")));
    }
    if rest.is_empty() {
        return Ok((first..=last, 1));
    }
    let step = rest
        .strip_prefix(['x', ':'])
        .and_then(split_number)
        .filter(|&(step, rest)| step > 0 && rest.is_empty())
        .ok_or_else(|| error(item, "the step is no positive number"))?;
    Ok((first..=last, step.0))
}

/// Integer at the start of `text`, and the rest. Numbers are limited to the range of EXR's `imageCounter`.
fn split_number(text: &str) -> Option<(i64, &str)> {
    let text = text.trim_start();
    let digits_at = usize::from(text.starts_with('-'));
    let digits = text[digits_at..].bytes().take_while(u8::is_ascii_digit).count();
    let (number, rest) = text.split_at(digits_at + digits);
    let number: i32 = number.parse().ok()?;
    Some((i64::from(number), rest.trim_start()))
}

/// Error of an item without a frame number at the start of `text`: too large a one, or as `none` says.
fn unread(item: &str, text: &str, none: &str) -> Diagnostic {
    let digits = text.trim_start().trim_start_matches('-');
    if digits.starts_with(|first: char| first.is_ascii_digit()) {
        return error(item, &format!("a number is beyond {}", i32::MAX));
    }
    error(item, none)
}

fn error(found: &str, why: &str) -> Diagnostic {
    Diagnostic::error(Place::Nowhere, format!("--frames: cannot make sense of `{found}`: {why}"))
        .expected("frames and ranges such as 1-48, 1-48x2, 1..10, -5--1, all, separated by commas")
        .remedy("write for instance --frames 1-48x2,60")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn frames(text: &str) -> Vec<i64> {
        FrameList::parse(text, 3..=5).unwrap().0
    }

    #[test]
    fn the_grammar() {
        let table: [(&str, &[i64]); 18] = [
            ("none", &[]),
            ("7", &[7]),
            ("-3", &[-3]),
            ("0001", &[1]),
            ("1-4", &[1, 2, 3, 4]),
            ("1..4", &[1, 2, 3, 4]),
            ("1-6x2", &[1, 3, 5]),
            ("1-7:3", &[1, 4, 7]),
            ("1..6x5", &[1, 6]),
            ("13-19:3,40", &[13, 16, 19, 40]),
            ("-5--3", &[-5, -4, -3]),
            ("-5..-3", &[-5, -4, -3]),
            ("-1-1", &[-1, 0, 1]),
            ("5-5", &[5]),
            ("all", &[3, 4, 5]),
            ("5,all", &[5, 3, 4]),
            ("4,1-4,2", &[4, 1, 2, 3]),
            (" 1 - 2 , 4 ", &[1, 2, 4]),
        ];
        for (text, expected) in table {
            assert_eq!(frames(text), expected, "{text}");
        }
    }

    #[test]
    fn what_is_not_in_the_grammar_is_refused_with_a_remedy() {
        for text in [
            "",
            ",",
            "1,",
            "a",
            "1-",
            "-",
            "--1",
            "1-b",
            "4-1",
            "1-4x0",
            "1-4x",
            "1-4x-1",
            "1-4y2",
            "1-4x2z",
            "1.5",
            "1...4",
            "99999999999",
            "1-2-3",
            "ALL",
            "none,1",
            "1 2",
            "é",
        ] {
            let error = FrameList::parse(text, 1..=9).unwrap_err();
            assert!(error.remedy.is_some() && error.expected.is_some(), "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (text, why) in
            [("", "nothing"), ("1-99999999999", "beyond 2147483647"), ("1-", "no end"), ("x", "no frame")]
        {
            let error = FrameList::parse(text, 1..=9).unwrap_err();
            assert!(error.found.contains(why), "{text}: {}", error.found);
        }
    }

    #[test]
    fn a_list_without_end_is_refused() {
        assert!(FrameList::parse("1-2000000000", 1..=9).is_err());
        assert!(FrameList::parse("1-900000,1000000-1900000", 1..=9).is_err());
        assert_eq!(FrameList::parse("1-2000000000x1000000", 1..=9).unwrap().as_slice().len(), 2000);
    }

    #[test]
    fn frames_beyond_the_sequence_are_named() {
        let list = FrameList::parse("1-9", 1..=5).unwrap();
        assert!(list.check_within(&(1..=5)).unwrap_err().found.contains("frame 6"));
        assert_eq!(list.check_within(&(0..=9)), Ok(()));
    }
}
