//! Blocks of scattered leaves. In go those of a file, out come nodes and instances. Invariant: leaf `i` of a
//! block is a pure function of the block's fields other than `count`, and of `i`.

use super::Resolver;
use crate::color::Rgb;
use crate::description::ron::{Leaves, MAX_LEAVES};
use crate::math::Chance;
use crate::scene::{MaterialIndex, MeshIndex, Motion, RayVisibility};
use glam::{DAffine3, DQuat, DVec3, EulerRot};
use std::f64::consts::TAU;

impl Resolver<'_> {
    /// Adds to the number of leaves; returns false, after a report, if there are too many.
    pub(super) fn has_room_for(&mut self, owner: &str, leaves: u32) -> bool {
        self.leaf_count = self.leaf_count.saturating_add(leaves);
        let has_room = self.leaf_count <= MAX_LEAVES;
        if !has_room {
            let found = format!("with this block the scene has {} leaves", self.leaf_count);
            let expected = format!("at most {MAX_LEAVES} leaves in all");
            let remedy = "use fewer leaves, or meshes that hold several";
            self.problems.error(&format!("{owner}.count"), found, &expected, remedy);
        }
        has_room
    }

    pub(super) fn leaves(&mut self, name: &str, block: &Leaves) {
        let owner = format!("leaves.{name}");
        if !self.has_room_for(&owner, block.count.0) {
            return;
        }
        if block.roll_deg.is_some() && block.droop_deg.is_none() {
            let found = "the leaves are turned any way, and rolled as well";
            let remedy = "add `droop_deg`, or take `roll_deg` out";
            self.problems.error(&format!("{owner}.roll_deg"), found, "`droop_deg` beside it", remedy);
        }
        let site = self.leaf_site(&owner, block);
        let meshes = self.leaf_meshes(&owner, &block.meshes);
        let materials = self.leaf_materials(&owner, &block.materials);
        self.check_tint(&owner, !block.tint.is_empty(), &block.materials);
        let tint: Vec<Rgb> = block.tint.iter().map(|color| color.si()).collect();
        let Leaves { visible_to_camera, casts_shadow, holdout, .. } = *block;
        let rays = RayVisibility { visible_to_camera, casts_shadow, holdout };
        if let (Some((parent, site)), Some(meshes), Some(materials)) = (site, meshes, materials) {
            for leaf in 0..block.count.0 {
                let chance = LeafChance(Chance::of(block.seed, leaf));
                let position = site.at([Draw::X, Draw::Y, Draw::Z].map(|draw| chance.at(draw)));
                let motion = Motion::Still(place(block, position, chance));
                let node = self.scene.add_node(format!("{name}.{leaf}"), parent, motion);
                let mesh = chance.choose(Draw::Mesh, &meshes).unwrap_or_default();
                let material = chance.choose(Draw::Material, &materials);
                let shown = self.tinted(material, &tint, chance.at(Draw::Tint));
                self.scene.set_ray_visibility(node, rays);
                self.tinted_instance(node, mesh, (material, shown));
            }
        }
    }

    /// Meshes of a list of names, at least one.
    pub(super) fn leaf_meshes(&mut self, owner: &str, names: &[String]) -> Option<Vec<MeshIndex>> {
        let field = format!("{owner}.meshes");
        if names.is_empty() {
            self.problems.error(&field, "the list is empty", "at least one mesh", "name a mesh of `meshes`");
            return None;
        }
        let found = names.iter().enumerate();
        let found: Vec<_> = found.map(|(at, mesh)| self.mesh(&format!("{field}[{at}]"), mesh)).collect();
        found.into_iter().collect()
    }

    pub(super) fn leaf_materials(&mut self, owner: &str, names: &[String]) -> Option<Vec<MaterialIndex>> {
        let found = names.iter().enumerate();
        let found: Vec<_> =
            found.map(|(at, name)| self.material(&format!("{owner}.materials[{at}]"), name)).collect();
        found.into_iter().collect()
    }
}

/// Placement of a leaf of `block` at `position`; `chance` has its random numbers.
fn place(block: &Leaves, position: DVec3, chance: LeafChance) -> DAffine3 {
    let turns = [Draw::Turn1, Draw::Turn2, Draw::Turn3].map(|draw| chance.at(draw));
    let attitude = match block.droop_deg {
        None => uniform_rotation(turns),
        Some(droop) => {
            let roll = block.roll_deg.map_or(0.0, |roll| roll.at(turns[2]));
            // A leaf's tip is towards -z, so a rotation about x lowers it.
            DQuat::from_euler(EulerRot::YXZ, TAU * turns[0], -droop.at(turns[1]), roll)
        }
    };
    let scale = block.scale.at(chance.at(Draw::Scale));
    DAffine3::from_scale_rotation_translation(DVec3::splat(scale), attitude, position)
}

/// Random draws. New ones get new numbers, so that old scenes do not change.
#[derive(Clone, Copy)]
enum Draw {
    X,
    Y,
    Z,
    Turn1,
    Turn2,
    Turn3,
    Scale,
    Mesh,
    Material,
    Tint = 17,
}

#[derive(Clone, Copy)]
struct LeafChance(Chance);

impl LeafChance {
    fn at(self, draw: Draw) -> f64 {
        self.0.at(draw as u64)
    }

    fn choose(self, draw: Draw, among: &[usize]) -> Option<usize> {
        among.get((self.at(draw) * among.len() as f64) as usize).copied()
    }
}

/// Uniform rotation from three numbers in `[0, 1)` (Shoemake, "Uniform random rotations", Graphics Gems III,
/// 1992).
fn uniform_rotation([u1, u2, u3]: [f64; 3]) -> DQuat {
    let ((sin2, cos2), (sin3, cos3)) = ((TAU * u2).sin_cos(), (TAU * u3).sin_cos());
    let (r1, r2) = ((1.0 - u1).sqrt(), u1.sqrt());
    DQuat::from_xyzw(r1 * sin2, r1 * cos2, r2 * sin3, r2 * cos3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_uniform() {
        // Under the uniform distribution the image of any vector is uniform on the sphere, and the
        // angle has density (1 - cos)/pi, hence mean pi/2 + 2/pi.
        let (mut image, mut square, mut angle) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for leaf in 0..20_000 {
            let chance = LeafChance(Chance::of(1, leaf));
            let turn = uniform_rotation([Draw::Turn1, Draw::Turn2, Draw::Turn3].map(|draw| chance.at(draw)));
            let vector = turn * DVec3::Z;
            image += vector / 20_000.0;
            square += vector * vector / 20_000.0;
            angle += 2.0 * turn.w.abs().min(1.0).acos() / 20_000.0;
        }
        assert!(image.abs().max_element() < 0.015, "{image}");
        assert!((square - DVec3::splat(1.0 / 3.0)).abs().max_element() < 0.01, "{square}");
        assert!((angle - (TAU / 4.0 + 4.0 / TAU)).abs() < 0.02, "{angle}");
    }
}
