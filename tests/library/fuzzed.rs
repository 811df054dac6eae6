//! What fuzzing (fuzz/README.md) once found, again: every file must be answered, taken or refused.

#[path = "../../fuzz/readers.rs"]
mod readers;

use crate::checkout;
use std::path::PathBuf;
use std::sync::Mutex;
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::scene::{self, Scene};

/// Readers write what they read into one folder.
static FOLDER: Mutex<()> = Mutex::new(());

/// The files that were found for a reader.
fn found(reader: &str) -> Vec<PathBuf> {
    let folder = checkout::file("tests/data/fuzzed").join(reader);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    entries.map(|entry| entry.expect("an entry").path()).collect()
}

#[test]
fn what_fuzzing_found_is_answered() {
    let _alone = FOLDER.lock();
    for (name, reader) in [
        ("gltf", readers::gltf as fn(&[u8])),
        ("scene", readers::scene),
        ("mesh", readers::mesh),
        ("material", readers::material),
        ("image", readers::image),
        ("frame", readers::frame),
        ("peers", readers::peers),
        ("grids", readers::grids),
    ] {
        // None at all must be answered as well.
        reader(&[]);
        for path in found(name) {
            println!("{}", path.display());
            reader(&std::fs::read(&path).expect("a file"));
        }
    }
}

/// A scene that is refused would keep every mesh and every material from its reader.
#[test]
fn what_shows_meshes_and_materials_is_a_scene() {
    let _alone = FOLDER.lock();
    let files = readers::shown(readers::A_MESH, readers::A_MATERIAL);
    let scene = resolved(&files).expect("a good scene");
    assert_eq!(scene.instances.len(), 1);
    assert!(scene.materials.iter().any(|material| material.base_color == Rgb::splat(0.5)));
    let problem = resolved(&readers::shown(b"f 1 2 3", readers::A_MATERIAL)).expect_err("a damaged file");
    assert!(problem.contains("fuzzed.obj"), "{problem}");
    let damaged =
        resolved(&readers::shown(readers::A_MESH, b"newmtl a\nKd much")).expect("what is left of it");
    assert!(damaged.remarks.to_string().contains("fuzzed.mtl:2:"), "{}", damaged.remarks);
}

fn resolved(files: &[(&str, &[u8])]) -> Result<Scene, String> {
    let description =
        description::load(&readers::written(files)).map_err(|error| error.diagnostics().to_string())?;
    Ok(scene::resolve(description, None).map_err(|problems| problems.to_string())?.0)
}
