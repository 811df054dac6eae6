//! Normal maps of RON's materials: what they do to light, and what becomes of them in glTF.

use crate::common::{EXACT, INSTANT};
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;
use std::path::{Path, PathBuf};
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{self, RenderSettings, Scene};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};
use sunfleck::{description, export};

const TO_SUN: DVec3 = DVec3::new(0.4, 1.0, -0.6);

/// A white mesh in the x-z plane that one direction bends all over, in 16 bits.
fn write(folder: &Path, mesh: &str, code: [u16; 3], scale: f64) -> PathBuf {
    let image = image::ImageBuffer::from_pixel(2, 2, image::Rgb(code));
    image.save(folder.join("bent.png")).unwrap();
    let path = folder.join("scene.ron");
    let text = format!(
        r#"Scene(version: 1, meshes: {{ "leaf": {mesh} }},
            materials: {{ "bent": (base_color: 0.9, normal_map: (texture: "bent.png", scale: {scale})) }},
            objects: {{ "leaf": (mesh: "leaf", material: "bent") }},
            cameras: {{ "main": (position_m: (0.0, 2.0, 0.0), look_at_m: (0.0, 0.0, 0.0), up: (0.0, 0.0, -1.0)) }},
            lights: {{ "sun": Sun(to_sun: ({}, {}, {}), irradiance_w_per_m2: 7.0) }})"#,
        TO_SUN.x, TO_SUN.y, TO_SUN.z
    );
    std::fs::write(&path, text).unwrap();
    path
}

fn load(path: &Path) -> (Scene, RenderSettings) {
    scene::resolve(description::load(path).unwrap(), None).unwrap()
}

/// From above, a little beside the middle.
fn seen(scene: &Scene) -> f64 {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let ray = Ray { origin: DVec3::ZERO, direction: DVec3::new(0.02, -1.0, 0.03).normalize() };
    radiance(&snapshot, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default()).radiance.x
}

const FLAT: [&str; 2] = ["Quad(size_m: 2.0)", "Leaf(length_m: 2.0, width_m: 2.0)"];
const CODES: [[u16; 3]; 3] = [[42_000, 32_000, 60_000], [32_768, 20_000, 61_000], [25_000, 45_000, 58_000]];

#[test]
fn a_flat_leaf_is_lit_as_if_it_were_tilted() {
    let folder = tempfile::tempdir().unwrap();
    for mesh in FLAT {
        for (code, scale) in CODES.into_iter().flat_map(|code| [(code, 1.0), (code, 0.5), (code, 0.0)]) {
            let found = seen(&load(&write(folder.path(), mesh, code, scale)).0);
            let [right, up, out] = code.map(|code| 2.0 * f64::from(code) / 65_535.0 - 1.0);
            // To the right in the image is +x, up in it -z, and out of it +y.
            let normal = DVec3::new(scale * right, out, -scale * up).normalize();
            let expected = 0.9 * FRAC_1_PI * 7.0 * normal.dot(TO_SUN.normalize());
            assert!((found / expected - 1.0).abs() < 1e-6, "{mesh} {code:?} {scale}: {found} {expected}");
        }
    }
}

#[test]
fn gltf_carries_them() {
    let folder = tempfile::tempdir().unwrap();
    for (mesh, code) in FLAT.into_iter().zip(CODES) {
        let (scene, settings) = load(&write(folder.path(), mesh, code, 0.7));
        let path = folder.path().join("out.glb");
        let export::Exported { head, binary, .. } = export::glb(&scene, &settings, Path::new("")).unwrap();
        std::fs::write(&path, [head, binary].concat()).unwrap();
        let (again, _) = load(&path);
        let (found, expected) = (seen(&again), seen(&scene));
        assert!((found / expected - 1.0).abs() < 1e-6, "{mesh}: {found} {expected}");
        let map = |scene: &Scene| {
            let material = scene.materials.iter().find(|material| material.name == "bent").unwrap();
            let (map, scale) = material.normal_map.unwrap();
            (scene.textures[map.texture].texels.clone(), scale)
        };
        assert_eq!(map(&again), map(&scene));
    }
}

#[test]
fn one_image_may_be_colours_and_directions() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), FLAT[0], [0, 0, 65_535], 1.0);
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("base_color: 0.9", r#"texture: "bent.png""#)).unwrap();
    let (scene, _) = load(&path);
    let material = scene.materials.iter().find(|material| material.name == "bent").unwrap();
    let (normal, color) = (material.normal_map.unwrap().0.texture, material.base_color_texture.unwrap());
    assert_ne!(normal, color);
}

#[test]
fn what_cannot_be_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), r#"Obj("bare.obj")"#, CODES[0], 1.0);
    std::fs::write(folder.path().join("bare.obj"), "v -1 0 -1\nv -1 0 1\nv 1 0 1\nf 1 2 3\n").unwrap();
    let said = load(&path).0.remarks.to_string();
    assert!(said.contains("meshes.leaf") && said.contains("it has no texture coordinates"), "{said}");
    std::fs::remove_file(folder.path().join("bent.png")).unwrap();
    let said = description::load(&path).unwrap_err().diagnostics().to_string();
    assert!(said.contains("materials.bent.normal_map.texture"), "{said}");
}
