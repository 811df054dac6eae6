//! Bad input ends with a message that names file, place, expectation and remedy, and never with a
//! panic. One file per case under tests/data/invalid; its first line, or a file `.expect` beside
//! it, holds a fragment of the message.

use crate::checkout;
use proptest::prelude::*;
use std::path::{Path, PathBuf};
use sunfleck::description::image;
use sunfleck::diagnostic::Place;
use sunfleck::{description, scene};

fn data(folder: &str) -> PathBuf {
    checkout::file("tests/data").join(folder)
}

fn files(folder: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(data(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        entries.filter(|path| extensions.iter().any(|known| path.extension().unwrap() == *known)).collect();
    files.sort();
    files
}

/// Loads and resolves; the whole message if that fails.
fn message(path: &Path) -> Result<scene::Scene, String> {
    let description = description::load(path).map_err(|error| error.diagnostics().to_string())?;
    scene::resolve(description, None).map(|(scene, _)| scene).map_err(|error| error.to_string())
}

/// A scene that shows `path`, an OBJ file, a texture or an image of a sky, in a file of its own.
fn scene_showing(path: &Path, folder: &Path) -> PathBuf {
    let path = path.to_str().unwrap();
    if path.ends_with(".hdr") || path.ends_with(".exr") {
        let scene = folder.join("scene.ron");
        let text = format!("Scene(version: 1, cameras: {{ \"main\": () }}, sky: Image(image: \"{path}\"))");
        std::fs::write(&scene, text).unwrap();
        return scene;
    }
    let (mesh, material) = match path.ends_with(".obj") {
        true => (format!("Obj(\"{path}\")"), String::from("()")),
        false => (String::from("Quad(size_m: 1.0)"), format!("(texture: \"{path}\")")),
    };
    let material_name = if path.ends_with(".obj") { "" } else { ", material: \"it\"" };
    let scene = folder.join("scene.ron");
    let text = format!(
        "Scene(version: 1, cameras: {{ \"main\": () }}, meshes: {{ \"it\": {mesh} }}, materials: {{ \"it\": {material} }},
        objects: {{ \"it\": (mesh: \"it\"{material_name}) }})"
    );
    std::fs::write(&scene, text).unwrap();
    scene
}

/// What is wrong with the message for a case, if anything.
fn complaint(path: &Path, message: Result<scene::Scene, String>) -> Option<String> {
    let beside = PathBuf::from(format!("{}.expect", path.display()));
    let fragment = if beside.exists() {
        std::fs::read_to_string(beside).unwrap().trim().to_owned()
    } else {
        let bytes = std::fs::read(path).unwrap();
        let first = String::from_utf8_lossy(bytes.split(|&byte| byte == b'\n').next().unwrap()).into_owned();
        first.split_once("expect: ").expect("a first line `// expect: fragment`").1.trim().to_owned()
    };
    let name = path.file_name().unwrap().to_str().unwrap();
    match message {
        Ok(_) => Some(format!("{name}: no error, where `{fragment}` was due")),
        Err(text) => {
            let lacks = [fragment.as_str(), name, "expected: ", "remedy: "]
                .into_iter()
                .find(|part| !text.contains(part));
            lacks.map(|part| format!("{name}: no `{part}` in:\n{text}"))
        }
    }
}

fn assert_all_well_reported(complaints: impl Iterator<Item = Option<String>>, at_least: usize) {
    let complaints: Vec<_> = complaints.collect();
    assert!(complaints.len() >= at_least, "only {} cases found", complaints.len());
    let complaints: Vec<_> = complaints.into_iter().flatten().collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n\n"));
}

#[test]
fn bad_ron_is_well_reported() {
    let cases = files("invalid/ron", &["ron"]);
    assert_all_well_reported(cases.iter().map(|path| complaint(path, message(path))), 60);
}

#[test]
fn bad_obj_is_well_reported() {
    let folder = tempfile::tempdir().unwrap();
    let cases = files("invalid/obj", &["obj"]);
    let complaints = cases.iter().map(|path| complaint(path, message(&scene_showing(path, folder.path()))));
    assert_all_well_reported(complaints, 15);
}

#[test]
fn bad_images_are_well_reported() {
    let folder = tempfile::tempdir().unwrap();
    let cases = files("invalid/image", &["png", "ppm", "jpg"]);
    let complaints = cases.iter().map(|path| complaint(path, message(&scene_showing(path, folder.path()))));
    assert_all_well_reported(complaints, 10);
}

#[test]
fn bad_skies_are_well_reported() {
    let folder = tempfile::tempdir().unwrap();
    let cases = files("invalid/sky", &["hdr", "exr"]);
    let complaints = cases.iter().map(|path| complaint(path, message(&scene_showing(path, folder.path()))));
    assert_all_well_reported(complaints, 9);
}

#[test]
fn good_skies_are_accepted() {
    let folder = tempfile::tempdir().unwrap();
    for path in files("valid/sky", &["hdr", "exr"]) {
        let scene =
            message(&scene_showing(&path, folder.path())).unwrap_or_else(|message| panic!("{message}"));
        let sky = scene.sky.unwrap();
        // The sun of both: a little to the right of the middle, well above the horizon.
        let sun = sky.picture().along(glam::DVec3::new(1.0, 2.0_f64.sqrt(), -1.0).normalize());
        assert!((sun - glam::DVec3::new(40.0, 36.0, 30.0)).abs().max_element() < 0.5, "{sun}");
    }
}

#[test]
fn all_problems_of_a_file_are_reported_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    let text = r#"Scene(version: 1, objects: { "a": (mesh: "x"), "b": (mesh: "y"), "c": (parent: "z") })"#;
    std::fs::write(&path, text).unwrap();
    let message = message(&path).unwrap_err();
    for field in ["objects.a.mesh", "objects.b.mesh", "objects.c.parent", "cameras"] {
        assert!(
            message.contains(&format!("scene.ron: {field}: error: ")),
            "{field} is missing in:\n{message}"
        );
    }
}

#[test]
fn good_files_are_accepted() {
    for path in files("valid/ron", &["ron"]) {
        message(&path).unwrap_or_else(|message| panic!("{message}"));
    }
}

/// Bytes of a valid file with a few of them replaced, taken out or put in.
fn mutated(original: Vec<u8>) -> impl Strategy<Value = Vec<u8>> {
    let interesting = prop_oneof![any::<u8>(), prop::sample::select(b"()[]{}\",:.-/ \n09ev#".to_vec())];
    let change = (any::<prop::sample::Index>(), interesting, 0..3_u8);
    prop::collection::vec(change, 1..6).prop_map(move |changes| {
        let mut bytes = original.clone();
        for (at, byte, how) in changes {
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ if bytes.len() > 1 => drop(bytes.remove(at)),
                _ => {}
            }
        }
        bytes
    })
}

fn valid(name: &str) -> Vec<u8> {
    std::fs::read(data("valid").join(name)).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damaged_scenes_do_not_panic(bytes in mutated(valid("ron/everything.ron"))) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.ron");
        std::fs::write(&path, bytes).unwrap();
        let _ = message(&path);
    }

    #[test]
    fn damaged_skies_do_not_panic(bytes in mutated(valid("sky/sun.exr")), hdr in mutated(valid("sky/sun.hdr"))) {
        for bytes in [bytes, hdr] {
            let _ = image::decode(&bytes, image::Encoding::Radiance, Place::Nowhere);
        }
    }

    #[test]
    fn damaged_exports_do_not_panic(
        obj in mutated(valid("obj/exported.obj")),
        mtl in mutated(valid("obj/exported.mtl")),
        mesh_is_damaged in any::<bool>(),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("exported.obj");
        let (obj, mtl) = match mesh_is_damaged {
            true => (obj, valid("obj/exported.mtl")),
            false => (valid("obj/exported.obj"), mtl),
        };
        std::fs::write(&path, obj).unwrap();
        std::fs::write(folder.path().join("exported.mtl"), mtl).unwrap();
        std::fs::write(folder.path().join("checker.ppm"), valid("obj/checker.ppm")).unwrap();
        let scene = message(&scene_showing(&path, folder.path()));
        // A damaged MTL takes nothing from the mesh.
        prop_assert!(mesh_is_damaged || scene.is_ok(), "{scene:?}");
    }

    #[test]
    fn damaged_meshes_do_not_panic(bytes in mutated(valid("obj/all_forms.obj"))) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("all_forms.obj");
        std::fs::write(&path, bytes).unwrap();
        for name in ["all_forms.mtl", "checker.ppm"] {
            std::fs::write(folder.path().join(name), valid(&format!("obj/{name}"))).unwrap();
        }
        let _ = message(&scene_showing(&path, folder.path()));
    }
}
