//! Masked primitives. In go a mesh and its material, out comes the visible part. Invariant: it is opaque, or
//! the reason is reported.

use super::Builder;
use crate::description::gltf::AlphaMode;
use crate::diagnostic::Loss;
use crate::scene::Mesh;
use crate::scene::outline::{self, Between, Mask};

impl Builder<'_> {
    /// Visible part of a primitive under its material's mask, and its new vertices.
    pub(super) fn cut_out(&mut self, mut mesh: Mesh, material: Option<usize>) -> (Mesh, Vec<Between>) {
        let mut added = Vec::new();
        let Some(material) = material.map(|material| &self.source.materials[material]) else {
            mesh.alphas.clear();
            return (mesh, added);
        };
        let AlphaMode::Mask(cutoff) = material.alpha_mode else {
            if material.alpha_mode == AlphaMode::Opaque {
                mesh.alphas.clear();
            }
            return (mesh, added);
        };
        let [.., opacity] = material.base_color;
        let before = mesh.triangles.len();
        let fades = !mesh.alphas.is_empty();
        match material.base_color_texture.filter(|_| !mesh.uvs.is_empty()) {
            Some(texture) if self.scene.textures[texture].has_alpha() || !fades => {
                if fades {
                    self.report.not_honoured(Loss::VertexAlpha, &mesh.name);
                    mesh.alphas.clear();
                }
                match outline::traced_cut_out(
                    &mesh,
                    Mask::new(&self.scene.textures[texture], cutoff, opacity),
                ) {
                    Ok(cut) => (mesh, added) = cut,
                    Err(loss) => self.report.not_honoured(loss, &mesh.name),
                }
            }
            _ if opacity < cutoff => mesh.triangles.clear(),
            _ if fades && cutoff > 0.0 => (mesh, added) = outline::faded_cut_out(&mesh, cutoff / opacity),
            _ => mesh.alphas.clear(),
        }
        self.outlines.add(&mesh.name, before, mesh.triangles.len());
        (mesh, added)
    }
}
