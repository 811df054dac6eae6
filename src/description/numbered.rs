//! Numbered files, one a frame. In goes a path with a placeholder, `leaf.####.obj` or `leaf.%04d.obj`, out
//! come its files. Invariant: their numbers have no gap.

use super::LoadError;
use crate::diagnostic::{Diagnostic, Place};
use std::fs;
use std::io;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Maximum magnitude of a frame's number.
const FARTHEST: u64 = 1_000_000_000;
/// Maximum number of signs in a placeholder.
const MOST_DIGITS: usize = 20;
/// Minimum number of digits of frames: shorter numbers often name variants, such as `oak1.obj`.
const FEWEST_DIGITS: usize = 3;

/// File name with a placeholder.
#[derive(Debug, PartialEq)]
pub(super) struct Numbered<'a> {
    path: &'a Path,
    before: &'a str,
    /// Minimum number of digits.
    digits: usize,
    after: &'a str,
}

impl<'a> Numbered<'a> {
    /// Pattern of a path; `None` without a placeholder, or if the path is an existing file.
    pub(super) fn of(path: &'a Path) -> Option<Self> {
        let name = path.file_name()?.to_str()?;
        let (before, digits, after) = signs(name)?;
        (!path.is_file()).then_some(Self { path, before, digits, after })
    }

    /// Common name of all files, without number and ending.
    pub(super) fn name(&self) -> &'a str {
        self.before.trim_end_matches(['.', '_', '-', ' '])
    }

    /// Sequence that contains a file, by the last digits of its name; `None` if the file is alone.
    pub(super) fn around(path: &Path) -> Option<PathBuf> {
        let name = path.file_name()?.to_str()?;
        let (upto, after) = name.split_at(name.rfind(|letter: char| letter.is_ascii_digit())? + 1);
        let before = upto.trim_end_matches(|letter: char| letter.is_ascii_digit());
        let digits = upto.len() - before.len();
        let name = format!("{before}{}{after}", "#".repeat(digits));
        let path = path.with_file_name(&name);
        let is_sequence = digits >= FEWEST_DIGITS && Numbered::of(&path)?.there().ok()?.len() > 1;
        is_sequence.then_some(path)
    }

    /// Range of the existing files' numbers; `referrer` is the place that refers to them.
    ///
    /// # Errors
    /// If there are none, or one between the first and the last is missing.
    pub(super) fn numbers(&self, referrer: &str) -> Result<RangeInclusive<i64>, LoadError> {
        let numbers = self.there().map_err(|source| LoadError::Io {
            path: self.folder().to_owned(),
            referrer: Some(referrer.to_owned()),
            source,
        })?;
        let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else {
            let found = "no file is called so, with a number in the place of the signs";
            let expected = format!("files such as `{}` and `{}`", self.file_name(1), self.file_name(2));
            return Err(Diagnostic::error(Place::File(self.path.to_owned()), found)
                .expected(expected)
                .remedy(format!("check the path in {referrer}, and how many digits there are"))
                .into());
        };
        if let Some(pair) = numbers.windows(2).find(|pair| pair[0].checked_add(1) != Some(pair[1])) {
            let found = format!("this file is missing in the sequence `{}`", self.path.display());
            return Err(Diagnostic::error(Place::File(self.file(pair[0] + 1)), found)
                .expected(format!("a file for each number from {first} to {last}"))
                .remedy("export the missing frames, or number the files without gaps")
                .into());
        }
        Ok(first..=last)
    }

    fn folder(&self) -> &Path {
        self.path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."))
    }

    fn there(&self) -> io::Result<Vec<i64>> {
        let names =
            fs::read_dir(self.folder())?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let mut numbers: Vec<i64> = names.filter_map(|name| self.number(&name)).collect();
        numbers.sort_unstable();
        Ok(numbers)
    }

    pub(super) fn file(&self, number: i64) -> PathBuf {
        self.path.with_file_name(self.file_name(number))
    }

    fn file_name(&self, number: i64) -> String {
        format!("{}{number:0width$}{}", self.before, self.after, width = self.digits)
    }

    fn number(&self, name: &str) -> Option<i64> {
        let digits = name.strip_prefix(self.before)?.strip_suffix(self.after)?;
        let number: i64 = digits.parse().ok()?;
        // Other spellings of a number belong to other sequences.
        (number.unsigned_abs() <= FARTHEST && self.file_name(number) == name).then_some(number)
    }
}

