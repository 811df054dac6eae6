//! Spots of glTF files: hard edges, and beams of up to 180 degrees. Inner angles of hard edges are as
//! large as the outer ones.

use crate::common::{EXACT, look, sheet};
use glam::{DAffine3, DVec3};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, FRAC_PI_4};
use std::path::Path;
use sunfleck::color::Rgb;
use sunfleck::scene::{self, Light, LightKind, Material, Scene};
use sunfleck::{description, export};

/// A file with a camera at the origin and a spot 2 m before it, both along -z.
fn file(spot: &Value) -> Value {
    let light = json!({ "type": "spot", "name": "lamp", "intensity": 683.0, "spot": spot });
    json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "camera": 0, "name": "eye" },
            { "translation": [0, 0, -2], "extensions": { "KHR_lights_punctual": { "light": 0 } } },
        ],
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 1.5, "znear": 0.01 } }],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": { "KHR_lights_punctual": { "lights": [light] } },
    })
}

fn read(bytes: &[u8], name: &str) -> Result<Scene, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let description = description::load(Path::new(&path)).map_err(|error| error.diagnostics().to_string())?;
    scene::resolve(description, None).map(|(scene, _)| scene).map_err(|error| error.to_string())
}

fn of_file(spot: &Value) -> Result<Scene, String> {
    read(&serde_json::to_vec(&file(spot)).unwrap(), "spot.gltf")
}

/// Outer angle and blend.
fn shape(light: &Light) -> (f64, f64) {
    match &light.kind {
        LightKind::Spot { outer_angle, blend, .. } => (outer_angle.at(0.0), blend.at(0.0)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn angles_as_exporters_write_them() {
    let single = |angle: f64| f64::from(angle as f32);
    let above = f64::from(f32::from_bits((FRAC_PI_4 as f32).to_bits() + 1));
    for (inner, outer, expected) in [
        (FRAC_PI_4, FRAC_PI_4, (FRAC_PI_4, 0.0)),
        // Rounded to single precision, once a little too far.
        (single(0.4), 0.4, (0.4, 0.0)),
        (above, single(FRAC_PI_4), (single(FRAC_PI_4), 0.0)),
        (0.0, single(FRAC_PI_2), (FRAC_PI_2, 1.0)),
        (single(FRAC_PI_2), single(FRAC_PI_2), (FRAC_PI_2, 0.0)),
        (0.3, 0.4, (0.4, 0.25)),
    ] {
        let scene = of_file(&json!({ "innerConeAngle": inner, "outerConeAngle": outer })).unwrap();
        let found = shape(&scene.lights[0]);
        assert!((found.0 - expected.0).abs() < 1e-12 && (found.1 - expected.1).abs() < 1e-12, "{found:?}");
        assert!(!scene.remarks.to_string().contains("spot's angles"), "{}", scene.remarks);
    }
}

#[test]
fn angles_out_of_range_are_brought_back_and_said() {
    for (inner, outer, expected) in [
        (0.0, 2.0, (FRAC_PI_2, 1.0)),
        (1.0, 0.5, (0.5, 0.0)),
        (-0.3, 0.5, (0.5, 1.0)),
        (2.0, 3.0, (FRAC_PI_2, 0.0)),
    ] {
        let scene = of_file(&json!({ "innerConeAngle": inner, "outerConeAngle": outer })).unwrap();
        assert_eq!(shape(&scene.lights[0]), expected);
        let remarks = scene.remarks.to_string();
        assert!(remarks.contains("a spot's angles are not 0 <= inner <= outer <= pi/2"), "{remarks}");
        assert!(remarks.contains("`lamp`"), "{remarks}");
    }
    for outer in [0.0, -0.3] {
        let scene = of_file(&json!({ "outerConeAngle": outer })).unwrap();
        let remarks = scene.remarks.to_string();
        assert!(scene.lights.iter().all(|light| !matches!(light.kind, LightKind::Spot { .. })), "{outer}");
        assert!(
            remarks.contains("light-unusable") && remarks.contains("lights[0].spot.outerConeAngle"),
            "{remarks}"
        );
    }
}

/// To the last bit, as far as glTF can say it.
#[test]
fn angles_survive_a_journey() {
    for (inner, outer) in [(0.7, 0.7), (FRAC_PI_2, FRAC_PI_2), (0.0, FRAC_PI_2), (0.2, 0.8)] {
        let spot = json!({ "innerConeAngle": inner, "outerConeAngle": outer });
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("spot.gltf");
        std::fs::write(&path, serde_json::to_vec(&file(&spot)).unwrap()).unwrap();
        let description = description::load(&path).map_err(|error| error.diagnostics().to_string()).unwrap();
        let (scene, settings) = scene::resolve(description, None).map_err(|error| error.to_string()).unwrap();
        let exported = export::glb(&scene, &settings, Path::new("")).unwrap();
        let back = read(&[exported.head, exported.binary].concat(), "spot.glb").unwrap();
        let (there, back) = (shape(&scene.lights[0]), shape(&back.lights[0]));
        assert!(there.0 == back.0 && (there.1 - back.1).abs() < 1e-15, "{there:?} {back:?}");
    }
}

/// A hard edge is one: the sheet is as bright as under a point within the cone, and black beyond it. A half
/// space lights everything before it.
#[test]
fn hard_cones_light_a_sheet() {
    for (angle, film_edge) in [(FRAC_PI_4, 1.0), (FRAC_PI_2, f64::INFINITY)] {
        let lights = of_file(&json!({ "innerConeAngle": angle, "outerConeAngle": angle })).unwrap();
        let mut scene = sheet(Material { base_color: Rgb::ONE, ..Material::default() });
        let place = DAffine3::from_translation(2.0 * DVec3::NEG_Z);
        scene.nodes.push(scene::Node { motion: scene::Motion::Still(place), ..scene.nodes[0].clone() });
        scene.lights.push(Light { node: scene.nodes.len() - 1, ..lights.lights[0].clone() });
        // The light is 1 m before the sheet, which is 3 m away and seen under a right angle.
        for off_m in [0.0, 0.5, 0.99, 1.01, 2.5] {
            let found = look(&scene, &EXACT, 0.5 + off_m / 6.0, 0.5).radiance.x;
            let cos = 1.0 / (1.0 + off_m * off_m).sqrt();
            let expected = if off_m < film_edge { FRAC_1_PI * cos.powi(3) } else { 0.0 };
            assert!((found - expected).abs() < 1e-9, "{angle} {off_m}: {found} {expected}");
        }
    }
}
