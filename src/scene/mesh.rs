//! Triangle meshes in their own space. In go validated lists, out come meshes. Invariant: at least one
//! triangle, every index in range, every position finite.

use super::MaterialIndex;
use glam::{Vec2, Vec3, Vec4};

/// Triangles that share vertices.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// The author's name.
    pub name: String,
    /// Vertex positions in the mesh's own space, as stored in the file.
    pub positions: Vec<Vec3>,
    /// One shading normal a vertex, unit length; empty means flat shading.
    pub normals: Vec<Vec3>,
    /// One texture coordinate a vertex; empty means none. `v` points down, as in glTF.
    pub uvs: Vec<Vec2>,
    /// Texture coordinates of further textures: layers 1, 2 and so on; one a vertex each.
    pub more_uvs: Vec<Vec<Vec2>>,
    /// One linear colour a vertex, which multiplies the base colour; empty means white.
    pub colors: Vec<Vec3>,
    /// One alpha a vertex, `0..=1`, which multiplies that of a blended material; empty means 1.
    pub alphas: Vec<f32>,
    /// One tangent a vertex for normal maps: unit length, with the sign of the bitangent `w * normal x
    /// tangent` in `w`. Empty without a normal map.
    pub tangents: Vec<Vec4>,
    /// The triangles.
    pub triangles: Vec<Triangle>,
}

/// Three vertices and a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices into the mesh's vertices, counter-clockwise seen from the front.
    pub vertices: [u32; 3],
    /// Index into the scene's materials.
    pub material: MaterialIndex,
}
