//! Texture statements, `map_Kd` and its like. In goes the text after the keyword, out come a path and a
//! placement. Invariant: every option is honoured or listed as not honoured.

use glam::Vec2;
use std::path::{Path, PathBuf};

/// An image that an MTL file names.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjTexture {
    /// Path, beside the MTL file.
    pub path: PathBuf,
    /// Placement on the texture coordinates.
    pub placement: Placement,
    /// Whether it is clamped at its edges (`-clamp on`), or repeats.
    pub is_clamped: bool,
    /// Scale of its normal map (`-bm`).
    pub bump: f32,
    /// Options that are not honoured.
    pub(super) other_options: Vec<String>,
}

/// Placement of an image on texture coordinates whose `v` points up: `scale * uv + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// `-s`.
    pub scale: Vec2,
    /// `-o`.
    pub offset: Vec2,
}

impl Default for Placement {
    fn default() -> Self {
        Self { scale: Vec2::ONE, offset: Vec2::ZERO }
    }
}

impl Placement {
    /// Coordinates of the lookup; without the placement where they would not be finite.
    pub(super) fn apply(self, uv: Vec2) -> Vec2 {
        let placed = self.scale * uv + self.offset;
        if placed.is_finite() { placed } else { uv }
    }
}

/// Options with the maximum and minimum number of words after them.
const OPTIONS: [(&str, usize, usize); 14] = [
    ("-s", 3, 1),
    ("-o", 3, 1),
    ("-t", 3, 1),
    ("-mm", 2, 1),
    ("-bm", 1, 1),
    ("-boost", 1, 1),
    ("-texres", 1, 1),
    ("-blendu", 1, 1),
    ("-blendv", 1, 1),
    ("-clamp", 1, 1),
    ("-cc", 1, 1),
    ("-imfchan", 1, 1),
    ("-type", 1, 1),
    ("-colorspace", 1, 1),
];

impl ObjTexture {
    /// Parses options and a name, which may have spaces; `None` without a name.
    pub(super) fn read(text: &str, folder: &Path) -> Option<Self> {
        let mut texture = Self {
            path: PathBuf::new(),
            placement: Placement::default(),
            is_clamped: false,
            bump: 1.0,
            other_options: Vec::new(),
        };
        let mut rest = text.trim();
        while let Some((option, after)) = split_word(rest) {
            let Some((name, most, least)) =
                OPTIONS.iter().find(|(name, ..)| option.eq_ignore_ascii_case(name))
            else {
                break;
            };
            rest = after;
            let mut values = Vec::new();
            while values.len() < *most
                && let Some((word, after)) = split_word(rest)
                && (values.len() < *least || word.parse::<f32>().is_ok())
                // A name must remain.
                && !after.is_empty()
            {
                values.push(word);
                rest = after;
            }
            texture.set(name, &values);
        }
        texture.path = beside(folder, rest)?;
        Some(texture)
    }

    fn set(&mut self, option: &str, values: &[&str]) {
        let numbers: Vec<f32> = values.iter().filter_map(|word| super::text::number(word)).collect();
        let pair = |rest: f32| match numbers.as_slice() {
            [u, v, ..] => Some(Vec2::new(*u, *v)),
            [u] => Some(Vec2::new(*u, rest)),
            [] => None,
        };
        let is_on = values.first().is_some_and(|word| word.eq_ignore_ascii_case("on"));
        match option {
            "-s" => self.placement.scale = pair(1.0).unwrap_or(self.placement.scale),
            "-o" => self.placement.offset = pair(0.0).unwrap_or(self.placement.offset),
            "-clamp" => self.is_clamped = is_on,
            "-bm" => self.bump = numbers.first().copied().unwrap_or(self.bump),
            // These options are the default behaviour.
            "-blendu" | "-blendv" if is_on => {}
            "-colorspace" | "-texres" => {}
            "-cc" if !is_on => {}
            "-mm" if numbers == [0.0, 1.0] => {}
            "-t" if numbers.iter().all(|number| *number == 0.0) => {}
            other => self.other_options.push(other.to_owned()),
        }
    }
}

fn split_word(text: &str) -> Option<(&str, &str)> {
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    (end > 0).then(|| (&text[..end], text[end..].trim_start()))
}

/// Path of the file `name` in `folder`: as written, without quotes, with slashes for backslashes, or without
/// a comment; the first of these if none exists. `None` without a name.
pub(super) fn beside(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim();
    let name = name.strip_prefix('"').and_then(|name| name.strip_suffix('"')).unwrap_or(name);
    if name.is_empty() || name.contains('\0') {
        return None;
    }
    let without_comment = name.split(" #").next().unwrap_or(name).trim_end();
    let spellings = [name.to_owned(), name.replace('\\', "/"), without_comment.replace('\\', "/")];
    let found = spellings.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    Some(found.unwrap_or_else(|| folder.join(&spellings[1])))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn options_come_before_names_with_spaces() {
        let folder = Path::new("folder");
        for (text, name, scale, offset, others) in [
            ("leaf.png", "leaf.png", (1.0, 1.0), (0.0, 0.0), ""),
            (
                "-s 2 3 1 -o 0.5 0 0 -bm 0.5 -clamp on file name.png",
                "file name.png",
                (2.0, 3.0),
                (0.5, 0.0),
                "",
            ),
            ("-s 2 file name.png", "file name.png", (2.0, 1.0), (0.0, 0.0), ""),
            ("-s 1 1 1 2 leaves.png", "2 leaves.png", (1.0, 1.0), (0.0, 0.0), ""),
            ("-blendu on -mm 0.1 2 -type sphere a.png", "a.png", (1.0, 1.0), (0.0, 0.0), "-mm -type"),
            ("\"quoted name.png\"", "quoted name.png", (1.0, 1.0), (0.0, 0.0), ""),
            ("maps\\wood\\a.png", "maps/wood/a.png", (1.0, 1.0), (0.0, 0.0), ""),
            ("-dashed.png", "-dashed.png", (1.0, 1.0), (0.0, 0.0), ""),
            ("-s 3", "3", (1.0, 1.0), (0.0, 0.0), ""),
        ] {
            let texture = ObjTexture::read(text, folder).unwrap();
            assert_eq!(texture.path, folder.join(name), "{text}");
            assert_eq!(texture.placement, Placement { scale: scale.into(), offset: offset.into() }, "{text}");
            assert_eq!(texture.other_options.join(" "), others, "{text}");
        }
        assert_eq!(ObjTexture::read("  ", folder), None);
    }
}
