//! Normalization of OBJ text. In goes a file's text, out comes text that tobj reads without changes.
//! Invariant: every number is finite, every index is in range and positive, and the corners of a group have
//! the same parts.

use super::tally::Tally;
use super::text::{Statement, number, statements};
use crate::diagnostic::Loss;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Maximum number of corners of a polygon: triangulation of larger ones would take too long.
const MAX_CORNERS: usize = 2048;

/// Vertices, texture coordinates and normals of a file, in its order.
#[derive(Default)]
pub(super) struct Vertices {
    /// Their statements.
    pub(super) text: String,
    /// Whether each of `v`, `vt` and `vn` is usable: its numbers are finite, and a normal has a length.
    is_good: [Vec<bool>; 3],
}

const KINDS: [(&str, usize); 3] = [("v", 3), ("vt", 1), ("vn", 3)];

fn kind_of(statement: &Statement<'_>) -> Option<usize> {
    KINDS.iter().position(|(keyword, _)| *keyword == statement.keyword())
}

impl Vertices {
    pub(super) fn of(text: &str, path: &Path, tally: &mut Tally) -> Self {
        let mut vertices = Self::default();
        let has_colors = statements(text)
            .any(|statement| statement.keyword() == "v" && statement.numbers().take(6).count() == 6);
        for statement in statements(text) {
            let Some(kind) = kind_of(&statement) else { continue };
            let (keyword, least) = KINDS[kind];
            // `w` is a weight for curves, and has no effect on polygons.
            let numbers: Vec<&str> = statement.numbers().take(if kind == 0 { 6 } else { 3 }).collect();
            let are_numbers = numbers.len() >= least && numbers.iter().all(|word| number(word).is_some());
            let is_good = are_numbers && (kind != 2 || numbers.iter().any(|word| number(word) != Some(0.0)));
            if !are_numbers {
                tally.add_at(Loss::ObjNumbers, keyword, (path, statement.line));
            }
            let word = |index: usize| numbers.get(index).copied().filter(|_| is_good).unwrap_or("0");
            // Writing to a string cannot fail.
            let _ = write!(vertices.text, "{keyword} {} {}", word(0), word(1));
            if kind != 1 {
                let _ = write!(vertices.text, " {}", word(2));
            }
            if kind == 0 && has_colors {
                let color = if is_good && numbers.len() == 6 { [3, 4, 5].map(word) } else { ["1"; 3] };
                if color.iter().any(|word| number(word).is_none_or(|share| !(0.0..=1.0).contains(&share))) {
                    tally.add_at(Loss::ObjVertexColors, "", (path, statement.line));
                }
                let _ = write!(vertices.text, " {}", color.join(" "));
            }
            vertices.text.push('\n');
            vertices.is_good[kind].push(is_good);
        }
        vertices
    }
}

/// Key of a group: the properties that its faces share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Group {
    /// Index into the materials; `usize::MAX` for no material.
    pub(super) material: usize,
    pub(super) has_uvs: bool,
    pub(super) has_normals: bool,
    /// Smoothing group: faces with the same number other than 0 are smooth where they meet, unless they have
    /// normals.
    pub(super) smoothing: u32,
}

/// Faces of each group, as statements with indices from 1.
pub(super) type Groups = BTreeMap<Group, String>;

