//! Scenes built in code for the tests of light transport.

use glam::{DAffine3, DQuat, DVec2, DVec3};
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::scene::{
    Camera, Clip, Coat, Fog, FogShape, HeightFalloff, Instance, Lens, Light, LightKind, Material, Mesh,
    Motion, Node, Scene, Track, Triangle,
};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};
use sunfleck::transport::{Sample, Scratch, Transport, VolumeMethod, radiance};

/// An instant at time 0.
pub(crate) const INSTANT: Shutter = Shutter { open_s: 0.0, close_s: 0.0 };

/// The exact method with everything on.
pub(crate) const EXACT: Transport<'static> =
    Transport { volume: VolumeMethod::Segments, mirror_depth: 4, indirect: None, features: true };

/// A scene with nothing but a camera at `eye` that looks along -Z with a right angle of view.
pub(crate) fn camera_at(eye: DVec3) -> Scene {
    let mut scene = Scene::default();
    let node = place(&mut scene, DAffine3::from_translation(eye));
    let lens = Lens::Perspective { fov_y: Track::from(std::f64::consts::FRAC_PI_2) };
    scene.cameras.push(Camera {
        name: "camera".into(),
        node,
        lens,
        shift: DVec2::ZERO,
        aperture: None,
        clip: Clip::NONE,
    });
    scene
}

/// Glass over what is matte, as rough as that.
pub(crate) fn coat(roughness: f64) -> Coat {
    Coat { metallic: 0.0, roughness, texture: None, f0: Rgb::splat(0.04), f0_texture: None, f90: 1.0 }
}

/// Adds a still node.
pub(crate) fn place(scene: &mut Scene, world_from_node: DAffine3) -> usize {
    scene.nodes.push(Node {
        name: format!("node {}", scene.nodes.len()),
        parent: None,
        motion: Motion::Still(world_from_node),
        visible: Track::from(true),
    });
    scene.nodes.len() - 1
}

/// Adds fog between two corners.
pub(crate) fn add_fog(scene: &mut Scene, low: DVec3, high: DVec3, sigma_t: Rgb, albedo: Rgb, g: f64) {
    let world_from_cube =
        DAffine3::from_translation(0.5 * (low + high)) * DAffine3::from_scale(0.5 * (high - low));
    let node = place(scene, world_from_cube);
    scene.fogs.push(Fog {
        name: "fog".into(),
        node,
        shape: FogShape::EvenBox,
        density_per_m: Track::from(sigma_t),
        albedo: Track::from(albedo),
        anisotropy: Track::from(g),
    });
}

/// Adds fog without bounds that thins out with height above `base_m`.
pub(crate) fn add_layer(
    scene: &mut Scene,
    base_m: f64,
    scale_height_m: f64,
    sigma_t: Rgb,
    albedo: Rgb,
    g: f64,
) {
    let node = place(scene, DAffine3::IDENTITY);
    scene.fogs.push(Fog {
        name: "layer".into(),
        node,
        shape: FogShape::Layer(HeightFalloff { base: base_m, scale_height_m: Track::from(scale_height_m) }),
        density_per_m: Track::from(sigma_t),
        albedo: Track::from(albedo),
        anisotropy: Track::from(g),
    });
}

/// Adds a light at `position` that shines along `beam`.
pub(crate) fn add_light(scene: &mut Scene, kind: LightKind, position: DVec3, beam: DVec3, power: Rgb) {
    let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, beam.normalize());
    let node = place(scene, DAffine3::from_rotation_translation(turn, position));
    scene.lights.push(Light { name: "light".into(), node, power: Track::from(power), kind });
}

/// The value of the camera ray through a film position.
pub(crate) fn look(scene: &Scene, transport: &Transport, film_x: f64, film_y: f64) -> Sample {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let ray = snapshot.view.ray(film_x, film_y);
    radiance(&snapshot, transport, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default())
}

/// A sheet 3 m before the camera that fills its view, facing it.
pub(crate) fn sheet(material: Material) -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    let node = place(&mut scene, DAffine3::from_translation(3.0 * DVec3::NEG_Z));
    scene.materials.push(material);
    scene.meshes.push(Mesh {
        positions: [DVec2::new(-90.0, -90.0), DVec2::new(90.0, -90.0), DVec2::new(0.0, 90.0)]
            .map(|corner| corner.extend(0.0).as_vec3())
            .to_vec(),
        triangles: vec![Triangle { vertices: [0, 1, 2], material: 0 }],
        ..Mesh::default()
    });
    scene.instances.push(Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None });
    scene
}
