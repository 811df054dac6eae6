//! Tangents for normal maps, as MikkTSpace makes them where a file has none. In goes a primitive, out it comes
//! with a tangent a vertex. Invariant: all corners that share a vertex share its tangent; vertices whose corners
//! do not, as at the seams of mirrored texture coordinates, are there once for each.

use super::Primitive;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Triangles around one place that the generator, which descends from one to the next, is given at most.
const MOST_AROUND_A_PLACE: usize = 2000;

/// Gives a primitive tangents for a map that is looked up with these coordinates; `false` if too many
/// triangles meet in one place.
pub(super) fn generate(primitive: &mut Primitive, uvs: &[Vec2]) -> bool {
    if most_around_a_place(primitive) > MOST_AROUND_A_PLACE {
        return false;
    }
    let corners = vec![Vec4::ZERO; 3 * primitive.triangles.len()];
    let mut corners = Corners { primitive, uvs, tangents: corners };
    // It has no way to fail today.
    let is_done = generate_tangents(&mut corners).is_ok();
    let tangents = corners.tangents;
    share(primitive, &tangents);
    is_done
}

fn most_around_a_place(primitive: &Primitive) -> usize {
    let mut counts: HashMap<[u32; 3], usize> = HashMap::new();
    for vertex in primitive.triangles.iter().flatten() {
        // Adding nothing makes both zeros the same.
        let place = (primitive.positions[*vertex as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
        *counts.entry(place).or_default() += 1;
    }
    counts.into_values().max().unwrap_or_default()
}

/// The corners of a primitive's triangles, as the generator asks for them.
struct Corners<'a> {
    primitive: &'a Primitive,
    uvs: &'a [Vec2],
    /// Three a triangle.
    tangents: Vec<Vec4>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[face][corner] as usize
    }

    /// The vertex's, or the triangle's if the primitive is flat.
    fn normal_of(&self, face: usize, corner: usize) -> Vec3 {
        if let Some(normal) = self.primitive.normals.get(self.vertex(face, corner)) {
            return *normal;
        }
        let [a, b, c] =
            self.primitive.triangles[face].map(|v| self.primitive.positions[v as usize].as_dvec3());
        (b - a).cross(c - a).normalize_or_zero().as_vec3()
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.positions[self.vertex(face, corner)].to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normal_of(face, corner).to_array()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        // glTF's v points down, and a normal map's y up.
        let uv = self.uvs[self.vertex(face, corner)];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        let [x, y, z, side] = space.unwrap_or_default().tangent_encoded();
        let tangent = Vec3::new(x, y, z).try_normalize().filter(|_| space.is_some());
        // Where texture coordinates do not vary there is no direction; any will do.
        let tangent = tangent.unwrap_or_else(|| match self.normal_of(face, corner) {
            Vec3::ZERO => Vec3::X,
            normal => normal.any_orthonormal_vector(),
        });
        self.tangents[3 * face + corner] = tangent.extend(side);
    }
}

