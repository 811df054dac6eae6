//! What fuzzing (fuzz/README.md) once found, again: every file must be answered, taken or refused.
#![allow(clippy::print_stdout)]

#[path = "../fuzz/readers.rs"]
mod readers;

use std::path::{Path, PathBuf};

/// The files that were found for a reader.
fn found(reader: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/fuzzed").join(reader);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    entries.map(|entry| entry.expect("an entry").path()).collect()
}

#[test]
fn what_fuzzing_found_is_answered() {
    for (name, reader) in [
        ("gltf", readers::gltf as fn(&[u8])),
        ("scene", readers::scene),
        ("mesh", readers::mesh),
        ("material", readers::material),
        ("image", readers::image),
        ("frame", readers::frame),
        ("peers", readers::peers),
    ] {
        // None at all must be answered as well.
        reader(&[]);
        for path in found(name) {
            println!("{}", path.display());
            reader(&std::fs::read(&path).expect("a file"));
        }
    }
}
