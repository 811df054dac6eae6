//! Fog of `sunfleck_fog_volume` of nodes and `sunfleck_fog` of the scene. In go extras, out come fog volumes.
//! Invariant: fog is bounded or falls off with height, as sunlight could not reach into it otherwise.

use super::Builder;
use super::extras;
use crate::color::Rgb;
use crate::diagnostic::{Diagnostic, Loss};
use crate::scene::{Fog, FogShape, HeightFalloff, Motion, NodeIndex, Track};
use glam::{DAffine3, DQuat, DVec3};

impl Builder<'_> {
    pub(super) fn add_fogs(&mut self, of_scene: Option<extras::Fog>) {
        for (index, node) in self.source.nodes.iter().enumerate() {
            let Some(number) = self.node_numbers[index] else { continue };
            let path = format!("nodes[{index}]");
            let fog =
                extras::read::<extras::Fog>(&node.extras, "sunfleck_fog_volume", &path, &mut self.report);
            let Some(fog) = fog else { continue };
            let path = format!("{path}.extras.sunfleck_fog_volume");
            if let Some(mist) = &fog.mist {
                self.check_no_grid(&fog, &path);
                if let Some((shape, own)) = self.mist(&fog, mist, number, &path) {
                    self.add_fog(&node.name, own, fog, shape, &path);
                }
            } else if let Some(shape) = self.fog_shape_of_node(&fog, &node.name, &path) {
                self.add_fog(&node.name, number, fog, shape, &path);
            }
        }
        if let Some(fog) = of_scene {
            self.add_fog_of_scene(fog);
        }
    }

    /// Shape of a node's fog; `None` if it is refused.
    fn fog_shape_of_node(&mut self, fog: &extras::Fog, name: &str, path: &str) -> Option<FogShape> {
        if let Some(uri) = &fog.vdb {
            return self.fog_of_grids(uri, fog, path);
        }
        self.check_no_grid(fog, path);
        let is_layer = fog.shape.as_deref() == Some("layer");
        if let Some(shape) = fog.shape.as_deref().filter(|shape| !is_layer && *shape != "box") {
            let found = format!("`{shape}` is no shape of fog");
            self.report.error(format!("{path}.shape"), found, "box or layer");
        }
        if fog.bounds.is_some() {
            self.report.not_honoured(Loss::FogBounds, name);
        }
        // By default the bottom of the cube, in its own space.
        let base = fog.base_height.unwrap_or(if is_layer { 0.0 } else { -1.0 });
        Some(self.fog_shape(fog, !is_layer, base, path))
    }

    fn add_fog_of_scene(&mut self, fog: extras::Fog) {
        let path = format!("scenes[{}].extras.sunfleck_fog", self.source.scene);
        let of_nodes =
            [("vdb", fog.vdb.is_some()), ("grid", fog.grid.is_some()), ("mist", fog.mist.is_some())];
        for (field, _) in of_nodes.iter().filter(|(_, is_said)| *is_said) {
            let found = format!("`{field}` is of fog at a node");
            self.report.error(format!("{path}.{field}"), found, "`sunfleck_fog_volume` of an object");
        }
        let bounds = fog.bounds.map(|corners| corners.map(DVec3::from));
        let (world_from_shape, base) = match bounds {
            None => (DAffine3::IDENTITY, fog.base_height.unwrap_or(0.0)),
            Some([a, b]) => {
                let (half_size, centre) = ((b - a).abs() / 2.0, (a + b) / 2.0);
                let in_cube = |height: f64| (height - centre.y) / half_size.y;
                let world_from_cube =
                    DAffine3::from_scale_rotation_translation(half_size, DQuat::IDENTITY, centre);
                (world_from_cube, fog.base_height.map_or(-1.0, in_cube))
            }
        };
        let shape = self.fog_shape(&fog, bounds.is_some(), base, &path);
        let node = self.scene.add_node(String::from("fog"), None, Motion::Still(world_from_shape));
        self.add_fog("fog", node, fog, shape, &path);
    }

    /// Shape of fog whose density may fall off above `base`.
    fn fog_shape(&mut self, fog: &extras::Fog, has_bounds: bool, base: f64, path: &str) -> FogShape {
        let falloff_per_m = fog.height_falloff.unwrap_or(0.0);
        if falloff_per_m < 0.0 {
            let found = "the fog grows denser with height without end";
            self.report.error(format!("{path}.height_falloff"), found, "1/m, at least 0");
        }
        let scale_height_m = fog.scale_height.unwrap_or_else(|| falloff_per_m.recip());
        if fog.scale_height.is_some() && !(scale_height_m > 0.0 && fog.height_falloff.is_none()) {
            let found = format!("the scale height is {scale_height_m}");
            let expected = "metres, above 0, and no `height_falloff` beside it";
            self.report.error(format!("{path}.scale_height"), found, expected);
        }
        let falloff = HeightFalloff { base, scale_height_m: Track::from(scale_height_m) };
        match (has_bounds, scale_height_m.is_finite()) {
            (true, false) => FogShape::EvenBox,
            (true, true) => FogShape::ThinningBox(falloff),
            (false, true) => FogShape::Layer(falloff),
            (false, false) => {
                let found = "fog without bounds would swallow all sunlight before it arrives";
                let error = Diagnostic::error(self.report.at(path), found)
                    .expected("fog in a box, or fog that thins out with height")
                    .remedy("bound the fog: an empty with the custom property `sunfleck_fog_volume`, or `bounds` here; or give it a `height_falloff` in 1/m");
                self.report.push(error);
                FogShape::EvenBox
            }
        }
    }

    fn add_fog(&mut self, name: &str, node: NodeIndex, fog: extras::Fog, shape: FogShape, path: &str) {
        extras::tell_unknown(&fog.unknown, &mut self.report, |field| format!("{path}.{field}"));
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
        if fog.anisotropy.abs() > 0.9999 {
            let found = format!("the anisotropy is {}", fog.anisotropy);
            self.report.error(format!("{path}.anisotropy"), found, "a number from -0.9999 to 0.9999");
        }
        self.scene.fogs.push(Fog {
            name: name.to_owned(),
            node,
            shape,
            density_per_m: Track::from(density_per_m),
            albedo: Track::from(albedo),
            anisotropy: Track::from(fog.anisotropy),
        });
    }
}
