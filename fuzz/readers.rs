//! Bytes in, nothing out: each function gives them to one reader, and what it makes of them, if it
//! takes them, to the renderer. Invariant: whatever the bytes, it comes back. tests/library/fuzzed.rs
//! repeats what was found.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use sunfleck::description::image::{self, Encoding};
use sunfleck::description::{self, Description, Files, SceneSource, gltf, vdb};
use sunfleck::diagnostic::Place;
use sunfleck::frame_file;
use sunfleck::math::Sampler;
use sunfleck::scene::{self, Scene};
use sunfleck::snapshot::{MeshTrees, Shutter, Snapshot};
use sunfleck::transport::{Scratch, Transport, VolumeMethod, radiance};

/// Larger scenes take longer than a fuzzer likes, and say no more.
const MOST_INSTANCES: usize = 200;

/// Of this process alone, in memory where the machine has such a place.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let shared_memory = Path::new("/dev/shm");
    let parent = if shared_memory.is_dir() { shared_memory.to_owned() } else { std::env::temp_dir() };
    let folder = parent.join(format!("sunfleck-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the files to be read");
    folder
});

/// A glTF file, text or binary.
pub(crate) fn gltf(bytes: &[u8]) {
    let path = PathBuf::from("fuzzed.glb");
    let mut files = Files::default();
    let Ok(scene) = gltf::parse(bytes, &path, &mut files) else { return };
    let scene = SceneSource::Gltf(scene);
    show(Description { path, scene, sequence: None, content_hash: files.content_hash(), files: Vec::new() });
}

/// A RON scene or sequence.
pub(crate) fn scene(bytes: &[u8]) {
    describe(&[("fuzzed.ron", bytes)]);
}

/// An OBJ mesh.
pub(crate) fn mesh(bytes: &[u8]) {
    describe(&shown(bytes, A_MATERIAL));
}

/// An MTL material.
pub(crate) fn material(bytes: &[u8]) {
    describe(&shown(A_MESH, bytes));
}

/// A texture.
pub(crate) fn image(bytes: &[u8]) {
    let _ = image::decode(bytes, Encoding::Srgb, Place::Nowhere);
    let _ = image::decode(bytes, Encoding::Radiance, Place::Nowhere);
}

/// An EXR frame.
pub(crate) fn frame(bytes: &[u8]) {
    let path = written(&[("fuzzed.exr", bytes)]);
    if let Ok(file) = frame_file::read(&path) {
        file.is_intact();
    }
}

/// A table of other renderers' times.
pub(crate) fn peers(bytes: &[u8]) {
    let _ = description::load_peers(&written(&[("fuzzed.csv", bytes)]));
}

/// An OpenVDB file.
pub(crate) fn grids(bytes: &[u8]) {
    if let Ok(grids) = vdb::parse(bytes, Path::new("fuzzed.vdb")) {
        grids.iter().filter_map(|grid| grid.floats.as_ref()?.extent()).for_each(drop);
    }
}

const SHOWS_A_MESH: &[u8] = br#"Scene(version: 1, meshes: { "a": Obj("fuzzed.obj") },
    objects: { "a": (mesh: "a") }, cameras: { "a": (position_m: (0.0, 0.0, 5.0), look_at_m: (0.0, 0.0, 0.0)) },
    lights: { "a": Sun(to_sun: (0.0, 1.0, 1.0), irradiance_w_per_m2: 1.0) })"#;
pub(crate) const A_MESH: &[u8] = b"mtllib fuzzed.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
pub(crate) const A_MATERIAL: &[u8] = b"newmtl a\nKd 0.5 0.5 0.5\n";

/// A scene that shows a mesh in materials, with its files.
pub(crate) fn shown<'a>(mesh: &'a [u8], materials: &'a [u8]) -> [(&'static str, &'a [u8]); 3] {
    [("fuzzed.ron", SHOWS_A_MESH), ("fuzzed.obj", mesh), ("fuzzed.mtl", materials)]
}

/// Writes the files beside each other; the first one's path.
pub(crate) fn written(files: &[(&str, &[u8])]) -> PathBuf {
    for (name, bytes) in files {
        std::fs::write(FOLDER.join(name), bytes).expect("room for the file");
    }
    FOLDER.join(files[0].0)
}

fn describe(files: &[(&str, &[u8])]) {
    if let Ok(description) = description::load(&written(files)) {
        show(description);
    }
}

fn show(description: Description) {
    // Letting thousands of leaves fall takes seconds, and is no reader's work.
    if let SceneSource::Ron(scene) = &description.scene
        && scene.file.fall.iter().map(|(_, fall)| fall.count.get()).sum::<u32>() > MOST_INSTANCES as u32
    {
        return;
    }
    let Ok((scene, settings)) = scene::resolve(description, None) else { return };
    if scene.instances.len() > MOST_INSTANCES || scene.cameras.is_empty() {
        return;
    }
    let first = settings.frame_rate.seconds(*settings.frames.start() as f64);
    for time_s in [first, first + 0.37] {
        look(&scene, time_s);
    }
}

/// A few rays, and that what they see is a number.
fn look(scene: &Scene, time_s: f64) {
    let trees = MeshTrees::new(scene);
    let snapshot = Snapshot::new(scene, &trees, 0, 1.0, Shutter { open_s: time_s, close_s: time_s });
    let transport =
        Transport { volume: VolumeMethod::Segments, mirror_depth: 1, indirect: None, features: true };
    let mut scratch = Scratch::default();
    for number in 0..3 {
        let mut sampler = Sampler::new(number, 0, 0, 0);
        let ray = snapshot.view.ray(0.31 + 0.2 * f64::from(number), 0.57);
        radiance(&snapshot, &transport, &ray, &mut sampler, &mut scratch);
    }
}
