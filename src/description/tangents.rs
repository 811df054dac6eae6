//! Tangents for normal maps, by MikkTSpace, where a file has none. In go triangles, out come tangents.
//! Invariant: all corners at a vertex share its tangent; vertices are duplicated where tangents differ, as at
//! the seams of mirrored texture coordinates.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Maximum number of triangles around one point, as the generator recurses from one to the next.
const MOST_AROUND_A_PLACE: usize = 2000;

/// Vertices of triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertices<'a> {
    pub(crate) positions: &'a [Vec3],
    /// Normals, one a position; none for flat triangles.
    pub(crate) normals: &'a [Vec3],
    /// Texture coordinates of the normal map, one a position.
    pub(crate) uvs: &'a [Vec2],
}

/// Tangents, and the duplicated vertices that they need.
#[derive(Clone, Debug)]
pub(crate) struct Tangents {
    /// Tangents, one a vertex: of the original ones, then of the duplicates.
    pub(crate) tangents: Vec<Vec4>,
    /// Originals of the duplicated vertices.
    pub(crate) originals: Vec<u32>,
}

impl Tangents {
    /// Appends the values of duplicated vertices, unless there are none at all.
    pub(crate) fn copy<T: Copy>(&self, values: &mut Vec<T>) {
        if !values.is_empty() {
            let copies: Vec<T> = self.originals.iter().map(|&vertex| values[vertex as usize]).collect();
            values.extend(copies);
        }
    }
}

/// Computes tangents, and moves some corners of triangles to duplicated vertices; `None` if too many
/// triangles meet at one point.
pub(crate) fn generate(vertices: Vertices<'_>, triangles: &mut [[u32; 3]]) -> Option<Tangents> {
    if most_around_a_place(vertices.positions, triangles) > MOST_AROUND_A_PLACE {
        return None;
    }
    let tangents = vec![Vec4::ZERO; 3 * triangles.len()];
    let mut corners = Corners { vertices, triangles, tangents };
    // The generator has no failure so far.
    generate_tangents(&mut corners).ok()?;
    let tangents = corners.tangents;
    Some(share(vertices.positions.len(), triangles, &tangents))
}

