//! The scenes that figures are measured on, read through the front door.

use crate::checkout;
use glam::{DAffine3, DQuat, DVec3};
use sunfleck::description;
use sunfleck::scene::{
    self, Aperture, Extend, Key, LightKind, Motion, Node, Rotation, Scene, Segment, SunDisc, Track,
};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};

/// A scene and what tables call it.
pub struct Named {
    /// For tables.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// 500 leaves of 132 triangles, and 20,000 of them.
pub fn reference_scenes() -> Vec<Named> {
    [("leaves500", "leaves500/leaves500.glb"), ("canopy20k", "canopy20k/scene.ron")]
        .map(|(name, path)| Named { name: name.into(), scene: load(path) })
        .into()
}

/// A scene below tests/data.
pub fn load(path: &str) -> Scene {
    let path = checkout::file("tests/data").join(path);
    let description = description::load(&path).expect("a good file");
    scene::resolve(description, None).expect("a good scene").0
}

/// leaves500 with its sun as a disc, with the sun in the middle of the picture, and both.
pub fn suns() -> [(&'static str, Scene); 3] {
    let plain = || load("leaves500/leaves500.glb");
    [
        ("a sun of 0.53 degrees", with_a_disc(plain())),
        ("a sun in the middle of the picture", with_sun_ahead(plain())),
        ("a sun of 0.53 degrees in the middle of the picture", with_a_disc(with_sun_ahead(plain()))),
    ]
}

/// The first light as large as the sun is.
pub fn with_a_disc(mut scene: Scene) -> Scene {
    scene.lights[0].kind = LightKind::SunDisc(SunDisc::even(Track::from(0.53_f64.to_radians())));
    scene
}

/// A lens so wide that of the leaves before and behind the middle nothing is sharp.
pub fn with_a_lens(mut scene: Scene) -> Scene {
    let focus_distance_m = Track::from(9.0);
    scene.cameras[0].aperture =
        Some(Aperture { f_stop: Track::from(0.3), sensor_width_m: 0.036, focus_distance_m, blades: 0 });
    scene
}

/// Every leaf flies by 80 cm a second, the camera keeps still.
pub fn with_flying_leaves(mut scene: Scene) -> Scene {
    let nodes: Vec<usize> = scene.instances.iter().map(|leaf| leaf.node).collect();
    for node in nodes {
        let Motion::Still(place) = scene.nodes[node].motion else { continue };
        let (scale, rotation, middle) = place.to_scale_rotation_translation();
        let metres = DVec3::new(0.8, 0.2, 0.0);
        let key = |time_s: f64| Key { time_s, value: middle + time_s * metres, to_next: Segment::Linear };
        let translation = Track::new(vec![key(-1.0), key(1.0)], Extend::Hold).expect("good keys");
        let rotation = Rotation::Quaternion(rotation.into());
        scene.nodes[node].motion = Motion::Keyed { translation, rotation, scale: scale.into() };
    }
    scene
}

/// The first light, a sun, where the camera looks.
fn with_sun_ahead(mut scene: Scene) -> Scene {
    let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
    let forward = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 16.0 / 9.0, shutter).view.axes().2;
    // A light shines along its -Z.
    let aim = Motion::Still(DAffine3::from_quat(DQuat::from_rotation_arc(DVec3::Z, forward)));
    scene.nodes.push(Node { name: "ahead".into(), parent: None, motion: aim, visible: Track::from(true) });
    scene.lights[0].node = scene.nodes.len() - 1;
    scene
}
