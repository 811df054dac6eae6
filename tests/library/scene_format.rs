//! docs/scene-format.md is true: its snippets work, and it names every field there is.

use crate::checkout;
use std::path::Path;
use sunfleck::{description, scene};

fn page() -> String {
    std::fs::read_to_string(checkout::file("docs/scene-format.md")).unwrap()
}

/// Kind, line and text of every snippet.
fn snippets(page: &str) -> Vec<(String, usize, String)> {
    let mut snippets = Vec::new();
    let mut lines = page.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        if let Some(kind) = line.strip_prefix("```").filter(|kind| !kind.is_empty()) {
            let text: Vec<_> =
                lines.by_ref().map(|(_, line)| line).take_while(|line| *line != "```").collect();
            snippets.push((kind.to_owned(), number + 1, text.join("\n")));
        }
    }
    snippets
}

/// A scene with the given fields, and with whatever names they may refer to.
fn scene_with(fields: &str) -> String {
    let others = [
        r#"meshes: { "leaf": Leaf(length_m: 0.1, width_m: 0.05) }"#,
        r#"materials: { "gold": (base_color: 0.5) }"#,
        r#"cameras: { "main": (position_m: (0.0, 1.0, 4.0)) }"#,
    ];
    let missing = others.iter().filter(|other| !fields.contains(other.split_inclusive('{').next().unwrap()));
    let missing: Vec<_> = missing.map(|other| format!("{other},")).collect();
    format!("Scene(version: 1, {} {fields})", missing.join(" "))
}

fn resolve(path: &Path) -> Result<scene::Scene, String> {
    let description = description::load(path).map_err(|error| error.diagnostics().to_string())?;
    scene::resolve(description, None).map(|(scene, _)| scene).map_err(|error| error.to_string())
}

#[test]
fn every_snippet_is_a_valid_file() {
    let folder = tempfile::tempdir().unwrap();
    let sequences = folder.path().join("sequences");
    std::fs::create_dir_all(&sequences).unwrap();
    std::fs::create_dir_all(folder.path().join("scenes/first_leaf")).unwrap();
    let scene = "scenes/first_leaf/scene.ron";
    std::fs::copy(checkout::file(scene), folder.path().join(scene)).unwrap();
    let mut count = 0;
    for (kind, line, text) in snippets(&page()) {
        let text = match kind.as_str() {
            "ron scene" | "ron sequence" => text,
            "ron scene-fields" => scene_with(&text),
            other => panic!("line {line}: a snippet of kind `{other}` is not tested"),
        };
        let path = sequences.join("snippet.ron");
        std::fs::write(&path, text).unwrap();
        resolve(&path).unwrap_or_else(|error| panic!("docs/scene-format.md, line {line}: {error}"));
        count += 1;
    }
    assert!(count >= 10, "only {count} snippets found");
}

#[test]
fn every_field_is_described() {
    let page = page();
    let folder = checkout::file("src/description/ron");
    let mut count = 0;
    for file in [
        "scene_file.rs",
        "shape.rs",
        "material.rs",
        "camera.rs",
        "light.rs",
        "sky.rs",
        "fog.rs",
        "mist.rs",
        "leaves.rs",
        "fall.rs",
        "sequence_file.rs",
        "animated.rs",
    ] {
        let source = std::fs::read_to_string(folder.join(file)).unwrap();
        // Fields of structs are public; those of enum variants have no keyword and are indented twice.
        for line in source.lines() {
            let field = line.strip_prefix("    pub ").or_else(|| line.strip_prefix("        "));
            let Some((name, rest)) = field.and_then(|field| field.split_once(": ")) else { continue };
            if rest.ends_with(',')
                && !rest.contains(['(', '{', '='])
                && name.chars().all(|c| c.is_lowercase() || c == '_' || c.is_ascii_digit())
            {
                assert!(page.contains(&format!("`{name}`")), "{file}: `{name}` is not described");
                count += 1;
            }
        }
    }
    assert!(count >= 60, "only {count} fields found");
}

#[test]
fn examples_in_the_repository_resolve() {
    for path in ["scenes/first_leaf/scene.ron", "sequences/first_leaf.ron"] {
        let scene = resolve(&checkout::file(path)).unwrap();
        assert!(!scene.remarks.has_errors());
        assert_eq!(scene.instances.len(), 2);
    }
}
