//! Clipping planes of cameras: which surfaces they hide from the eye, and that they hide
//! them from nothing else.

use crate::checkout;
use crate::common::{EXACT, INSTANT, add_fog, add_light, camera_at, look, place};
use glam::{DAffine3, DVec2, DVec3};
use proptest::prelude::*;
use std::path::Path;
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::scene::{
    AlphaMode, Clip, Instance, Lens, LightKind, Material, Mesh, Scene, Size, Track, Triangle,
};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{MarchSteps, Scratch, Transport, VolumeMethod, radiance};
use sunfleck::{description, export, scanline, scene};

/// Adds a square of this half width across the view axis.
fn add_square(scene: &mut Scene, depth_m: f64, half_width_m: f64, material: Material) {
    let node = place(scene, DAffine3::from_translation(depth_m * DVec3::NEG_Z));
    scene.materials.push(material);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
    let material = scene.materials.len() - 1;
    scene.meshes.push(Mesh {
        positions: corners.map(|corner| (half_width_m * corner).extend(0.0).as_vec3()).to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.meshes.len() as u32);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

fn shining(color: Rgb) -> Material {
    Material { base_color: Rgb::ZERO, emission: color, ..Material::default() }
}

/// Red at 1 m, green at 3, blue at 9.
fn three_squares() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    for (depth_m, color) in [(1.0, DVec3::X), (3.0, DVec3::Y), (9.0, DVec3::Z)] {
        add_square(&mut scene, depth_m, 20.0, shining(color));
    }
    scene
}

#[test]
fn only_what_lies_between_the_planes_is_seen() {
    for (clip, expected) in [
        ((0.0, f64::INFINITY), DVec3::X),
        ((1.01, f64::INFINITY), DVec3::Y),
        ((1.01, 3.0), Rgb::ZERO),
        ((1.01, 3.01), DVec3::Y),
        ((0.99, 1.5), DVec3::X),
        ((4.0, 10.0), DVec3::Z),
        ((4.0, 8.0), Rgb::ZERO),
        ((9.1, f64::INFINITY), Rgb::ZERO),
    ] {
        for lens in
            [Lens::Perspective { fov_y: Track::from(1.5) }, Lens::Orthographic { height_m: Track::from(3.0) }]
        {
            let mut scene = three_squares();
            let camera = &mut scene.cameras[0];
            (camera.lens, camera.clip) = (lens, Clip { start_m: clip.0, end_m: clip.1 });
            // At right angles to the axis: the corners see what the middle sees.
            for (x, y) in [(0.5, 0.5), (0.01, 0.02), (0.99, 0.5)] {
                let sample = look(&scene, &EXACT, x, y);
                assert_eq!(sample.radiance, expected, "{clip:?} {x} {y}");
                assert_eq!(sample.surface.is_some(), expected != Rgb::ZERO);
            }
            let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
            let size = Size { width: 8, height: 8 };
            let preview = scanline::draw(&snapshot, size);
            for (channel, expected) in preview.channels.iter().zip(expected.to_array()) {
                assert!(channel.pixels.iter().all(|value| f64::from(*value) == expected), "{clip:?}");
            }
            let depth = [(DVec3::X, 1.0), (DVec3::Y, 3.0), (DVec3::Z, 9.0)];
            let depth = depth.iter().find(|(color, _)| *color == expected).map(|(_, depth)| *depth);
            let depths = scanline::depths(&snapshot, size);
            assert!(depths.iter().all(|found| found.is_some() == depth.is_some()), "{clip:?}");
            assert!(depths.iter().flatten().zip(depth).all(|(found, depth)| (found - depth).abs() < 1e-9));
        }
    }
}

#[test]
fn blended_surfaces_are_hidden_alike() {
    let veil = Material { alpha_mode: AlphaMode::Blend, opacity: 0.5, ..shining(Rgb::ONE) };
    let mut scene = camera_at(DVec3::ZERO);
    for depth_m in [1.0, 2.0, 4.0] {
        add_square(&mut scene, depth_m, 20.0, veil.clone());
    }
    add_square(&mut scene, 3.0, 20.0, shining(Rgb::ZERO));
    for (clip, expected) in [
        ((0.0, f64::INFINITY), 0.75),
        ((1.5, f64::INFINITY), 0.5),
        ((1.5, 2.5), 0.5),
        ((0.5, 1.5), 0.5),
        // Past the black one.
        ((3.5, f64::INFINITY), 0.5),
        ((2.5, f64::INFINITY), 0.0),
    ] {
        scene.cameras[0].clip = Clip { start_m: clip.0, end_m: clip.1 };
        let found = look(&scene, &EXACT, 0.4, 0.3).radiance.x;
        assert!((found - expected).abs() < 1e-12, "{clip:?}: {found}");
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
        let preview = scanline::draw(&snapshot, Size { width: 4, height: 4 });
        assert!(preview.channels[0].pixels.iter().all(|value| (f64::from(*value) - expected).abs() < 1e-6));
    }
}

/// A hidden square darkens what it darkened: the ground, and fog. A mirror shows it.
#[test]
fn what_is_hidden_throws_its_shadow_and_is_mirrored() {
    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, 2.0, 0.5, Material::default());
    add_square(&mut scene, 6.0, 50.0, Material { base_color: Rgb::ONE, ..Material::default() });
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::NEG_Z, Rgb::ONE);
    scene.cameras[0].clip = Clip { start_m: 3.0, end_m: 7.0 };
    assert_eq!(look(&scene, &EXACT, 0.51, 0.51).radiance, Rgb::ZERO);
    assert!(look(&scene, &EXACT, 0.9, 0.9).radiance.x > 0.3);

    let mut scene = three_squares();
    let mirror = Material { base_color: Rgb::ZERO, mirror: Rgb::ONE, ..Material::default() };
    add_square(&mut scene, 5.0, 20.0, mirror);
    scene.cameras[0].clip = Clip { start_m: 4.0, end_m: 6.0 };
    assert_eq!(look(&scene, &EXACT, 0.3, 0.6).radiance, DVec3::Y);
}