/// Splits a name at a placeholder such as `####` or `%04d`: the text before, the minimum number of digits,
/// the text after.
pub fn signs(name: &str) -> Option<(&str, usize, &str)> {
    hashes(name).or_else(|| percent(name))
}

/// The last run of number signs.
fn hashes(name: &str) -> Option<(&str, usize, &str)> {
    let (upto, after) = name.split_at(name.rfind('#')? + 1);
    let before = upto.trim_end_matches('#');
    let digits = upto.len() - before.len();
    (digits <= MOST_DIGITS).then_some((before, digits, after))
}

/// Placeholder `%d` or `%04d`, as in `printf`.
fn percent(name: &str) -> Option<(&str, usize, &str)> {
    let (before, rest) = name.rsplit_once('%')?;
    let (digits, after) = rest.split_once('d')?;
    match digits {
        "" => Some((before, 1, after)),
        digits if digits.starts_with('0') && digits.len() < 3 => Some((before, digits.parse().ok()?, after)),
        _ => None,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn numbers(names: &[&str], asked: &str) -> Result<RangeInclusive<i64>, String> {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let path = folder.path().join(asked);
        Numbered::of(&path)
            .unwrap()
            .numbers("scene.ron: meshes.leaf")
            .map_err(|error| error.diagnostics().to_string())
    }

    #[test]
    fn signs_stand_for_numbers() {
        let names =
            ["a.0009.obj", "a.0010.obj", "a.0011.mtl", "a.011.obj", "b.0011.obj", "a.x.obj", "a.+011.obj"];
        for asked in ["a.####.obj", "a.%04d.obj"] {
            assert_eq!(numbers(&names, asked), Ok(9..=10));
        }
        assert_eq!(numbers(&names, "a.###.obj"), Ok(11..=11));
        let unpadded = ["l9", "l10", "l-1", "l0", "l8", "l7", "l1", "l2", "l3", "l4", "l5", "l6"];
        assert_eq!(numbers(&unpadded, "l%d"), Ok(-1..=10));
        assert_eq!(numbers(&unpadded, "l#"), Ok(-1..=10));
        assert_eq!(numbers(&["f.9999.obj", "f.10000.obj"], "f.####.obj"), Ok(9999..=10000));
    }

    #[test]
    fn gaps_and_nothing_at_all_are_told() {
        let told = numbers(&["a.1.obj", "a.2.obj", "a.4.obj", "a.9.obj"], "a.#.obj").unwrap_err();
        assert!(told.contains("a.3.obj: error: this file is missing"), "{told}");
        assert!(told.contains("each number from 1 to 9"), "{told}");
        let told = numbers(&["a.1.obj"], "a.####.obj").unwrap_err();
        assert!(told.contains("`a.0001.obj`") && told.contains("scene.ron: meshes.leaf"), "{told}");
        let far = ["a.-1000000000.obj", "a.1000000000.obj", "a.-9223372036854775808.obj"];
        let told = numbers(&far, "a.#.obj").unwrap_err();
        assert!(told.contains("is missing") && told.contains("to 1000000000"), "{told}");
    }

    #[test]
    fn a_file_stands_in_a_sequence_or_alone() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.0001.obj", "a.0002.obj", "b.0001.obj", "oak1.obj", "oak2.obj", "x.obj", "7"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let around = |name: &str| Numbered::around(&folder.path().join(name));
        assert_eq!(around("a.0002.obj"), Some(folder.path().join("a.####.obj")));
        for name in ["b.0001.obj", "oak1.obj", "x.obj", "7", "none/a.0001.obj"] {
            assert_eq!(around(name), None, "{name}");
        }
    }

    #[test]
    fn other_names_are_files() {
        assert_eq!(Numbered::of(Path::new(&"#".repeat(100_000))), None);
        for name in ["leaf.0001.obj", "100%.obj", "50%wood.obj", "%4d.obj", "%0999d.obj", ".."] {
            assert_eq!(Numbered::of(Path::new(name)), None, "{name}");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("leaf #2.obj");
        fs::write(&path, "").unwrap();
        assert_eq!(Numbered::of(&path), None);
        assert_eq!(Numbered::of(Path::new("oak_leaf-####.obj")).unwrap().name(), "oak_leaf");
    }
}
