//! Tints of leaves. In goes a material, out comes the same with a tint. Invariant: leaves with
//! indistinguishable tints share a material.

use super::{Instance, MaterialIndex, MeshIndex, NodeIndex, Resolver};
use crate::color::Rgb;

/// Number of tints between the first of a list of colours and the last.
const STEPS: u16 = 1024;

/// Tint, quantized to invisible steps, so that equal ones can be found.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(super) struct Level([u64; 3]);

impl Level {
    /// Tint at a fraction `0..1` of the polyline through the colours.
    fn of(colors: &[Rgb], along: f64) -> Self {
        let step = (along * f64::from(STEPS)).floor() / f64::from(STEPS - 1);
        let place = step.min(1.0) * (colors.len() - 1) as f64;
        let first = (place as usize).min(colors.len().saturating_sub(2));
        let next = colors[(first + 1).min(colors.len() - 1)];
        Self(colors[first].lerp(next, place - first as f64).to_array().map(f64::to_bits))
    }

    fn color(self) -> Rgb {
        Rgb::from_array(self.0.map(f64::from_bits))
    }
}

impl Resolver<'_> {
    pub(super) fn instance(&mut self, node: NodeIndex, mesh: MeshIndex, material: Option<MaterialIndex>) {
        self.tinted_instance(node, mesh, (material, material));
    }

    /// Places a mesh that is cut by one material's mask and shown in another.
    pub(super) fn tinted_instance(
        &mut self,
        node: NodeIndex,
        mesh: MeshIndex,
        (shaped, shown): (Option<MaterialIndex>, Option<MaterialIndex>),
    ) {
        let leaf_id = self.scene.instances.len() as u32 + 1;
        let place = |resolver: &mut Self, node, mesh| resolver.one_of(leaf_id, node, mesh, (shaped, shown));
        if !self.in_turns(node, mesh, place) {
            self.one_of(leaf_id, node, mesh, (shaped, shown));
        }
    }

    /// Places one of the meshes of a sequence, all with one id.
    fn one_of(
        &mut self,
        leaf_id: u32,
        node: NodeIndex,
        mesh: MeshIndex,
        (shaped, shown): (Option<MaterialIndex>, Option<MaterialIndex>),
    ) {
        self.make_tangents(mesh, shaped);
        self.add_texture_coordinates(mesh, shaped);
        let Some(mesh) = self.cut_out(mesh, shaped) else { return };
        let deformation = self.moving.get(&mesh).cloned();
        self.scene.instances.push(Instance { node, mesh, material: shown, leaf_id, deformation });
    }

    /// Reports a block whose tint affects none of its materials.
    pub(super) fn check_tint(&mut self, owner: &str, has_tint: bool, materials: &[String]) {
        if has_tint && materials.is_empty() {
            let (expected, remedy) = ("`materials` beside it", "name a material of `materials`");
            self.problems.error(&format!("{owner}.tint"), "there is no material to tint", expected, remedy);
        }
    }

    /// Material with the tint of one leaf, which `chance` selects.
    pub(super) fn tinted(
        &mut self,
        material: Option<MaterialIndex>,
        colors: &[Rgb],
        chance: f64,
    ) -> Option<MaterialIndex> {
        let material = material?;
        if colors.is_empty() {
            return Some(material);
        }
        let level = Level::of(colors, chance);
        if let Some(&known) = self.tinted.get(&(material, level)) {
            return Some(known);
        }
        let mut made = self.scene.materials[material].tinted(level.color());
        made.name = format!("{} {}", made.name, self.tinted.len() + 1);
        self.scene.materials.push(made);
        self.tinted.insert((material, level), self.scene.materials.len() - 1);
        Some(self.scene.materials.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tints_lie_between_their_colours() {
        let colors = [Rgb::ZERO, Rgb::new(1.0, 0.0, 0.0), Rgb::ONE];
        assert_eq!(Level::of(&colors, 0.0).color(), colors[0]);
        assert_eq!(Level::of(&colors, 0.9999).color(), colors[2]);
        assert!((Level::of(&colors, 0.25).color() - Rgb::new(0.5, 0.0, 0.0)).abs().max_element() < 2e-3);
        assert!((Level::of(&colors, 0.75).color() - Rgb::new(1.0, 0.5, 0.5)).abs().max_element() < 2e-3);
        assert_eq!(Level::of(&colors[2..], 0.3).color(), Rgb::ONE);
    }
}
