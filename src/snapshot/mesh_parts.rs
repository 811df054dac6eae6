//! Connected parts of a mesh: leaves, bodies, walls. In goes a mesh, out come its parts and places that
//! represent them. Invariant: all is chosen in mesh space, so a moving part keeps its places; in world space
//! rounding would choose others from frame to frame.

use super::self_shading::exposed;
use crate::scene::{Mesh, Scene};
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::sync::OnceLock;

/// A connected set of triangles.
#[derive(Clone, Debug)]
pub struct MeshPart {
    /// Numbers of the triangles.
    pub triangles: Vec<u32>,
    /// Lower corner of its bounds, in mesh space.
    pub low: DVec3,
    /// Upper corner of its bounds.
    pub high: DVec3,
    /// Whether it is a closed surface.
    pub is_closed: bool,
    /// Share of its area on both sides that its other triangles do not hide, weighted by irradiance: 1 if
    /// flat, a half for a ball.
    pub exposed: f64,
    /// Places that represent the part.
    pub places: Vec<PartPlace>,
    /// Fewer places, for a part that is small in its context.
    pub few_places: Vec<PartPlace>,
}

/// A triangle that represents a share of its part.
#[derive(Clone, Copy, Debug)]
pub struct PartPlace {
    /// Number of the triangle.
    pub triangle: u32,
    /// Share of the part's area that it represents, divided by the triangle's area in mesh space.
    pub share: f64,
    /// Area that it represents, in mesh space.
    pub area: f64,
}

/// Number of places of a part that is as wide as it is long.
const PLACES: f64 = 8.0;
const FEW_PLACES: f64 = 2.0;
/// Ratio of length to width above which a part has no more places.
const MOST_SLENDER: f64 = 8.0;

/// Parts of each of a scene's meshes, computed on first use.
#[derive(Debug, Default)]
pub(super) struct MeshParts(Vec<OnceLock<Parts>>);

#[derive(Debug)]
struct Parts {
    parts: Vec<MeshPart>,
    part_of: Vec<u32>,
}

impl MeshParts {
    pub(super) fn new(scene: &Scene) -> Self {
        Self(scene.meshes.iter().map(|_| OnceLock::new()).collect())
    }

    pub(super) fn of(&self, (number, mesh): (usize, &Mesh)) -> &[MeshPart] {
        &self.0[number].get_or_init(|| Parts::of(mesh)).parts
    }

    pub(super) fn part_of(&self, (number, mesh): (usize, &Mesh), triangle: u32) -> usize {
        self.0[number].get_or_init(|| Parts::of(mesh)).part_of[triangle as usize] as usize
    }
}

impl Parts {
    fn of(mesh: &Mesh) -> Self {
        let parts = parts(mesh);
        let mut part_of = vec![0; mesh.triangles.len()];
        for (part, number) in parts.iter().zip(0..) {
            part.triangles.iter().for_each(|&triangle| part_of[triangle as usize] = number);
        }
        Self { parts, part_of }
    }
}

/// The parts of a mesh, in the order of their first triangles.
fn parts(mesh: &Mesh) -> Vec<MeshPart> {
    let names = welded(&mesh.positions);
    let mut sets = Sets::new(mesh.positions.len());
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.vertices.map(|vertex| names[vertex as usize]);
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut number_of_root = HashMap::new();
    let mut triangles: Vec<Vec<u32>> = Vec::new();
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let root = sets.root(names[triangle.vertices[0] as usize]);
        let part = *number_of_root.entry(root).or_insert(triangles.len());
        if part == triangles.len() {
            triangles.push(Vec::new());
        }
        triangles[part].push(number as u32);
    }
    let count = triangles.len();
    triangles.into_iter().map(|triangles| part(mesh, &names, triangles, count)).collect()
}

fn part(mesh: &Mesh, names: &[u32], triangles: Vec<u32>, count: usize) -> MeshPart {
    let corners = |triangle: u32| {
        mesh.triangles[triangle as usize].vertices.map(|vertex| mesh.positions[vertex as usize].as_dvec3())
    };
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let mut areas = Vec::with_capacity(triangles.len());
    for &triangle in &triangles {
        let [a, b, c] = corners(triangle);
        low = low.min(a).min(b).min(c);
        high = high.max(a).max(b).max(c);
        areas.push(0.5 * (b - a).cross(c - a).length());
    }
    let [places, few_places] =
        [PLACES, FEW_PLACES].map(|count| places(&triangles, &areas, count * slenderness(high - low)));
    let is_closed = is_closed(mesh, names, &triangles);
    let all: Vec<[DVec3; 3]> = triangles.iter().map(|&triangle| corners(triangle)).collect();
    let exposed = exposed(&all, &areas, count);
    MeshPart { triangles, low, high, is_closed, exposed, places, few_places }
}

