//! An OBJ file's text in, its vertices and its faces by groups out. Invariant: every number is finite, every
//! index in range, and the corners of a group have all of the same parts.

use super::tally::Tally;
use super::text::{Statement, number, statements};
use crate::diagnostic::Loss;
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;
use std::path::Path;

/// A polygon with more corners is left out: cutting it up would take too long.
const MAX_CORNERS: usize = 2048;

/// Vertices, texture coordinates and normals of a file, in its order.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<Vec3>,
    /// In sRGB, one a position; none of a file without.
    pub(super) colors: Vec<Vec3>,
    pub(super) uvs: Vec<Vec2>,
    pub(super) normals: Vec<Vec3>,
    /// Whether each of `v`, `vt` and `vn` is to be used: its numbers are numbers, and a normal has a length.
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
            // `w` is the weight of a curve's point, and no polygon's.
            let numbers = statement.numbers().take(if kind == 0 { 6 } else { 3 }).map(number);
            let numbers: Vec<Option<f32>> = numbers.collect();
            let are_numbers = numbers.len() >= least && numbers.iter().all(Option::is_some);
            let is_good = are_numbers && (kind != 2 || numbers.iter().any(|number| *number != Some(0.0)));
            if !are_numbers {
                tally.add_at(Loss::ObjNumbers, keyword, (path, statement.line));
            }
            let value = |index: usize| numbers.get(index).copied().flatten().filter(|_| is_good);
            let [x, y, z] = [0, 1, 2].map(|index| value(index).unwrap_or(0.0));
            match kind {
                0 => vertices.positions.push(Vec3::new(x, y, z)),
                1 => vertices.uvs.push(Vec2::new(x, y)),
                _ => vertices.normals.push(Vec3::new(x, y, z)),
            }
            if kind == 0 && has_colors {
                let color = match [3, 4, 5].map(value) {
                    [Some(red), Some(green), Some(blue)] => Vec3::new(red, green, blue),
                    _ => Vec3::ONE,
                };
                if color != color.clamp(Vec3::ZERO, Vec3::ONE) {
                    tally.add_at(Loss::ObjVertexColors, "", (path, statement.line));
                }
                vertices.colors.push(color);
            }
            vertices.is_good[kind].push(is_good);
        }
        vertices
    }
}

/// Key of a group: the properties that its faces share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Group {
    /// Index into the materials; `usize::MAX` is none of them.
    pub(super) material: usize,
    pub(super) has_uvs: bool,
    pub(super) has_normals: bool,
    /// Faces of one number other than 0 are smooth where they meet, unless they have normals.
    pub(super) smoothing: u32,
}

/// Polygons of a group.
#[derive(Default, PartialEq)]
pub(super) struct Faces {
    /// Indices of their vertices, texture coordinates and normals; 0 of what the group has not.
    pub(super) corners: Vec<[u32; 3]>,
    /// Number of corners of each.
    pub(super) counts: Vec<usize>,
}

/// Faces by what they share.
pub(super) type Groups = BTreeMap<Group, Faces>;

/// Sorts the faces; `find` says which material a name after `usemtl` is.
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
                    let faces = groups.entry(group).or_default();
                    faces.counts.push(face.corners.len());
                    faces.corners.extend(face.corners);
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
            "s" => smoothing = smoothing_group(statement.numbers().next().unwrap_or("off")),
            "o" | "g" | "mtllib" => {}
            "l" | "p" => tally.add_at(Loss::PointsAndLines, statement.keyword(), at),
            other => tally.add_at(Loss::ObjStatement, other, at),
        }
    }
    groups
}

/// 0 is none; "on" is what some write for 1.
fn smoothing_group(word: &str) -> u32 {
    match word {
        "off" => 0,
        word => word.parse().unwrap_or(1),
    }
}

/// The corners of a face, each with the indices of its vertex, texture coordinate and normal.
struct Face {
    corners: Vec<[u32; 3]>,
    has: [bool; 3],
    /// Loss of the face.
    loss: Option<Loss>,
}

impl Face {
    fn read(statement: &Statement<'_>, vertices: &Vertices, so_far: [usize; 3]) -> Result<Self, Loss> {
        let (mut corners, mut has, mut any) = (Vec::<[u32; 3]>::new(), [true; 3], [false; 3]);
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
                let is_good = index.and_then(|index| vertices.is_good[kind].get(index).copied());
                match (kind, is_good) {
                    (0, None) => return Err(Loss::ObjFaceIndex),
                    (0, Some(false)) => return Err(Loss::ObjFaceVertex),
                    (_, None | Some(false)) => has[kind] = false,
                    (_, Some(true)) => corner[kind] = index.unwrap_or_default() as u32,
                }
            }
            corners.push(corner);
        }
        for corner in &mut corners {
            (0..3).filter(|&kind| !has[kind]).for_each(|kind| corner[kind] = 0);
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
}

/// The index from 0 that is meant: they count from 1, negative ones back from where they stand.
fn resolved(index: i64, so_far: usize) -> Option<usize> {
    let from_zero = if index < 0 { (so_far as i64).checked_add(index)? } else { index - 1 };
    usize::try_from(from_zero).ok()
}
