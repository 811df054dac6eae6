//! Tangents of meshes with normal maps. In go meshes and materials, out come tangents. Invariant: a mesh gets
//! them once, before it is cut.

use super::{MaterialIndex, MeshIndex, Resolver, Triangle};
use crate::description::tangents::{self, Vertices};
use crate::diagnostic::{Diagnostic, Loss};

impl Resolver<'_> {
    /// Computes the tangents for the material's normal map, if there is one; reports a failure.
    pub(super) fn make_tangents(&mut self, index: MeshIndex, material: Option<MaterialIndex>) {
        let mesh = &mut self.scene.meshes[index];
        if !mesh.tangents.is_empty() {
            return;
        }
        let materials = &self.scene.materials;
        let own = || mesh.triangles.iter().map(|triangle| triangle.material);
        let has_map = |&material: &MaterialIndex| materials[material].normal_map.is_some();
        let bent = match material {
            Some(material) => Some(material).filter(has_map),
            // A shortcut for scenes without normal maps.
            None if materials.iter().all(|material| material.normal_map.is_none()) => None,
            None => own().find(has_map),
        };
        let Some(material) = bent.map(|material| &materials[material]) else { return };
        let mut triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|triangle| triangle.vertices).collect();
        let vertices = Vertices { positions: &mesh.positions, normals: &mesh.normals, uvs: &mesh.uvs };
        // Coordinates of one texel have no tangents.
        let is_plain = mesh.uvs.iter().all(|uv| *uv == mesh.uvs[0]);
        let made = if is_plain { None } else { tangents::generate(vertices, &mut triangles) };
        let Some(made) = made else {
            let why = match is_plain {
                true => "it has no texture coordinates",
                false => "thousands of its triangles meet in one place",
            };
            let found = format!("the normal map of `{}` does not bend this mesh: {why}", material.name);
            let place = self.problems.place(&format!("meshes.{}", mesh.name));
            let warning = Diagnostic::warning(Loss::NormalMapUnusable, place, found);
            if !self.scene.remarks.0.contains(&warning) {
                self.scene.remarks.push(warning);
            }
            return;
        };
        made.copy(&mut mesh.positions);
        made.copy(&mut mesh.normals);
        made.copy(&mut mesh.uvs);
        made.copy(&mut mesh.colors);
        let triangle = |(triangle, vertices): (&Triangle, [u32; 3])| Triangle { vertices, ..*triangle };
        mesh.triangles = mesh.triangles.iter().zip(triangles).map(triangle).collect();
        mesh.tangents.clone_from(&made.tangents);
        self.bend_tangents(index, &made);
    }
}
