//! Pattern of output paths. In goes a frame's number, out comes the path of its file. Invariant: two frames
//! share a path only if the pattern has no placeholder, and [`OutputPattern::check`] then refuses more than
//! one frame. Bytes of a name that are not valid text are kept.
//!
//! | written | frame 7 |
//! |---|---|
//! | (nothing) | `out/NAME/NAME.0007.exr` |
//! | `DIR/` or a folder that exists | `DIR/NAME.0007.exr` |
//! | `x.####.exr`, `x.@@@@.exr`, `x.%04d.exr`, `x.%04i.exr` | `x.0007.exr` |
//! | `x.$F4.exr`, `x.${F4}.exr`, `x.<F4>.exr` | `x.0007.exr` |
//! | `x.#.exr`, `x.@.exr`, `x.%d.exr`, `x.$F.exr`, `x.${F}.exr`, `x.<F>.exr` | `x.7.exr` |
//! | `x.exr` | `x.exr`, for one frame only |
//!
//! In the name of an existing folder none of these is a placeholder.

use crate::diagnostic::{Diagnostic, Place, shown};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// Pattern of the paths of a sequence's frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputPattern {
    folder: PathBuf,
    before: OsString,
    /// Minimum digits of the number; `None` without a placeholder.
    digits: Option<usize>,
    after: OsString,
    /// Option of the command line that it comes from, such as `--out`.
    option: &'static str,
}

impl OutputPattern {
    /// Default pattern of a sequence.
    pub fn default_for(sequence_name: &str) -> Self {
        Self::in_folder(Path::new("out").join(sequence_name), sequence_name, "exr", "--out")
    }

    /// Parses the value of `--out`.
    ///
    /// # Errors
    /// If it is neither a folder nor the name of an EXR file, or has more than one placeholder.
    pub fn parse(text: impl AsRef<OsStr>, sequence_name: &str) -> Result<Self, Diagnostic> {
        Self::parse_as(text, sequence_name, "exr", "--out")
    }

    /// Parses a pattern for another extension or option.
    pub fn parse_as(
        text: impl AsRef<OsStr>,
        sequence_name: &str,
        extension: &str,
        option: &'static str,
    ) -> Result<Self, Diagnostic> {
        let path = Path::new(&text);
        let error = |why: &str| error(path, why, extension, option);
        let Some(last) = text.as_ref().as_encoded_bytes().last() else {
            return Err(error("the name is empty"));
        };
        if std::path::is_separator(char::from(*last)) || path.is_dir() {
            return Ok(Self::in_folder(path.to_owned(), sequence_name, extension, option));
        }
        let Some(file) = path.file_name().map(OsStr::as_encoded_bytes) else {
            return Err(error("it does not end in the name of a file"));
        };
        let placeholders = placeholders(file);
        if !path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension)) {
            if path.extension().is_none() && placeholders.is_empty() {
                return Ok(Self::in_folder(path.to_owned(), sequence_name, extension, option));
            }
            return Err(error(&format!("the file's name does not end in .{extension}"))
                .remedy(format!("end it in .{extension}, or in / if it is a folder")));
        }
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        // An existing folder is a folder, whatever its name.
        let folder_is_meant = folder.is_dir();
        if !folder_is_meant && !self::placeholders(folder.as_os_str().as_encoded_bytes()).is_empty() {
            return Err(error("the frame's number stands in a folder's name"));
        }
        let pattern = if folder_is_meant { Path::new(path.file_name().unwrap_or_default()) } else { path };
        if let Some(unknown) = unknown_placeholder(&pattern.to_string_lossy()) {
            return Err(error(&format!("`{unknown}` is no place for the frame's number")));
        }
        match placeholders.as_slice() {
            [] => Ok(Self {
                folder: folder.to_owned(),
                before: name_of(file),
                digits: None,
                after: OsString::new(),
                option,
            }),
            [only] => Ok(Self {
                folder: folder.to_owned(),
                before: name_of(&file[..only.start]),
                digits: Some(only.digits),
                after: name_of(&file[only.end..]),
                option,
            }),
            _ => Err(error("it has several places for the frame's number")),
        }
    }

    /// Pattern of files in a folder of any name, `NAME.0007.EXTENSION`.
    pub fn in_folder(folder: PathBuf, sequence_name: &str, extension: &str, option: &'static str) -> Self {
        let (before, after) = (format!("{sequence_name}.").into(), format!(".{extension}").into());
        Self { folder, before, digits: Some(4), after, option }
    }

    /// Refuses to write several frames to one file.
    ///
    /// # Errors
    /// If there is more than one frame and no placeholder.
    pub fn check(&self, frames: usize) -> Result<(), Diagnostic> {
        if self.digits.is_some() || frames <= 1 {
            return Ok(());
        }
        let only = self.path(0);
        let extension = only.extension().unwrap_or(OsStr::new("exr"));
        let mut numbered = only.file_stem().unwrap_or_default().to_owned();
        numbered.push(".####.");
        numbered.push(extension);
        let found = format!("{}: {frames} frames would all be written to {}", self.option, shown(&only));
        Err(Diagnostic::error(Place::Nowhere, found)
            .expected("a place for the frame's number: ####, %04d or $F4")
            .remedy(format!("write for instance {} {}", self.option, shown(&self.folder.join(numbered)))))
    }

    /// Path of a frame's file. A negative number has as many digits as others, after its sign.
    pub fn path(&self, frame: i64) -> PathBuf {
        let number = self.digits.map_or_else(String::new, |digits| {
            let sign = if frame < 0 { "-" } else { "" };
            format!("{sign}{:0digits$}", frame.unsigned_abs())
        });
        let mut name = self.before.clone();
        name.push(number);
        name.push(&self.after);
        self.folder.join(name)
    }

    /// Folder of all frames.
    pub fn folder(&self) -> &Path {
        if self.folder.as_os_str().is_empty() { Path::new(".") } else { &self.folder }
    }
}