/// Sorts the faces into groups; `find` maps a name after `usemtl` to its material.
pub(super) fn faces(
    text: &str,
    path: &Path,
    vertices: &Vertices,
    find: impl Fn(&str) -> Option<usize>,
    tally: &mut Tally,
) -> Groups {
    let mut groups = Groups::new();
    let mut so_far = [0; 3];
    let (mut material, mut smoothing) = (usize::MAX, 0);
    for statement in statements(text) {
        let at = (path, statement.line);
        if let Some(kind) = kind_of(&statement) {
            so_far[kind] += 1;
            continue;
        }
        match statement.keyword() {
            "f" | "fo" => match Face::read(&statement, vertices, so_far) {
                Ok(face) => {
                    if let Some(loss) = face.loss {
                        tally.add_at(loss, "", at);
                    }
                    let [_, has_uvs, has_normals] = face.has;
                    let smoothing = if has_normals { 0 } else { smoothing };
                    let group = Group { material, has_uvs, has_normals, smoothing };
                    face.write(groups.entry(group).or_default());
                }
                Err(loss) => tally.add_at(loss, "", at),
            },
            "usemtl" => {
                let found = find(statement.rest());
                if found.is_none() {
                    tally.add_at(Loss::ObjMaterialMissing, statement.rest(), at);
                }
                material = found.unwrap_or(usize::MAX);
            }
            // 0 is none, and "on" is 1.
            "s" => {
                smoothing = match statement.numbers().next() {
                    None | Some("off") => 0,
                    Some(word) => word.parse().unwrap_or(1),
                }
            }
            "o" | "g" | "mtllib" => {}
            "l" | "p" => tally.add_at(Loss::PointsAndLines, statement.keyword(), at),
            other => tally.add_at(Loss::ObjStatement, other, at),
        }
    }
    groups
}

/// Corners of a face, each with the indices of its vertex, texture coordinate and normal, from 1.
struct Face {
    corners: Vec<[usize; 3]>,
    has: [bool; 3],
    loss: Option<Loss>,
}

impl Face {
    fn read(statement: &Statement<'_>, vertices: &Vertices, so_far: [usize; 3]) -> Result<Self, Loss> {
        let (mut corners, mut has, mut any) = (Vec::new(), [true; 3], [false; 3]);
        for word in statement.numbers() {
            let mut corner = [0; 3];
            if word.split('/').count() > 3 {
                return Err(Loss::ObjNumbers);
            }
            let mut parts = word.split('/');
            for kind in 0..3 {
                let part = parts.next().unwrap_or_default();
                any[kind] |= !part.is_empty();
                let index = match part {
                    "" => None,
                    part => resolved(part.parse().map_err(|_| Loss::ObjNumbers)?, so_far[kind]),
                };
                let is_good = index.and_then(|index| vertices.is_good[kind].get(index - 1).copied());
                match (kind, is_good) {
                    (0, None) => return Err(Loss::ObjFaceIndex),
                    (0, Some(false)) => return Err(Loss::ObjFaceVertex),
                    (_, None | Some(false)) => has[kind] = false,
                    (_, Some(true)) => corner[kind] = index.unwrap_or_default(),
                }
            }
            corners.push(corner);
        }
        let loss = match (has, any) {
            ([_, _, false], [_, _, true]) => Some(Loss::ObjNormals),
            ([_, false, _], [_, true, _]) => Some(Loss::ObjTextureCoordinates),
            _ => None,
        };
        match corners.len() {
            0..3 => Err(Loss::ObjThinFace),
            3..=MAX_CORNERS => Ok(Self { corners, has, loss }),
            _ => Err(Loss::ObjFaceCorners),
        }
    }

    fn write(&self, text: &mut String) {
        text.push('f');
        for [vertex, uv, normal] in &self.corners {
            // Writing to a string cannot fail.
            let _ = match self.has {
                [_, false, false] => write!(text, " {vertex}"),
                [_, true, false] => write!(text, " {vertex}/{uv}"),
                [_, false, true] => write!(text, " {vertex}//{normal}"),
                [_, true, true] => write!(text, " {vertex}/{uv}/{normal}"),
            };
        }
        text.push('\n');
    }
}

/// Resolved index from 1; negative ones count back from the statement.
fn resolved(index: i64, so_far: usize) -> Option<usize> {
    let from_one = if index < 0 { (so_far as i64).checked_add(index)?.checked_add(1)? } else { index };
    usize::try_from(from_one).ok().filter(|&index| index > 0)
}
