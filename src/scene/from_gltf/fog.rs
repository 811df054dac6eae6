//! Fog from `sunfleck_fog_volume` of nodes and `sunfleck_fog` of the scene. Invariant: fog has
//! bounds; without them it would swallow a sun's light before it arrives.

use super::Builder;
use super::extras;
use crate::color::Rgb;
use crate::diagnostic::Diagnostic;
use crate::scene::{Fog, Motion, Node, NodeIndex, Track};
use glam::{DAffine3, DQuat, DVec3};

impl Builder<'_> {
    /// Adds the fog of the scene and of every node that bounds some.
    pub(super) fn add_fogs(&mut self, of_scene: Option<extras::Fog>) {
        for (index, node) in self.source.nodes.iter().enumerate() {
            let Some(number) = self.node_numbers[index] else { continue };
            let path = format!("nodes[{index}]");
            let fog =
                extras::read::<extras::Fog>(&node.extras, "sunfleck_fog_volume", &path, &mut self.report);
            let Some(fog) = fog else { continue };
            let path = format!("{path}.extras.sunfleck_fog_volume");
            if let Some(shape) = fog.shape.as_deref().filter(|shape| *shape != "box") {
                self.report.error(format!("{path}.shape"), format!("`{shape}` is no shape of fog"), "box");
            }
            if fog.height_falloff.is_some_and(|falloff| falloff != 0.0) {
                self.report.not_honoured(
                    "fog's falloff with height is not yet honoured, it is as dense everywhere",
                    &node.name,
                );
            }
            self.add_fog(&node.name, number, fog, &path);
        }
        if let Some(fog) = of_scene {
            self.add_fog_of_scene(fog);
        }
    }

    fn add_fog_of_scene(&mut self, fog: extras::Fog) {
        let path = format!("scenes[{}].extras.sunfleck_fog", self.source.scene);
        let falls_off = fog.height_falloff.is_some_and(|falloff| falloff != 0.0);
        let remedy =
            "bound the fog: an empty with the custom property `sunfleck_fog_volume`, or `bounds` here";
        let Some([a, b]) = fog.bounds.map(|corners| corners.map(DVec3::from)) else {
            let place = self.report.at(path);
            self.report.push(if falls_off {
                let found = "fog that thins out with height is not yet honoured, it is left out";
                Diagnostic::warning(place, found).remedy(remedy)
            } else {
                Diagnostic::error(place, "fog without bounds would swallow all sunlight before it arrives")
                    .expected("fog in a box")
                    .remedy(remedy)
            });
            return;
        };
        if falls_off {
            self.report.not_honoured(
                "fog's falloff with height is not yet honoured, it is as dense everywhere",
                "the scene",
            );
        }
        let half_size = (b - a).abs() / 2.0;
        let world_from_cube =
            DAffine3::from_scale_rotation_translation(half_size, DQuat::IDENTITY, (a + b) / 2.0);
        let node = self.scene.nodes.len();
        self.scene.nodes.push(Node {
            name: String::from("fog"),
            parent: None,
            motion: Motion::Still(world_from_cube),
            visible: Track::from(true),
        });
        self.add_fog("fog", node, fog, &path);
    }

    fn add_fog(&mut self, name: &str, node: NodeIndex, fog: extras::Fog, path: &str) {
        for field in fog.unknown.keys() {
            let field = format!("{path}.{field}");
            self.report.not_honoured("unknown fields of sunfleck's properties are passed over", &field);
        }
        if fog.base_height.is_some_and(|height| height != 0.0) {
            self.report.not_honoured("fog's base height is not yet honoured", name);
        }
        if let Motion::Still(parent_from_cube) = &self.scene.nodes[node].motion
            && parent_from_cube.matrix3.determinant() == 0.0
        {
            self.report.error(path, "the fog's box has no volume", "a scale other than 0 along every axis");
        }
        let density_per_m = Rgb::from(fog.density);
        let albedo = Rgb::from(fog.albedo);
        if density_per_m.min_element() < 0.0 {
            self.report.error(format!("{path}.density"), "the density is negative", "1/m, at least 0");
        }
        if albedo.min_element() < 0.0 || albedo.max_element() > 1.0 {
            self.report.error(format!("{path}.albedo"), "the albedo is out of range", "numbers from 0 to 1");
        }
        if fog.anisotropy.abs() >= 1.0 {
            let found = format!("the anisotropy is {}", fog.anisotropy);
            self.report.error(format!("{path}.anisotropy"), found, "a number above -1 and below 1");
        }
        self.scene.fogs.push(Fog {
            name: name.to_owned(),
            node,
            density_per_m: Track::from(density_per_m),
            albedo: Track::from(albedo),
            anisotropy: Track::from(fog.anisotropy),
        });
    }
}
