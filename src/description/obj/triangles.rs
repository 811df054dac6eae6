//! Mesh from code. In go positions and indices, out comes a model as from an OBJ file. Invariant: every index
//! is in range, every number is finite, and every triangle has an area.

use super::{ObjModel, ObjTriangle};
use glam::{Vec2, Vec3};

/// Mesh from code.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Triangles {
    /// Positions of the vertices, metres.
    pub positions: Vec<[f32; 3]>,
    /// Normals, one a vertex, of any length but 0; empty for flat shading.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, one a vertex, `v` downwards; empty without textures.
    pub uvs: Vec<[f32; 2]>,
    /// Indices of three vertices each, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// Creates a mesh with flat shading.
    pub fn new(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Self { positions, triangles, ..Self::default() }
    }

    /// Model, or its fault: the field, the finding and the expectation.
    pub(in crate::inside::description) fn model(&self) -> Result<ObjModel, [String; 3]> {
        let count = self.positions.len();
        let flaw =
            |field: &str, found: String, expected: &str| [field.to_owned(), found, expected.to_owned()];
        let of_vertices = |field: &str, length: usize| match length {
            0 => Ok(()),
            length if length == count => Ok(()),
            _ => Err(flaw(field, format!("there are {length} of {count} vertices"), "one a vertex, or none")),
        };
        of_vertices("normals", self.normals.len())?;
        of_vertices("uvs", self.uvs.len())?;
        let numbers =
            [("positions", self.positions.as_flattened()), ("normals", self.normals.as_flattened())];
        for (field, numbers) in numbers.into_iter().chain([("uvs", self.uvs.as_flattened())]) {
            if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
                return Err(flaw(field, format!("a number is {number}"), "finite numbers"));
            }
        }
        let normal = |&normal: &[f32; 3]| Vec3::from(normal).as_dvec3().try_normalize().map(|n| n.as_vec3());
        let normals: Option<Vec<Vec3>> = self.normals.iter().map(normal).collect();
        let normals = normals
            .ok_or_else(|| flaw("normals", String::from("a normal has no length"), "normals of a length"))?;
        if self.triangles.is_empty() {
            return Err(flaw("triangles", String::from("there are none"), "at least one triangle"));
        }
        for (number, triangle) in self.triangles.iter().enumerate() {
            let field = format!("triangles[{number}]");
            if triangle.iter().any(|&index| index as usize >= count) {
                let found = format!("the vertices {triangle:?} are not all there");
                return Err(flaw(&field, found, &format!("indices below {count}")));
            }
            let [a, b, c] = triangle.map(|index| Vec3::from(self.positions[index as usize]).as_dvec3());
            if (b - a).cross(c - a).try_normalize().is_none() {
                let found = format!("the triangle {triangle:?} has no area");
                return Err(flaw(&field, found, "three corners that are not in a line"));
            }
        }
        let triangle = |&vertices: &[u32; 3]| ObjTriangle { vertices, material: None };
        Ok(ObjModel {
            positions: self.positions.iter().copied().map(Vec3::from).collect(),
            normals,
            uvs: self.uvs.iter().copied().map(Vec2::from).collect(),
            triangles: self.triangles.iter().map(triangle).collect(),
            ..ObjModel::default()
        })
    }
}
