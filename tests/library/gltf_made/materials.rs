//! Materials whose values change look, at every moment, like still ones with the values of that moment.

use crate::gltf_made::file::{File, assert_near, seen};
use serde_json::{Value, json};
use std::path::Path;

const PLACES: [(f64, f64); 3] = [(0.45, 0.52), (0.6, 0.4), (0.33, 0.66)];

fn merge(into: &mut Value, from: &Value) {
    match from.as_object().filter(|fields| !fields.is_empty()) {
        Some(fields) => fields.iter().for_each(|(name, value)| merge(&mut into[name], value)),
        None => *into = from.clone(),
    }
}

/// A square in a material.
fn square(material: &Value) -> File {
    let mut file = File::new();
    merge(file.material(), material);
    file
}

/// Each with two pointers of which one jumps and one moves, and what the material is at a time.
#[test]
fn animated_values_are_those_of_their_moment() {
    let kinds = [
        json!({}),
        json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.4 }, "extensions": { "KHR_materials_specular": { "specularFactor": 1 } } }),
        json!({ "extras": { "sunfleck_leaf": { "translucency": 0.4 } } }),
        json!({ "extensions": { "KHR_materials_unlit": {} } }),
        json!({ "pbrMetallicRoughness": { "metallicFactor": 1, "roughnessFactor": 0 } }),
        json!({ "alphaMode": "BLEND" }),
        json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.5 } } }),
    ];
    for kind in kinds {
        let mut moving = square(&kind);
        let color = [0.2, 0.4, 0.6, 1.0, 0.8, 0.2, 0.1, 0.5];
        moving.animate(
            "/materials/0/pbrMetallicRoughness/baseColorFactor",
            "VEC4",
            "LINEAR",
            &[0.0, 2.0],
            &color,
        );
        moving.animate(
            "/materials/0/emissiveFactor",
            "VEC3",
            "LINEAR",
            &[0.5, 1.5],
            &[0.0, 0.1, 0.2, 1.0, 0.5, 0.0],
        );
        let strength = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
        moving.animate(strength, "SCALAR", "STEP", &[0.0, 1.25], &[3.0, 20.0]);
        let moving = moving.scene();
        assert!(!moving.is_still());
        for time_s in [-1.0_f64, 0.0, 0.7, 1.2499, 1.25, 1.7, 3.0] {
            let along = (time_s / 2.0).clamp(0.0, 1.0);
            let color: Vec<f64> = (0..4)
                .map(|at| f64::from(color[at]) + along * f64::from(color[at + 4] - color[at]))
                .collect();
            let glow = (time_s - 0.5).clamp(0.0, 1.0);
            let mut still = square(&kind);
            let strength = if time_s < 1.25 { 3.0 } else { 20.0 };
            merge(
                still.material(),
                &json!({
                    "pbrMetallicRoughness": { "baseColorFactor": color },
                    "emissiveFactor": [glow, 0.1 + 0.4 * glow, 0.2 - 0.2 * glow],
                    "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": strength } },
                }),
            );
            let still = still.scene();
            for place in PLACES {
                assert_near(seen(&moving, time_s, place), seen(&still, time_s, place), (&kind, time_s));
            }
        }
    }
}

#[test]
fn roughness_metal_and_normal_maps_change() {
    let shiny = json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.4, "metallicFactor": 0.3 },
        "extensions": { "KHR_materials_specular": { "specularFactor": 1 } } });
    let with_map = |scale: f64| {
        let mut file = square(&shiny);
        let texture = file.texture(&[[200, 90, 220, 255]]);
        file.material()["normalTexture"] = json!({ "index": texture, "scale": scale });
        file
    };
    let mut moving = with_map(1.0);
    let pbr = "/materials/0/pbrMetallicRoughness";
    moving.animate(&format!("{pbr}/roughnessFactor"), "SCALAR", "LINEAR", &[0.0, 1.0], &[0.25, 0.75]);
    moving.animate(&format!("{pbr}/metallicFactor"), "SCALAR", "STEP", &[0.0, 0.5], &[0.125, 1.0]);
    moving.animate("/materials/0/normalTexture/scale", "SCALAR", "LINEAR", &[0.0, 1.0], &[0.0, 1.0]);
    let moving = moving.scene();
    for time_s in [0.0, 0.25, 0.5, 1.0] {
        let mut still = with_map(time_s);
        let metallic = if time_s < 0.5 { 0.125 } else { 1.0 };
        merge(
            still.material(),
            &json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.25 + 0.5 * time_s, "metallicFactor": metallic } }),
        );
        let still = still.scene();
        for place in PLACES {
            assert_near(seen(&moving, time_s, place), seen(&still, time_s, place), time_s);
        }
    }
    assert_ne!(seen(&moving, 0.0, PLACES[0]), seen(&moving, 0.25, PLACES[0]));
}