/// Stores the tangents of corners at their vertices, of which there are more where these differ.
fn share(primitive: &mut Primitive, corners: &[Vec4]) {
    let mut tangents: Vec<Option<Vec4>> = vec![None; primitive.positions.len()];
    let mut copies: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    let mut originals = Vec::new();
    for (vertex, &tangent) in primitive.triangles.as_flattened_mut().iter_mut().zip(corners) {
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
    // Vertices of no triangle have none.
    primitive.tangents = tangents.into_iter().map(|tangent| tangent.unwrap_or(Vec4::X + Vec4::W)).collect();
    copy_vertices(primitive, &originals);
}

/// Appends copies of vertices, all but their tangents.
fn copy_vertices(primitive: &mut Primitive, originals: &[u32]) {
    fn copy<T: Copy>(values: &mut Vec<T>, originals: &[u32]) {
        if !values.is_empty() {
            let copies: Vec<T> = originals.iter().map(|&vertex| values[vertex as usize]).collect();
            values.extend(copies);
        }
    }
    copy(&mut primitive.positions, originals);
    copy(&mut primitive.normals, originals);
    copy(&mut primitive.uvs, originals);
    primitive.more_uvs.iter_mut().for_each(|uvs| copy(uvs, originals));
    copy(&mut primitive.colors, originals);
    for target in &mut primitive.targets {
        copy(&mut target.positions, originals);
        copy(&mut target.normals, originals);
        copy(&mut target.tangents, originals);
    }
    if let Some(influences) = &mut primitive.influences {
        for &original in originals {
            let own =
                original as usize * influences.per_vertex..(original as usize + 1) * influences.per_vertex;
            influences.joints.extend_from_within(own.clone());
            influences.weights.extend_from_within(own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn primitive(positions: Vec<Vec3>, normals: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Primitive {
        Primitive {
            positions,
            normals,
            uvs: Vec::new(),
            more_uvs: Vec::new(),
            colors: Vec::new(),
            tangents: Vec::new(),
            triangles,
            material: None,
            targets: Vec::new(),
            influences: None,
        }
    }

    /// Two triangles with a common edge, one the mirror image of the other in the texture.
    #[test]
    fn a_mirrored_seam_has_its_vertices_twice() {
        let positions = vec![Vec3::NEG_X, Vec3::NEG_Y, Vec3::Y, Vec3::X];
        let mut mesh = primitive(positions, vec![Vec3::Z; 4], vec![[0, 1, 2], [3, 2, 1]]);
        let uvs = [Vec2::new(1.0, 0.5), Vec2::new(0.0, 1.0), Vec2::ZERO, Vec2::new(1.0, 0.5)];
        assert!(generate(&mut mesh, &uvs));
        assert_eq!((mesh.positions.len(), mesh.normals.len(), mesh.tangents.len()), (6, 6, 6));
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(mesh.positions[4..], [Vec3::Y, Vec3::NEG_Y]);
        let [left, right] = mesh.triangles.map_to_tangents(&mesh.tangents);
        assert_eq!(left, [Vec4::new(-1.0, 0.0, 0.0, -1.0); 3]);
        assert_eq!(right, [Vec4::new(1.0, 0.0, 0.0, 1.0); 3]);
    }

    trait MapToTangents {
        fn map_to_tangents(&self, tangents: &[Vec4]) -> [[Vec4; 3]; 2];
    }

    impl MapToTangents for Vec<[u32; 3]> {
        fn map_to_tangents(&self, tangents: &[Vec4]) -> [[Vec4; 3]; 2] {
            [self[0], self[1]].map(|triangle| triangle.map(|vertex| tangents[vertex as usize]))
        }
    }

    #[test]
    fn more_triangles_around_a_place_than_can_be_gone_around_are_left_alone() {
        let rim = MOST_AROUND_A_PLACE as u32 + 2;
        let positions = (0..rim).map(|i| Vec2::from_angle(i as f32).extend(0.0)).chain([Vec3::ZERO]);
        let triangles = (1..rim).map(|i| [rim, i - 1, i]).collect();
        let mut fan = primitive(positions.collect(), Vec::new(), triangles);
        let uvs = vec![Vec2::X; fan.positions.len()];
        assert!(!generate(&mut fan, &uvs));
        assert!(fan.tangents.is_empty());
        fan.triangles.truncate(MOST_AROUND_A_PLACE);
        assert!(generate(&mut fan, &uvs));
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
            let triangles: Vec<[u32; 3]> = corners.as_chunks::<3>().0.to_vec();
            let mut mesh = primitive(positions, normals, triangles);
            let before: Vec<Vec3> =
                mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]).collect();
            prop_assert!(generate(&mut mesh, &uvs));
            let after: Vec<Vec3> =
                mesh.triangles.iter().flatten().map(|&v| mesh.positions[v as usize]).collect();
            prop_assert_eq!(before, after);
            prop_assert_eq!(mesh.tangents.len(), mesh.positions.len());
            for tangent in &mesh.tangents {
                prop_assert!((tangent.truncate().length() - 1.0).abs() < 1e-5 && tangent.w.abs() == 1.0);
            }
        }
    }
}
