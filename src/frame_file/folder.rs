//! Frames of a folder, a sequence or a file. In goes a path, out come files by number. Invariant: temporary
//! files are ignored.

use super::FrameFileError;
use crate::description::signs;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Whether `path` may hold frames, by its name: a folder or an EXR file.
pub fn is_of_frames(path: &Path) -> bool {
    path.is_dir() || is_exr(path)
}

fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("exr"))
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Whether `path` may hold several frames: a folder, or a sequence such as `x.####.exr`.
pub fn is_of_many(path: &Path) -> bool {
    path.is_dir() || around_number(path).is_some()
}

/// Text before and after the number in the names of a sequence; `None` for an existing file.
fn around_number(path: &Path) -> Option<(&str, &str)> {
    let (before, _, after) = signs(path.file_name()?.to_str()?)?;
    (!path.exists()).then_some((before, after))
}

/// First folder in `input`, by name, with frames.
pub fn folder_below(input: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(input).ok()?;
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.sort();
    let has_frames = |folder: &PathBuf| frames_in(folder).is_ok_and(|files| !files.is_empty());
    folders.into_iter().find(|path| path.is_dir() && has_frames(path))
}

/// EXR files of a folder or a sequence, by the number at the end of their names; 0 without one. A file is its
/// only frame.
///
/// # Errors
/// If the folder cannot be read, or if two of its files have the same number.
pub fn frames_in(input: &Path) -> Result<BTreeMap<i64, PathBuf>, FrameFileError> {
    let sequence = around_number(input);
    let folder = match (sequence, input.parent()) {
        (None, _) if !input.is_dir() && is_exr(input) => {
            return Ok(BTreeMap::from([(number(&stem(input)), input.to_owned())]));
        }
        (None, _) => input,
        (Some(_), Some(folder)) if folder != Path::new("") => folder,
        (Some(_), _) => Path::new("."),
    };
    let is_asked_for = |path: &Path| {
        let Some((before, after)) = sequence else { return true };
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let number = name.strip_prefix(before).and_then(|rest| rest.strip_suffix(after));
        number.is_some_and(|number| number.parse::<i64>().is_ok())
    };
    let failed = |source| FrameFileError::Read { path: folder.to_owned(), source };
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    let mut paths: Vec<PathBuf> =
        entries.map(|entry| Ok(entry.map_err(failed)?.path())).collect::<Result<_, FrameFileError>>()?;
    paths.sort();
    let mut files = BTreeMap::new();
    for path in
        paths.into_iter().filter(|path| is_exr(path) && !stem(path).starts_with('.') && is_asked_for(path))
    {
        let number = number(&stem(&path));
        if let Some(other) = files.insert(number, path.clone()) {
            return Err(FrameFileError::SameNumber { path: other, other: path, number });
        }
    }
    Ok(files)
}

fn number(stem: &str) -> i64 {
    let (before, digits) = stem.split_at(stem.trim_end_matches(|c: char| c.is_ascii_digit()).len());
    let sign = if before == "-" || before.ends_with(".-") { -1 } else { 1 };
    sign * digits.parse::<i64>().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_in_numbers() {
        for (stem, expected) in [
            ("x.0012", 12),
            ("x.-0003", -3),
            ("take2.0007", 7),
            ("x", 0),
            ("0004", 4),
            ("x_9", 9),
            ("a-5", 5),
        ] {
            assert_eq!(number(stem), expected, "{stem}");
        }
    }
}
