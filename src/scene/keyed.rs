//! Keyed values of a scene. In goes a scene, out come its tracks of any type. Invariant: every value that can
//! be keyed is in this list, which decides whether a scene is still and how long it moves.

use super::{Animate, Extend, FogShape, GridFrames, Mist, Motion, Node, Rotation, Scene, Track};

/// Track of any type.
pub trait Keyed {
    /// Whether the value is constant.
    fn is_constant(&self) -> bool;
    /// First and last key, seconds; `None` without keys.
    fn span_s(&self) -> Option<(f64, f64)>;
    /// Whether it repeats after its last key.
    fn is_endless(&self) -> bool;
}

impl<T: Animate> Keyed for Track<T> {
    fn is_constant(&self) -> bool {
        Track::is_constant(self)
    }

    fn span_s(&self) -> Option<(f64, f64)> {
        Some(Track::span_s(self))
    }

    fn is_endless(&self) -> bool {
        self.extend() == Extend::Cycle
    }
}

impl Keyed for GridFrames {
    fn is_constant(&self) -> bool {
        self.frames.len() == 1
    }

    fn span_s(&self) -> Option<(f64, f64)> {
        let (first, last) = (self.frames.first()?, self.frames.last()?);
        (self.frames.len() > 1).then_some((first.time_s, last.time_s))
    }

    fn is_endless(&self) -> bool {
        false
    }
}

impl Keyed for Mist {
    fn is_constant(&self) -> bool {
        self.wind.is_still() && self.tracks().all(Track::is_constant)
    }

    fn span_s(&self) -> Option<(f64, f64)> {
        let spans = self.tracks().map(Track::span_s).chain([self.wind.velocity.span_s()]);
        spans.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    fn is_endless(&self) -> bool {
        !self.wind.is_still() || self.tracks().any(Keyed::is_endless)
    }
}

impl Motion {
    /// Tracks of the motion.
    pub fn tracks(&self) -> Vec<&dyn Keyed> {
        match self {
            Self::Still(_) => vec![],
            Self::Aimed { position, target, up } => vec![position, target, up],
            Self::Keyed { translation, rotation: Rotation::Quaternion(turn), scale } => {
                vec![translation, turn, scale]
            }
            Self::Keyed { translation, rotation: Rotation::EulerXyz(turn), scale } => {
                vec![translation, turn, scale]
            }
        }
    }

    /// Whether it never moves.
    pub fn is_still(&self) -> bool {
        self.tracks().iter().all(|track| track.is_constant())
    }
}

impl Scene {
    /// Whether all frames are the same.
    pub fn is_still(&self) -> bool {
        self.tracks().all(|track| track.is_constant())
    }

    /// Every track of the scene.
    pub fn tracks(&self) -> impl Iterator<Item = &dyn Keyed> {
        let nodes = self.nodes.iter().flat_map(node_tracks);
        nodes.chain(self.camera_tracks()).chain(self.light_tracks()).chain(self.matter_tracks())
    }

    fn camera_tracks(&self) -> impl Iterator<Item = &dyn Keyed> {
        self.cameras.iter().flat_map(|camera| {
            let mut tracks: Vec<&dyn Keyed> = vec![camera.lens.number()];
            if let Some(aperture) = &camera.aperture {
                tracks.extend([&aperture.f_stop as &dyn Keyed, &aperture.focus_distance_m]);
            }
            tracks
        })
    }

    fn light_tracks(&self) -> impl Iterator<Item = &dyn Keyed> {
        let lights = self.lights.iter().flat_map(|light| {
            let numbers = light.kind.numbers();
            let mut tracks: Vec<&dyn Keyed> = vec![&light.power];
            tracks.extend(numbers.into_iter().map(|(_, number)| number as &dyn Keyed));
            tracks
        });
        lights.chain(self.sky.iter().flat_map(|sky| [&sky.strength as &dyn Keyed, &sky.rotation]))
    }

    /// Tracks of fog, surfaces and shapes.
    fn matter_tracks(&self) -> impl Iterator<Item = &dyn Keyed> {
        let fogs = self.fogs.iter().flat_map(|fog| {
            let mut tracks: Vec<&dyn Keyed> = vec![&fog.density_per_m, &fog.albedo, &fog.anisotropy];
            if let Some(falloff) = FogShape::falloff(&fog.shape) {
                tracks.push(&falloff.scale_height_m);
            }
            match &fog.shape {
                FogShape::Voxels(grids) => tracks.extend([&**grids as &dyn Keyed, &grids.emission]),
                FogShape::Mist(mist) => tracks.push(&**mist),
                FogShape::EvenBox | FogShape::ThinningBox(_) | FogShape::Layer(_) => {}
            }
            tracks
        });
        let materials = self.materials.iter().filter_map(|material| material.changes.as_ref());
        let deformations = self.instances.iter().filter_map(|instance| instance.deformation.as_deref());
        let weights = deformations.flat_map(|deformation| &deformation.weights);
        fogs.chain(materials.map(|changes| changes as &dyn Keyed))
            .chain(weights.map(|weight| weight as &dyn Keyed))
    }
}

fn node_tracks(node: &Node) -> impl Iterator<Item = &dyn Keyed> {
    let visible: &dyn Keyed = &node.visible;
    node.motion.tracks().into_iter().chain([visible])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description;
    use crate::scene::{Baking, ResolveOptions, resolve_telling};
    use std::fs;

    fn scene(fields: &str) -> Scene {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("scene.ron");
        fs::write(&file, format!("Scene(version: 1, {fields})")).expect("written");
        let description = description::load(&file).expect("a scene");
        resolve_telling(description, &ResolveOptions::default(), &Baking::ALONE).expect("valid").0
    }

    #[test]
    fn whatever_is_keyed_moves_the_scene() {
        let keyed =
            |from: &str, to: &str| format!("(keys: [(at_s: 1.0, value: {from}), (at_s: 3.0, value: {to})])");
        let fog = |field: &str| {
            format!(
                "cameras: {{ \"main\": () }}, fog: {{ \"haze\": (min_m: (-1.0, 0.0, -1.0), max_m: (1.0, 1.0, 1.0), {field}) }}"
            )
        };
        let still = scene(&fog("density_per_m: 0.1"));
        assert!(still.is_still() && still.tracks().count() > 0);
        let lens = |stop: &str, focus: &str| {
            format!("cameras: {{ \"main\": (aperture: (f_stop: {stop}, focus_distance_m: {focus})) }}")
        };
        for fields in [
            fog(&format!("density_per_m: {}", keyed("0.1", "0.2"))),
            fog(&format!("density_per_m: 0.1, albedo: {}", keyed("0.1", "0.2"))),
            fog(&format!("density_per_m: 0.1, anisotropy: {}", keyed("0.1", "0.2"))),
            fog(&format!("density_per_m: 0.1, scale_height_m: {}", keyed("0.5", "0.6"))),
            lens(&keyed("2.0", "4.0"), "3.0"),
            lens("2.0", &keyed("2.0", "4.0")),
            format!("cameras: {{ \"main\": (fov_deg: {}) }}", keyed("30.0", "40.0")),
            format!("cameras: {{ \"main\": (position_m: {}) }}", keyed("(0.0, 0.0, 0.0)", "(0.0, 1.0, 0.0)")),
        ] {
            let scene = scene(&fields);
            assert!(!scene.is_still(), "{fields}");
            let mut spans = scene.tracks().filter(|track| !track.is_constant()).map(|track| track.span_s());
            assert!(spans.all(|span| span == Some((1.0, 3.0))), "{fields}");
        }
    }
}