/// Placeholder of the frame's number: bytes `start..end` of a name.
struct Placeholder {
    start: usize,
    end: usize,
    digits: usize,
}

/// Part of a name, cut at ASCII characters. Only Unix allows names that are not valid text.
fn name_of(bytes: &[u8]) -> OsString {
    #[cfg(unix)]
    return std::os::unix::ffi::OsStringExt::from_vec(bytes.to_vec());
    #[cfg(not(unix))]
    String::from_utf8_lossy(bytes).into_owned().into()
}

fn placeholders(bytes: &[u8]) -> Vec<Placeholder> {
    /// Maximum digits; longer runs are most likely typing errors.
    const MOST_DIGITS: usize = 18;
    let run =
        |from: usize, wanted: fn(&u8) -> bool| bytes[from..].iter().take_while(|&byte| wanted(byte)).count();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        // Text before the width, and the alternatives after it.
        let framed = |before: &str, after: &[&str]| {
            let from = at + before.len();
            let width = bytes[at..].starts_with(before.as_bytes()).then(|| run(from, u8::is_ascii_digit))?;
            let end = after.iter().find(|end| bytes[from + width..].starts_with(end.as_bytes()))?;
            Some((before.len() + width + end.len(), number(&bytes[from..from + width])))
        };
        let (length, digits) = match bytes[at] {
            mark @ (b'#' | b'@') => {
                let marks = bytes[at..].iter().take_while(|&&byte| byte == mark).count();
                (marks, marks)
            }
            b'%' => framed("%", &["d", "i"]).unwrap_or_default(),
            b'$' => framed("${F", &["}"]).or_else(|| framed("$F", &[""])).unwrap_or_default(),
            b'<' => framed("<F", &[">"]).unwrap_or_default(),
            _ => (0, 0),
        };
        if length > 0 {
            found.push(Placeholder { start: at, end: at + length, digits: digits.clamp(1, MOST_DIGITS) });
        }
        at += length.max(1);
    }
    found
}

/// Placeholder of other programs that is not supported: `%s`, `${SHOT}`, `<UDIM>`, `$SHOT`.
fn unknown_placeholder(name: &str) -> Option<&str> {
    let places = placeholders(name.as_bytes());
    let between = std::iter::once(0).chain(places.iter().map(|place| place.end));
    let until = places.iter().map(|place| place.start).chain([name.len()]);
    let literal = between.zip(until).map(|(start, end)| &name[start..end]);
    let is_word = |text: &str| text.chars().next().is_some_and(|first| first.is_ascii_alphabetic());
    literal.into_iter().find_map(|text| {
        let closed = |open: &str, close: char| {
            let (at, _) = text.match_indices(open).find(|(at, _)| is_word(&text[at + open.len()..]))?;
            let end = text[at..].find(close)?;
            Some(&text[at..=at + end])
        };
        let conversion = || {
            let (at, _) = text
                .match_indices('%')
                .find(|(at, _)| is_word(text[at + 1..].trim_start_matches(|c: char| c.is_ascii_digit())))?;
            Some(text[at..].split_inclusive(|c: char| c.is_ascii_alphabetic()).next().unwrap_or("%"))
        };
        let variable = || {
            let (at, _) = text.match_indices('$').find(|(at, _)| is_word(&text[at + 1..]))?;
            Some(text[at..].split(|c: char| !c.is_alphanumeric() && c != '$').next().unwrap_or("$"))
        };
        closed("${", '}').or_else(|| closed("<", '>')).or_else(variable).or_else(conversion)
    })
}

/// Number of digits from decimal `digits`; empty is 1, and large values saturate for the caller to limit.
fn number(digits: &[u8]) -> usize {
    let add = |number: usize, digit: &u8| number.saturating_mul(10).saturating_add(usize::from(digit - b'0'));
    if digits.is_empty() { 1 } else { digits.iter().fold(0, add) }
}