/// Written as glTF and read again, changes are the same.
#[test]
fn changes_travel_out_and_back() {
    for kind in [
        json!({ "pbrMetallicRoughness": { "metallicFactor": 0.5 }, "alphaMode": "BLEND" }),
        json!({ "extensions": { "KHR_materials_unlit": {} } }),
        json!({ "pbrMetallicRoughness": { "metallicFactor": 1, "roughnessFactor": 0 } }),
    ] {
        let mut file = square(&kind);
        let color = [0.2, 0.4, 0.6, 1.0, 0.8, 0.2, 0.1, 0.5];
        let pbr = "/materials/0/pbrMetallicRoughness";
        file.animate(&format!("{pbr}/baseColorFactor"), "VEC4", "STEP", &[0.0, 1.0], &color);
        if kind["pbrMetallicRoughness"]["metallicFactor"] == 0.5 {
            file.animate(&format!("{pbr}/roughnessFactor"), "SCALAR", "LINEAR", &[0.0, 2.0], &[0.25, 0.75]);
            file.animate(
                "/materials/0/emissiveFactor",
                "VEC3",
                "LINEAR",
                &[0.5, 1.5],
                &[0.0, 0.1, 0.2, 1.0, 0.5, 0.0],
            );
            let strength = "/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength";
            file.animate(strength, "SCALAR", "STEP", &[0.0, 1.25], &[3.0, 20.0]);
        }
        let (scene, settings) = file.load();
        let exported = sunfleck::export::glb(&scene, &settings, Path::new("")).unwrap();
        assert!(exported.remarks.0.is_empty(), "{}", exported.remarks);
        let again = crate::gltf_made::file::load(&[exported.head, exported.binary].concat(), "made.glb").0;
        for time_s in [0.0, 0.7, 0.9999, 1.0, 1.2499, 1.25, 1.7, 3.0] {
            for place in PLACES {
                assert_near(seen(&again, time_s, place), seen(&scene, time_s, place), (&kind, time_s));
            }
        }
    }
}

/// A spline, which is followed in straight parts.
#[test]
fn spline_keys_of_materials_are_followed() {
    let mut moving = square(&json!({ "extensions": { "KHR_materials_unlit": {} } }));
    let flat = [0.0; 4];
    let values = [flat, [0.0, 0.5, 1.0, 1.0], flat, flat, [1.0, 0.5, 0.0, 1.0], flat];
    let pointer = "/materials/0/pbrMetallicRoughness/baseColorFactor";
    moving.animate(pointer, "VEC4", "CUBICSPLINE", &[0.0, 1.0], values.as_flattened());
    let moving = moving.scene();
    for step in 0..=40 {
        let t = f64::from(step) / 40.0;
        let red = seen(&moving, t, (0.5, 0.5)).x;
        assert!((red - t * t * (3.0 - 2.0 * t)).abs() < 1e-3, "{t}: {red}");
    }
}

#[test]
fn what_cannot_change_is_said() {
    let mut file = square(&json!({ "alphaMode": "MASK" }));
    file.animate(
        "/materials/0/pbrMetallicRoughness/baseColorFactor",
        "VEC4",
        "LINEAR",
        &[0.0, 1.0],
        &[1.0; 8],
    );
    file.animate("/materials/0/alphaCutoff", "SCALAR", "LINEAR", &[0.0, 1.0], &[0.1, 0.9]);
    let remarks = file.scene().remarks.to_string();
    assert!(remarks.contains("masks are cut out once"), "{remarks}");
    assert!(remarks.contains("not honoured keep still: `/materials/0/alphaCutoff`"), "{remarks}");
}

/// Both are made of the base colour: its image and the colours of vertices count.
#[test]
fn mirrors_and_unlit_surfaces_are_painted() {
    let gold = json!({ "metallicFactor": 1, "roughnessFactor": 0, "baseColorFactor": [1, 0.5, 0.25, 1] });
    let mirror = json!({ "pbrMetallicRoughness": gold });
    let unlit = json!({ "pbrMetallicRoughness": { "baseColorFactor": [1, 0.5, 0.25, 1] }, "extensions": { "KHR_materials_unlit": {} } });
    for (kind, plain) in [(mirror, [0.5, 0.75, 1.0]), (unlit, [1.0; 3])] {
        let mut file = square(&kind);
        // Half the light in sRGB is 0.2159 of it.
        let texture = file.texture(&[[188, 255, 0, 255]]);
        file.material()["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": texture });
        let colors = file.floats("VEC3", [[0.5, 1.0, 1.0]; 4].as_flattened());
        file.primitive()["attributes"]["COLOR_0"] = json!(colors);
        file.json["scenes"][0]["extras"]["sunfleck_env"] = json!({ "color": [0.5, 0.75, 1.0] });
        let expected =
            sunfleck::color::Rgb::new(0.5 * 0.502_886_4, 0.5, 0.0) * sunfleck::color::Rgb::from(plain);
        let found = seen(&file.scene(), 0.0, (0.5, 0.5));
        assert!((found - expected).abs().max_element() < 1e-5, "{kind}: {found} {expected}");
    }
}

/// What goes through is taken from what is matte, and nothing from metal.
#[test]
fn metal_keeps_its_colour_where_light_goes_through() {
    for through in ["KHR_materials_diffuse_transmission", "KHR_materials_transmission"] {
        let factor = if through.ends_with("diffuse_transmission") {
            "diffuseTransmissionFactor"
        } else {
            "transmissionFactor"
        };
        let mut file = square(&json!({ "extensions": { through: { factor: 0.5 } },
            "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.25, 0.125, 1.0], "metallicFactor": 0.5 } }));
        let material = &file.scene().materials[0];
        let metal = material.metal_color.unwrap();
        assert_eq!(metal.to_array(), [0.5, 0.25, 0.125], "{through}");
        assert!(material.base_color.cmplt(metal).all(), "{through}");
        file.material()["extras"] = json!({ "sunfleck_material": { "metal": [1.0, 0.5, 0.25] } });
        assert_eq!(file.scene().materials[0].metal_color, Some(2.0 * metal), "{through}");
    }
}

/// Blender's *Bump Map Correction* is a property of ours.
#[test]
fn bumps_shade_themselves_where_that_is_asked_for() {
    let mut file = square(&json!({}));
    assert!(!file.scene().materials[0].has_bump_shadows);
    file.material()["extras"] = json!({ "sunfleck_material": { "bump_map_correction": true } });
    assert!(file.scene().materials[0].has_bump_shadows);
}
