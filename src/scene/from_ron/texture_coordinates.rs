//! Texture coordinates of meshes without any. In go meshes and materials, out come coordinates of the corner
//! texel where a material has textures, as for glTF and OBJ files. Invariant: a mesh is reported once.

use super::{MaterialIndex, MeshIndex, Resolver};
use crate::diagnostic::{Diagnostic, Loss};
use glam::Vec2;

impl Resolver<'_> {
    /// Gives a mesh coordinates for the material's textures, if it has none; reports it.
    pub(super) fn add_texture_coordinates(&mut self, index: MeshIndex, material: Option<MaterialIndex>) {
        // Materials of OBJ files were looked at when these were read.
        let Some(material) = material.map(|material| &self.scene.materials[material]) else { return };
        let mesh = &mut self.scene.meshes[index];
        let has_textures = material.base_color_texture.is_some() || material.transmission_texture.is_some();
        if !has_textures || !mesh.uvs.is_empty() {
            return;
        }
        let place = self.problems.place(&format!("meshes.{}", mesh.name));
        let found = format!("{}: `{}`", Loss::TextureCoordinatesMissing.sentence(), material.name);
        self.scene.remarks.push(Diagnostic::warning(Loss::TextureCoordinatesMissing, place, found));
        mesh.uvs = vec![Vec2::ZERO; mesh.positions.len()];
    }
}