fn most_around_a_place(positions: &[Vec3], triangles: &[[u32; 3]]) -> usize {
    let mut counts: HashMap<[u32; 3], usize> = HashMap::new();
    for vertex in triangles.iter().flatten() {
        // Adding 0 turns -0 into 0.
        let place = (positions[*vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
        *counts.entry(place).or_default() += 1;
    }
    counts.into_values().max().unwrap_or_default()
}

/// Corners of triangles, in the generator's interface.
struct Corners<'a> {
    vertices: Vertices<'a>,
    triangles: &'a [[u32; 3]],
    /// Tangents, three a triangle.
    tangents: Vec<Vec4>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.triangles[face][corner] as usize
    }

    /// Normal of the vertex, or of a flat triangle.
    fn normal_of(&self, face: usize, corner: usize) -> Vec3 {
        if let Some(normal) = self.vertices.normals.get(self.vertex(face, corner)) {
            return *normal;
        }
        let [a, b, c] = self.triangles[face].map(|v| self.vertices.positions[v as usize].as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().as_vec3()
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertices.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normal_of(face, corner).to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // glTF's v points down, and a normal map's y up.
        let uv = self.vertices.uvs[self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let [x, y, z, side] = space.unwrap_or_default().tangent_encoded();
        let tangent = Vec3::new(x, y, z).try_normalize().filter(|_| space.is_some());
        // Constant texture coordinates have no direction; any tangent is valid.
        let tangent = tangent.unwrap_or_else(|| match self.normal_of(face, corner) {
            Vec3::ZERO => Vec3::X,
            normal => normal.any_orthonormal_vector(),
        });
        self.tangents[3 * face + corner] = tangent.extend(side);
    }
}

/// Merges the tangents of corners at vertices, and duplicates vertices where they differ.
fn share(vertices: usize, triangles: &mut [[u32; 3]], corners: &[Vec4]) -> Tangents {
    let mut tangents: Vec<Option<Vec4>> = vec![None; vertices];
    let mut copies: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut originals = Vec::new();
    for (vertex, &tangent) in triangles.as_flattened_mut().iter_mut().zip(corners) {
        let first = tangents[*vertex as usize].get_or_insert(tangent);
        if *first != tangent {
            let key = (*vertex, tangent.to_array().map(f32::to_bits));
            *vertex = *copies.entry(key).or_insert_with(|| {
                originals.push(*vertex);
                tangents.push(Some(tangent));
                (tangents.len() - 1) as u32
            });
        }
    }
    // Vertices without triangles have no tangent.
    let tangents = tangents.into_iter().map(|tangent| tangent.unwrap_or(Vec4::X + Vec4::W)).collect();
    Tangents { tangents, originals }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn generated(
        positions: &[Vec3],
        normals: &[Vec3],
        uvs: &[Vec2],
        triangles: &mut [[u32; 3]],
    ) -> Option<Tangents> {
        generate(Vertices { positions, normals, uvs }, triangles)
    }

    /// Two triangles with a common edge, one the mirror image of the other in the texture.
    #[test]
    fn a_mirrored_seam_has_its_vertices_twice() {
        let mut positions = vec![Vec3::NEG_X, Vec3::NEG_Y, Vec3::Y, Vec3::X];
        let mut triangles = [[0, 1, 2], [3, 2, 1]];
        let uvs = [Vec2::new(1.0, 0.5), Vec2::new(0.0, 1.0), Vec2::ZERO, Vec2::new(1.0, 0.5)];
        let made = generated(&positions, &[Vec3::Z; 4], &uvs, &mut triangles).unwrap();
        assert_eq!((&made.originals[..], made.tangents.len()), (&[2, 1][..], 6));
        assert_eq!(triangles, [[0, 1, 2], [3, 4, 5]]);
        made.copy(&mut positions);
        assert_eq!(positions[4..], [Vec3::Y, Vec3::NEG_Y]);
        let [left, right] = triangles.map(|triangle| triangle.map(|vertex| made.tangents[vertex as usize]));
        assert_eq!(left, [Vec4::new(-1.0, 0.0, 0.0, -1.0); 3]);
        assert_eq!(right, [Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
    }

    #[test]
    fn more_triangles_around_a_place_than_can_be_gone_around_are_left_alone() {
        let rim = MOST_AROUND_A_PLACE as u32 + 2;
        let positions = (0..rim).map(|i| Vec2::from_angle(i as f32).extend(0.0)).chain([Vec3::ZERO]);
        let triangles = (1..rim).map(|i| [rim, i - 1, i]).collect();
        let (positions, mut fan): (Vec<Vec3>, Vec<[u32; 3]>) = (positions.collect(), triangles);
        let uvs = vec![Vec2::X; positions.len()];
        assert!(generated(&positions, &[], &uvs, &mut fan).is_none());
        fan.truncate(MOST_AROUND_A_PLACE);
        assert!(generated(&positions, &[], &uvs, &mut fan).is_some());
    }

    proptest! {
        /// Whatever the numbers, there is a unit tangent with a side for every corner.
        #[test]
        fn tangents_are_tangents(
            numbers in prop::collection::vec(prop::sample::select(vec![0.0_f32, -0.0, 1.0, -2.0, 1e-38, 1e-20, 1e20, f32::MAX, f32::MIN]), 30),
            corners in prop::collection::vec(0_u32..6, 24),
            is_flat in any::<bool>(),
        ) {
            let positions: Vec<Vec3> = numbers[..18].chunks_exact(3).map(Vec3::from_slice).collect();
            let uvs: Vec<Vec2> = numbers[18..].chunks_exact(2).map(Vec2::from_slice).collect();
            let normals = if is_flat { Vec::new() } else { vec![Vec3::Y; 6] };
            let mut triangles: Vec<[u32; 3]> = corners.as_chunks::<3>().0.to_vec();
            let places = |triangles: &[[u32; 3]], positions: &[Vec3]| -> Vec<Vec3> {
                triangles.iter().flatten().map(|&v| positions[v as usize]).collect()
            };
            let before = places(&triangles, &positions);
            let made = generated(&positions, &normals, &uvs, &mut triangles).unwrap();
            let mut all = positions;
            made.copy(&mut all);
            prop_assert_eq!(before, places(&triangles, &all));
            prop_assert_eq!(made.tangents.len(), all.len());
            for tangent in &made.tangents {
                prop_assert!((tangent.truncate().length() - 1.0).abs() < 1e-5 && tangent.w.abs() == 1.0);
            }
        }
    }
}
