//! The scenes that figures are measured on, read through the front door.

use std::path::Path;
use sunfleck::description;
use sunfleck::scene::{self, Scene};

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
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(path);
    let description = description::load(&path).expect("a good file");
    scene::resolve(description, None).expect("a good scene").0
}