fn error(path: &Path, why: &str, extension: &str, option: &str) -> Diagnostic {
    let example = format!("out/name.####.{extension}");
    Diagnostic::error(Place::Nowhere, format!("{option}: cannot write frames to `{}`: {why}", shown(path)))
        .expected(format!("a folder, or a file name with a place for the frame's number, such as {example}"))
        .remedy(format!("write for instance {option} {example}"))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_patterns() {
        for (text, frame, expected) in [
            ("a/x.####.exr", 7, "a/x.0007.exr"),
            ("a/x.####.exr", 12345, "a/x.12345.exr"),
            ("a/x.####.exr", -7, "a/x.-0007.exr"),
            ("x_%04d.exr", 7, "x_0007.exr"),
            ("x_%d.exr", 7, "x_7.exr"),
            ("x.$F4.exr", 7, "x.0007.exr"),
            ("x.$F.exr", 7, "x.7.exr"),
            ("x.#.EXR", 7, "x.7.EXR"),
            ("x.@@@@.exr", 7, "x.0007.exr"),
            ("x.@.exr", 7, "x.7.exr"),
            ("x.%03i.exr", 7, "x.007.exr"),
            ("x.${F4}.exr", 7, "x.0007.exr"),
            ("x.${F}.exr", 7, "x.7.exr"),
            ("x.<F4>.exr", 7, "x.0007.exr"),
            ("x.<F>.exr", 7, "x.7.exr"),
            ("50% done/x.$F4.exr", 7, "50% done/x.0007.exr"),
            ("####.exr", 7, "0007.exr"),
            ("100%.####.exr", 7, "100%.0007.exr"),
            ("x.exr", 7, "x.exr"),
            ("some/where/", 7, "some/where/name.0007.exr"),
            ("some/where", 7, "some/where/name.0007.exr"),
            ("/", 7, "/name.0007.exr"),
        ] {
            let pattern = OutputPattern::parse(text, "name").unwrap();
            assert_eq!(pattern.path(frame), Path::new(expected), "{text}");
        }
        let pictures = OutputPattern::parse_as("a/x.##.png", "name", "png", "--out").unwrap();
        assert_eq!(pictures.path(3), Path::new("a/x.03.png"));
        assert!(
            OutputPattern::parse_as("a/x.##.exr", "name", "png", "--out")
                .unwrap_err()
                .to_string()
                .contains(".png")
        );
        assert_eq!(OutputPattern::default_for("fall").path(3), Path::new("out/fall/fall.0003.exr"));
        assert_eq!(OutputPattern::default_for("a#%d").path(3), Path::new("out/a#%d/a#%d.0003.exr"));
    }

    #[test]
    #[cfg(unix)]
    fn bytes_that_are_no_text_are_kept() {
        use std::os::unix::ffi::OsStrExt;
        for (text, expected) in [
            (&b"a\xff/x\xfe.##.exr"[..], &b"a\xff/x\xfe.07.exr"[..]),
            (b"x\xff%03d\xc3.exr", b"x\xff007\xc3.exr"),
            (b"a\xff/", b"a\xff/name.0007.exr"),
            (b"\xff", b"\xff/name.0007.exr"),
            (b"\xff.exr", b"\xff.exr"),
        ] {
            let pattern = OutputPattern::parse(OsStr::from_bytes(text), "name").unwrap();
            assert_eq!(pattern.path(7).as_os_str().as_bytes(), expected);
        }
        let one_file = OutputPattern::parse(OsStr::from_bytes(b"x\xff.exr"), "name").unwrap();
        assert!(one_file.check(2).unwrap_err().to_string().contains("--out x\\xff.####.exr"));
    }

    #[test]
    fn a_folder_with_a_dot_is_one_if_it_exists() {
        let folder = tempfile::tempdir().unwrap();
        let dotted = folder.path().join("take.2");
        assert!(OutputPattern::parse(dotted.to_str().unwrap(), "n").is_err());
        std::fs::create_dir(&dotted).unwrap();
        let pattern = OutputPattern::parse(dotted.to_str().unwrap(), "n").unwrap();
        assert_eq!(pattern.path(1), dotted.join("n.0001.exr"));
    }

    #[test]
    fn what_cannot_be_a_pattern_is_refused_with_a_remedy() {
        for text in [
            "",
            "x.png",
            "x.####",
            "x.##.@@.exr",
            "x.%s.exr",
            "x.${SHOT}.exr",
            "x.$SHOT.##.exr",
            "x.<UDIM>.exr",
            "<F4>/x.exr",
            "$OUT/x.##.exr",
            "x.##.##.exr",
            "x.##.%d.exr",
            "##/x.##.exr",
            "a/..",
        ] {
            let error = OutputPattern::parse(text, "name").unwrap_err();
            assert!(error.remedy.is_some() && error.expected.is_some(), "{text}");
        }
    }

    #[test]
    fn several_frames_need_a_place_for_their_number() {
        let one_file = OutputPattern::parse("a/x.exr", "name").unwrap();
        assert_eq!(one_file.check(1), Ok(()));
        assert!(one_file.check(2).unwrap_err().remedy.unwrap().contains("a/x.####.exr"));
        assert_eq!(OutputPattern::parse("x.#.exr", "name").unwrap().check(2), Ok(()));
    }
}
