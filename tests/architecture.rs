//! The directions of import and the place of `unsafe`, held by reading the source.

use std::fs;
use std::path::{Path, PathBuf};

/// Modules from the first to the last: each may import only those before it.
const ORDER: [&str; 18] = [
    "color",
    "diagnostic",
    "math",
    "passes",
    "description",
    "scene",
    "export",
    "accel",
    "scattering",
    "snapshot",
    "transport",
    "film",
    "scanline",
    "render",
    "frame_file",
    "sequence",
    "bench",
    "cli",
];

/// Lines a file may have; beyond that it holds more than one concept.
const MOST_LINES: usize = 600;

fn source_files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("the source is there") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            source_files(&path, out);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            out.push(path);
        }
    }
}

/// (file relative to src, its top-level module, its text without the inline tests)
fn sources() -> Vec<(String, String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    source_files(&root, &mut files);
    files.sort();
    files
        .into_iter()
        .map(|path| {
            let relative = path.strip_prefix(&root).expect("below src").to_string_lossy().into_owned();
            let module = relative.split(['/', '.']).next().expect("a name").to_owned();
            let text = fs::read_to_string(&path).expect("readable");
            let shipped = text.split("#[cfg(test)]").next().expect("a part").to_owned();
            (relative, module, shipped)
        })
        .collect()
}

fn rank(module: &str) -> Option<usize> {
    ORDER.iter().position(|name| *name == module)
}

/// Every `crate::name` in code, comments aside.
fn imports(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for line in text.lines().filter(|line| !line.trim_start().starts_with("//")) {
        for after in line.split("crate::").skip(1) {
            let name: String = after.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if !name.is_empty() {
                found.push(name);
            }
        }
    }
    found
}

#[test]
fn every_module_has_its_place() {
    for (file, module, _) in sources() {
        if module != "lib" && module != "main" {
            assert!(rank(&module).is_some(), "{file}: `{module}` is not in the order of modules");
        }
    }
}

#[test]
fn imports_point_only_upward() {
    for (file, module, text) in sources() {
        let Some(own) = rank(&module) else { continue };
        for import in imports(&text) {
            let Some(other) = rank(&import) else { panic!("{file}: crate::{import} is not a module") };
            assert!(other <= own, "{file}: `{module}` imports `{import}`, which comes after it");
        }
    }
}

#[test]
fn unsafe_lives_in_the_simd_kernels_alone() {
    for (file, module, text) in sources() {
        let code = text.lines().filter(|line| !line.trim_start().starts_with("//"));
        let uses =
            code.filter(|line| line.split(|c: char| !c.is_alphanumeric() && c != '_').any(|w| w == "unsafe"));
        if uses.count() > 0 {
            assert_eq!(module, "accel", "{file} has `unsafe`");
        }
    }
}

#[test]
fn input_files_are_read_in_one_place() {
    let readers = ["std::fs::read", "fs::read(", "File::open", "read_to_string("];
    for (file, module, text) in sources() {
        if readers.iter().any(|reader| text.contains(reader)) {
            // What the system says of this process is no input, nor is what an earlier run has kept.
            let allowed = ["description/files.rs", "cli/stats.rs", "cli/loading.rs"].contains(&file.as_str())
                || module == "frame_file";
            assert!(allowed, "{file} opens files");
        }
    }
}

#[test]
fn every_file_tells_its_invariant_and_holds_one_concept() {
    for (file, _, text) in sources() {
        assert!(text.starts_with("//! "), "{file} does not say what it is");
        assert!(text.lines().count() <= MOST_LINES, "{file} is too long");
    }
}
