//! docs/extras.schema.json describes the custom properties of every glTF file that there is here, and those
//! that `export` writes. It describes no others than are read.

use crate::checkout;
use crate::program::Studio;
use crate::schema::violations;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn schema() -> Value {
    serde_json::from_slice(&std::fs::read(checkout::file("docs/extras.schema.json")).unwrap()).unwrap()
}

/// The JSON of a .glb or .gltf file.
fn document(path: &Path) -> Value {
    let bytes = std::fs::read(path).unwrap();
    if !bytes.starts_with(b"glTF") {
        return serde_json::from_slice(&bytes).unwrap();
    }
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).unwrap()
}

/// What the schema does not allow in a file, and how many properties of ours there were.
fn check(path: &Path) -> (Vec<String>, usize) {
    let (schema, document) = (schema(), document(path));
    let things = ["scenes", "nodes", "cameras", "materials"]
        .into_iter()
        .flat_map(|kind| document[kind].as_array().cloned().unwrap_or_default());
    let mut count = 0;
    let mut found = Vec::new();
    for extras in things.map(|thing| thing["extras"].clone()).filter(Value::is_object) {
        count += extras.as_object().unwrap().keys().filter(|name| name.starts_with("sunfleck")).count();
        found.extend(violations(&schema, &extras));
    }
    (found, count)
}

fn files_in(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(checkout::file(folder)).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|end| end == "glb" || end == "gltf")).collect()
}

#[test]
fn every_property_in_every_file_is_as_described() {
    let mut total = 0;
    for folder in ["tests/data/blender", "tests/data/valid/gltf", "tests/data/leaves500"] {
        for path in files_in(folder) {
            let (found, count) = check(&path);
            assert!(found.is_empty(), "{}: {found:?}", path.display());
            total += count;
        }
    }
    assert!(total >= 20, "only {total} properties were found");
}

#[test]
fn properties_out_of_range_are_none_that_are_described() {
    for name in ["fog_anisotropy_one", "fog_density_negative", "light_sun_angle_pi", "passes_unknown"] {
        let (found, _) = check(&checkout::file(format!("tests/data/invalid/gltf/{name}.gltf")));
        assert_eq!(found.len(), 1, "{name}: {found:?}");
    }
}

#[test]
fn what_is_exported_is_as_described() {
    let studio = Studio::new();
    studio.succeed("export tiny.ron tiny.glb");
    let (found, count) = check(&studio.path("tiny.glb"));
    assert!(found.is_empty(), "{found:?}");
    assert!(count >= 2, "{count}");
}

#[test]
fn the_page_on_scenes_names_every_property_and_field() {
    let page = std::fs::read_to_string(checkout::file("docs/scene-format.md")).unwrap();
    for (name, described) in schema()["properties"].as_object().unwrap() {
        assert!(page.contains(&format!("`{name}`")), "{name}");
        for field in described["properties"].as_object().into_iter().flatten().map(|(field, _)| field) {
            assert!(
                page.contains(&format!("`{field}`")) || page.contains(&format!("`{field}: ")),
                "{name}.{field}"
            );
        }
    }
}

#[test]
fn inspect_tells_what_was_found_and_what_is_the_default() {
    let told = Studio::new().succeed("inspect checkout:tests/data/blender/i_conventions_nopointer.glb");
    for line in [
        "`sunfleck_env` of the scene: the background",
        "strength 0.4 (default 1): multiplies the colour to W/(m2 sr)",
        "`ctl_fog_density`",
        "light units, brightest channel",
    ] {
        assert!(told.out.contains(line), "{line}\n{}", told.out);
    }
}
