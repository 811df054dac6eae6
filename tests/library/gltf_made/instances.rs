//! Instances in colours of their own.

use crate::gltf_made::file::{File, SQUARE};
use glam::DVec3;
use serde_json::json;
use sunfleck::color::Rgb;

fn with_colors(kind: &str, component: u32, bytes: Vec<u8>) -> File {
    let mut file = File::new();
    file.material()["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 0.5, 0.5, 1.0]);
    let places = file.floats("VEC3", &[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let colors = file.numbers(kind, component, bytes, 3);
    file.json["accessors"][colors]["normalized"] = json!(component != 5126);
    file.json["nodes"][SQUARE]["extensions"] = json!({ "EXT_mesh_gpu_instancing": {
        "attributes": { "TRANSLATION": places, "_COLOR_0": colors } } });
    file.json["extensionsUsed"].as_array_mut().unwrap().push(json!("EXT_mesh_gpu_instancing"));
    file
}

#[test]
fn each_instance_has_its_colour_on_its_material() {
    let floats = [1.0_f32, 0.0, 0.2, 0.0, 1.0, 0.4, 1.0, 0.0, 0.2].map(f32::to_le_bytes).concat();
    let bytes = vec![255, 0, 51, 9, 0, 255, 102, 9, 255, 0, 51, 9];
    for (kind, component, bytes) in [("VEC3", 5126, floats), ("VEC4", 5121, bytes)] {
        let scene = with_colors(kind, component, bytes).scene();
        let colors: Vec<Rgb> = (scene.instances.iter())
            .map(|instance| scene.materials[instance.material.unwrap()].base_color)
            .collect();
        let expected = [DVec3::new(0.5, 0.0, 0.1), DVec3::new(0.0, 0.5, 0.2), DVec3::new(0.5, 0.0, 0.1)];
        for (color, expected) in colors.iter().zip(expected) {
            assert!((*color - expected).abs().max_element() < 1e-7, "{colors:?}");
        }
        assert_eq!(scene.instances[0].material, scene.instances[2].material);
        assert!(!format!("{:?}", scene.remarks).contains("InstanceAttributes"), "{:?}", scene.remarks);
    }
}

/// What shines in its own colours, and metal, are as coloured as matte things.
#[test]
fn what_shines_and_what_mirrors_has_the_colour_too() {
    let bytes = [255, 0, 51, 255].repeat(3);
    for (kind, of) in [
        (json!({ "extensions": { "KHR_materials_unlit": {} } }), 0),
        (json!({ "pbrMetallicRoughness": { "metallicFactor": 1, "roughnessFactor": 0 } }), 1),
    ] {
        let mut file = with_colors("VEC4", 5121, bytes.clone());
        file.json["materials"][0] = kind;
        let scene = file.scene();
        let material = &scene.materials[scene.instances[0].material.unwrap()];
        let shown = [material.emission, material.mirror][of];
        assert!((shown - DVec3::new(1.0, 0.0, 0.2)).abs().max_element() < 1e-7, "{shown}");
    }
}

#[test]
fn colours_of_another_number_are_damaged() {
    let few = [1.0_f32, 0.0, 0.2].map(f32::to_le_bytes).concat();
    let mut file = with_colors("VEC3", 5126, few);
    let last = file.json["accessors"].as_array().unwrap().len() - 1;
    file.json["accessors"][last]["count"] = json!(1);
    let scene = file.scene();
    assert_eq!(scene.instances.len(), 3);
    assert!(format!("{:?}", scene.remarks).contains("InstancesDamaged"), "{:?}", scene.remarks);
}
