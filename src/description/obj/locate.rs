//! Lines of OBJ and MTL files. Invariant: nothing here decides whether a file is valid; it only
//! finds the line that another check refused, and counts what the reader passes over.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, Read, Result};

/// Counts the lines that a parser takes, so that its errors get a line.
pub(super) struct LineCounter<'a> {
    bytes: &'a [u8],
    taken: usize,
}

impl<'a> LineCounter<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, taken: 0 }
    }

    /// The line last taken, from 1.
    pub(super) fn line(&self) -> usize {
        let taken = &self.bytes[..self.taken];
        let ends = taken.iter().filter(|&&byte| byte == b'\n').count();
        if taken.last() == Some(&b'\n') { ends } else { ends + 1 }
    }
}

impl Read for LineCounter<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for LineCounter<'_> {
    fn fill_buf(&mut self) -> Result<&[u8]> {
        Ok(&self.bytes[self.taken..])
    }

    fn consume(&mut self, amount: usize) {
        self.taken = (self.taken + amount).min(self.bytes.len());
    }
}

/// Line numbers from 1, keyword and arguments of every line that has any.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (usize, &str, std::str::SplitWhitespace<'_>)> {
    text.lines().enumerate().filter_map(|(index, line)| {
        let mut words = line.split_whitespace();
        words.next().filter(|keyword| !keyword.starts_with('#')).map(|keyword| (index + 1, keyword, words))
    })
}

/// Turns lines and points into comments of the same length: tobj takes a line of three points for a face.
pub(super) fn comment_out_lines_and_points(bytes: &mut [u8]) {
    for line in bytes.split_mut(|&byte| byte == b'\n') {
        let start = line.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
        if matches!(&line[start..], [b'l' | b'p', after, ..] if after.is_ascii_whitespace()) {
            line[start] = b'#';
        }
    }
}

/// The first line with one of the keywords and a number that is not finite as `f32`.
pub(super) fn not_finite(text: &str, keywords: &[&str]) -> Option<usize> {
    statements(text)
        .find(|(_, keyword, words)| {
            keywords.contains(keyword)
                && words.clone().any(|word| word.parse().is_ok_and(|number: f32| !number.is_finite()))
        })
        .map(|(line, ..)| line)
}

/// The first face that refers to a vertex, texture coordinate or normal that the file does not have.
pub(super) fn face_out_of_range(text: &str) -> Option<(usize, String)> {
    let mut totals = [0_i64; 3];
    for (_, keyword, _) in statements(text) {
        if let Some(kind) = ["v", "vt", "vn"].iter().position(|known| *known == keyword) {
            totals[kind] += 1;
        }
    }
    let mut so_far = [0_i64; 3];
    for (line, keyword, words) in statements(text) {
        if let Some(kind) = ["v", "vt", "vn"].iter().position(|known| *known == keyword) {
            so_far[kind] += 1;
        } else if keyword == "f" {
            for word in words {
                for (kind, index) in word.split('/').enumerate().take(3) {
                    let Ok(index) = index.parse::<i64>() else { continue };
                    if index == 0 || index > totals[kind] || index < -so_far[kind] {
                        let what = ["vertices", "texture coordinates", "normals"][kind];
                        return Some((
                            line,
                            format!("the face refers to number {index} of {} {what}", totals[kind]),
                        ));
                    }
                }
            }
        }
    }
    None
}

/// What an OBJ file says beside the geometry.
#[derive(Default)]
pub(super) struct Census {
    /// Keywords that are not honoured, with their number and first line.
    pub(super) ignored: BTreeMap<String, (usize, usize)>,
    /// Names after `usemtl`.
    pub(super) material_names: BTreeSet<String>,
    /// Faces of fewer than three corners, and the first one's line.
    pub(super) thin_faces: Option<(usize, usize)>,
}

impl Census {
    pub(super) fn of(text: &str) -> Self {
        let mut census = Self::default();
        for (line, keyword, words) in statements(text) {
            match keyword {
                "v" | "vt" | "vn" | "o" | "g" | "mtllib" => {}
                "usemtl" => {
                    census.material_names.insert(words.collect::<Vec<_>>().join(" "));
                }
                "f" => {
                    if words.count() < 3 {
                        census.thin_faces.get_or_insert((0, line)).0 += 1;
                    }
                }
                other => census.ignored.entry(other.to_owned()).or_insert((0, line)).0 += 1,
            }
        }
        census
    }
}