fn vector(range: std::ops::Range<f64>) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(range).prop_map(DVec3::from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// In fog, through what does not show: shadows of triangles that the ray passes are as a
    /// fine march finds them.
    #[test]
    fn rays_through_hidden_surfaces(
        corners in prop::collection::vec(vector(-1.5..1.5), 9),
        sun in vector(-1.0..1.0),
        lamp in vector(-3.0..3.0),
        is_sun in any::<bool>(),
    ) {
        let Some(sun) = sun.try_normalize() else { return Ok(()) };
        let mut scene = camera_at(DVec3::ZERO);
        let node = place(&mut scene, DAffine3::from_translation(3.0 * DVec3::NEG_Z));
        scene.materials.push(Material { base_color: Rgb::ONE, ..Material::default() });
        scene.meshes.push(Mesh {
            positions: corners.iter().map(|corner| corner.as_vec3()).collect(),
            triangles: [[0, 1, 2], [3, 4, 5], [6, 7, 8]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
            ..Mesh::default()
        });
        scene.instances.push(Instance { node, mesh: 0, material: None, leaf_id: 1, deformation: None });
        let (low, high) = (DVec3::new(-4.0, -4.0, -6.0), DVec3::new(4.0, 4.0, 1.0));
        add_fog(&mut scene, low, high, Rgb::splat(0.2), Rgb::ONE, 0.3);
        if is_sun {
            add_light(&mut scene, LightKind::Sun, DVec3::ZERO, sun, Rgb::ONE);
        } else {
            let position = lamp + 3.0 * DVec3::NEG_Z;
            add_light(&mut scene, LightKind::Point, position, DVec3::NEG_Z, Rgb::splat(12.0));
        }
        scene.cameras[0].clip = Clip { start_m: 2.8, end_m: 3.2 };
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
        let march = Transport { volume: VolumeMethod::March(MarchSteps::Count(4000)), ..EXACT };
        for (x, y) in [(0.5, 0.5), (0.42, 0.47), (0.6, 0.45), (0.47, 0.61)] {
            let ray = snapshot.view.ray(x + 0.001, y);
            let value = |transport: &Transport| {
                radiance(&snapshot, transport, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default())
            };
            let (exact, marched) = (value(&EXACT), value(&march));
            let off = (exact.shafts.x - marched.shafts.x).abs();
            prop_assert!(off < 4e-3 * marched.shafts.x.max(0.05), "{} {}", exact.shafts.x, marched.shafts.x);
        }
    }
}

fn load(path: &Path) -> Scene {
    let description = description::load(path).map_err(|error| error.diagnostics().to_string()).unwrap();
    scene::resolve(description, None).map_err(|error| error.to_string()).unwrap().0
}

/// Files with the planes of Blender's own defaults and others: a near thing before `znear`, a
/// far one behind `zfar`.
#[test]
fn planes_of_gltf_files() {
    let data = checkout::file("tests/data/clipping");
    for (file, hidden) in [("znear_1_object_at_0.2.gltf", 2), ("zfar_100_object_at_303.gltf", 2)] {
        let mut scene = load(&data.join(file));
        assert_eq!(scene.cameras[0].clip, Clip { start_m: 1.0, end_m: 100.0 });
        let seen = |scene: &Scene| -> Vec<u32> {
            let places = (0..400).map(|index| (f64::from(index % 20) + 0.5, f64::from(index / 20) + 0.5));
            let samples = places.map(|(x, y)| look(scene, &EXACT, x / 20.0, y / 20.0));
            let mut ids: Vec<u32> = samples.filter_map(|sample| Some(sample.surface?.leaf_id)).collect();
            ids.sort_unstable();
            ids.dedup();
            ids
        };
        assert_eq!(seen(&scene), [1], "{file}");
        scene.cameras[0].clip = Clip::NONE;
        assert!(seen(&scene).contains(&hidden), "{file}");
    }
}

/// Where nothing may be hidden, nothing is asked: neither beside the picture nor between the planes.
#[test]
fn planes_that_hide_nothing_are_none() {
    for (depth_m, half_width_m, clip, hides) in [
        (3.0, 1.0, (0.1, 100.0), false),
        (3.0, 1.0, (0.1, f64::INFINITY), false),
        (3.0, 1.0, (3.5, 100.0), true),
        (0.05, 1.0, (0.1, 100.0), true),
        (101.0, 1.0, (0.1, 100.0), true),
        (-3.0, 1.0, (0.1, 100.0), false),
    ] {
        let mut scene = camera_at(DVec3::ZERO);
        add_square(&mut scene, depth_m, half_width_m, Material::default());
        scene.cameras[0].clip = Clip { start_m: clip.0, end_m: clip.1 };
        let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
        assert_eq!(snapshot.view.clip() != Clip::NONE, hides, "{depth_m} {clip:?}");
    }
}

/// Planes survive `export`, and a camera without any has none when it is read back that hide anything.
#[test]
fn planes_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    let ron = |lens: &str| {
        format!(
            "Scene(version: 1, meshes: {{ \"quad\": Quad(size_m: 1.0) }}, objects: {{ \"quad\": (mesh: \"quad\") }}, cameras: {{ \"eye\": ({lens}) }})"
        )
    };
    for (lens, expected) in [
        ("clip_m: (0.25, 40.0)", (0.25, 40.0)),
        ("clip_m: (0.25, 40.0), orthographic_height_m: 2.0", (0.25, 40.0)),
        ("clip_m: (0.0, 40.0), orthographic_height_m: 2.0", (0.0, 40.0)),
        ("fov_deg: 30.0", (1e-4, f64::INFINITY)),
    ] {
        let path = folder.path().join("scene.ron");
        std::fs::write(&path, ron(lens)).unwrap();
        let description = description::load(&path).map_err(|error| error.diagnostics().to_string()).unwrap();
        let (scene, settings) = scene::resolve(description, None).map_err(|error| error.to_string()).unwrap();
        let exported = export::glb(&scene, &settings, Path::new("")).unwrap();
        let path = folder.path().join("scene.glb");
        std::fs::write(&path, [exported.head, exported.binary].concat()).unwrap();
        assert_eq!(load(&path).cameras[0].clip, Clip { start_m: expected.0, end_m: expected.1 }, "{lens}");
    }
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, ron("clip_m: (40.0, 0.25)")).unwrap();
    let description = description::load(&path).map_err(|error| error.diagnostics().to_string()).unwrap();
    let error = scene::resolve(description, None).map(|_| ()).map_err(|error| error.to_string()).unwrap_err();
    assert!(error.contains("cameras.eye.clip_m") && error.contains("leave nothing between them"), "{error}");
}

/// Planes of a file that leave nothing between them are passed over, and said.
#[test]
fn planes_out_of_order_are_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let data = checkout::file("tests/data/clipping/znear_1_object_at_0.2.gltf");
    let file = std::fs::read_to_string(data).unwrap();
    for (znear, zfar) in [("100", "1"), ("-1", "100"), ("1", "1")] {
        let file = file.replace("\"znear\": 1.0", &format!("\"znear\": {znear}"));
        let file = file.replace("\"zfar\": 100", &format!("\"zfar\": {zfar}"));
        let path = folder.path().join("scene.gltf");
        std::fs::write(&path, file).unwrap();
        let scene = load(&path);
        assert_eq!(scene.cameras[0].clip, Clip::NONE);
        assert!(scene.remarks.to_string().contains("clipping planes that leave nothing between them"));
    }
}