/// Ratio of the longest side to the next.
fn slenderness(extent: DVec3) -> f64 {
    let mut sides = extent.to_array();
    sides.sort_by(f64::total_cmp);
    (sides[2] / sides[1]).min(MOST_SLENDER)
}

/// Places of a part, evenly distributed over its area.
fn places(triangles: &[u32], areas: &[f64], count: f64) -> Vec<PartPlace> {
    let whole: f64 = areas.iter().sum();
    if !(whole > 0.0 && whole.is_finite()) {
        return Vec::new();
    }
    let count = count.min(triangles.len() as f64).ceil() as usize;
    let step = whole / count as f64;
    let mut places = Vec::with_capacity(count);
    let mut so_far = 0.0;
    for (&triangle, &area) in triangles.iter().zip(areas) {
        let before = so_far;
        so_far += area;
        // Number of marks on the triangle: the first half a step after the start, then one for each step.
        let marks = (so_far / step + 0.5).floor() - (before / step + 0.5).floor();
        if marks > 0.0 && area > 0.0 {
            places.push(PartPlace { triangle, share: marks * step / area, area: marks * step });
        }
    }
    places
}

/// Whether every edge is shared by two triangles of consistent orientation.
fn is_closed(mesh: &Mesh, names: &[u32], triangles: &[u32]) -> bool {
    let mut open: HashMap<(u32, u32), i32> = HashMap::new();
    for &triangle in triangles {
        let [a, b, c] = mesh.triangles[triangle as usize].vertices.map(|vertex| names[vertex as usize]);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if from == to {
                continue;
            }
            let (edge, way) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            *open.entry(edge).or_default() += way;
        }
    }
    triangles.len() > 3 && open.values().all(|ways| *ways == 0)
}

/// First vertex at the same position, for each vertex.
fn welded(positions: &[Vec3]) -> Vec<u32> {
    let mut first = HashMap::with_capacity(positions.len());
    positions
        .iter()
        .zip(0..)
        .map(|(position, number)| {
            *first.entry(position.to_array().map(|x| (x + 0.0).to_bits())).or_insert(number)
        })
        .collect()
}

/// Sets of connected vertices: union-find with path halving.
struct Sets(Vec<u32>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn root(&mut self, mut vertex: u32) -> u32 {
        while self.0[vertex as usize] != vertex {
            let grandparent = self.0[self.0[vertex as usize] as usize];
            self.0[vertex as usize] = grandparent;
            vertex = grandparent;
        }
        vertex
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Triangle;

    fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        Mesh {
            positions: positions.iter().map(|position| Vec3::from_array(*position)).collect(),
            triangles: triangles.iter().map(|&vertices| Triangle { vertices, material: 0 }).collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn quads_that_share_no_place_are_two_parts() {
        let quad = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 2.0, 0.0], [x, 2.0, 0.0]];
        let positions: Vec<_> = quad(0.0).into_iter().chain(quad(5.0)).collect();
        let found = parts(&mesh(&positions, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]));
        assert_eq!(found.len(), 2);
        for part in &found {
            assert_eq!((part.high - part.low, part.is_closed), (DVec3::new(1.0, 2.0, 0.0), false));
            assert_eq!(part.places.iter().map(|place| place.share).sum::<f64>(), 2.0);
        }
    }

    /// Its corners occur three times, as in files with different normals.
    #[test]
    fn a_tetrahedron_is_closed_and_one_without_a_face_is_not() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let positions: Vec<_> = faces.iter().flatten().map(|&corner: &usize| corners[corner]).collect();
        let triangles: Vec<[u32; 3]> = (0..4).map(|face| [0, 1, 2].map(|corner| 3 * face + corner)).collect();
        assert!(parts(&mesh(&positions, &triangles))[0].is_closed);
        assert_eq!(parts(&mesh(&positions, &triangles))[0].exposed, 0.5);
        assert!(!parts(&mesh(&positions, &triangles[..3]))[0].is_closed);
    }
}
