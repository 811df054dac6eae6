//! Meshes cut by the masks of materials. In go pairs of a mesh and a material, out come cut meshes.
//! Invariant: each pair is cut once.

use super::{MaterialIndex, MeshIndex, Resolver};
use crate::diagnostic::Diagnostic;
use crate::scene::outline::{self, Mask};

impl Resolver<'_> {
    /// Visible part of a mesh under the material's mask; `None` if nothing is left.
    pub(super) fn cut_out(&mut self, mesh: MeshIndex, material: Option<MaterialIndex>) -> Option<MeshIndex> {
        let masked = material.and_then(|material| Some((material, *self.cutoffs.get(&material)?)));
        let Some((material, cutoff)) = masked else { return Some(mesh) };
        if let Some(&known) = self.cut_meshes.get(&(mesh, material)) {
            return known;
        }
        let cut = self.cut_mesh(mesh, material, cutoff);
        self.cut_meshes.insert((mesh, material), cut);
        cut
    }

    fn cut_mesh(&mut self, index: MeshIndex, material: MaterialIndex, cutoff: f64) -> Option<MeshIndex> {
        let (mesh, material) = (&self.scene.meshes[index], &self.scene.materials[material]);
        let texture = material.base_color_texture.filter(|_| !mesh.uvs.is_empty());
        let Some(texture) = texture else { return (material.opacity >= cutoff).then_some(index) };
        let mask = Mask::new(&self.scene.textures[texture], cutoff, material.opacity);
        match outline::traced_cut_out(mesh, mask) {
            Ok((cut, added)) => {
                self.outlines.add(&mesh.name, mesh.triangles.len(), cut.triangles.len());
                if cut.triangles.is_empty() {
                    return None;
                }
                self.scene.meshes.push(cut);
                let cut = self.scene.meshes.len() - 1;
                self.bend_like(index, cut, &added);
                Some(cut)
            }
            Err(loss) => {
                let place = self.problems.place(&format!("meshes.{}", mesh.name));
                self.scene.remarks.push(Diagnostic::warning(loss, place, loss.sentence()));
                Some(index)
            }
        }
    }
}
