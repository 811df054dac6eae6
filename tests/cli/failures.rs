//! Bad input: the exit code of its kind, a message that helps, and nothing half-written.

use crate::checkout;
use crate::program::{Studio, outcome};
use std::path::{Path, PathBuf};

/// Exit codes.
const USAGE: i32 = 2;
const SCENE: i32 = 3;
const INPUT_OUTPUT: i32 = 4;
const FRAME: i32 = 5;

fn assert_helps(message: &str, parts: &[&str]) {
    for part in parts.iter().chain(&["error: ", "expected", "remedy: "]) {
        assert!(message.contains(part), "`{part}` is not in\n{message}");
    }
}

#[test]
fn command_lines_that_make_no_sense_are_refused() {
    let studio = Studio::new();
    for line in [
        "",
        "rendr tiny.ron",
        "render",
        "render tiny.ron --frobnicate",
        "render tiny.ron --size 0x0",
        "render tiny.ron --size 960",
        "render tiny.ron --size -1x5",
        "render tiny.ron --samples 0",
        "render tiny.ron --tolerance 0",
        "render tiny.ron --tolerance 2",
        "render tiny.ron --tolerance nan",
        "render tiny.ron --frame-timeout 0",
        "render tiny.ron --frame-timeout inf",
        "render tiny.ron --threads 0",
        "render tiny.ron --seed -1",
        "render tiny.ron --fps 0",
        "render tiny.ron --crop 5,5,5,9",
        "render tiny.ron --passes beauty",
        "render tiny.ron --frames 1 --frames 2",
        "inspect tiny.ron --frames nan",
        "inspect tiny.ron --frames 1e300",
        "completions nosuchshell",
    ] {
        studio.fail(line, USAGE);
    }
    assert_eq!(studio.names("out"), [""; 0]);
}

#[test]
fn values_that_do_not_suit_the_input_are_refused_with_a_remedy() {
    let studio = Studio::new();
    for (line, parts) in [
        ("render tiny.ron --frames 10-20", &["frame 13 ", "frames from 1 to 12"][..]),
        ("render tiny.ron --frames 0", &["frame 0 "]),
        ("render tiny.ron --frames 5-2", &["`5-2`"]),
        ("render tiny.ron --frames x", &["--frames", "`x`"]),
        ("render tiny.ron --size 0.001%", &["--size"]),
        ("render tiny.ron --size 65536x65536", &["--size", "--crop"]),
        ("render tiny.ron --camera mian", &["--camera", "`mian`", "`main`, `low`"]),
        ("render tiny.ron --crop 0,0,33,18", &["--crop", "x1 up to 32"]),
        ("render tiny.ron --frames 1-2 --out a.exr", &["--out", "a.####.exr"]),
        ("render tiny.ron --out a.png", &["--out", ".exr"]),
        ("render tiny.ron --volume-steps 8", &["--volume-steps", "--volume march"]),
    ] {
        assert_helps(&studio.fail(line, USAGE), parts);
    }
    assert_eq!(studio.names("."), ["scene.ron", "tiny.ron"]);
}

#[test]
fn what_is_no_scene_is_refused_by_name() {
    let studio = Studio::new();
    std::fs::write(studio.path("notes.txt"), "leaves").unwrap();
    std::fs::create_dir(studio.path("folder.ron")).unwrap();
    let whole = std::fs::read(checkout::file("tests/data/leaves500/leaves500.glb")).unwrap();
    std::fs::write(studio.path("cut.glb"), &whole[..whole.len() / 2]).unwrap();
    for command in ["render", "inspect"] {
        for (name, code, part) in [
            ("nowhere.ron", INPUT_OUTPUT, "cannot be read"),
            ("nowhere.glb", INPUT_OUTPUT, "cannot be read"),
            ("nowhere", INPUT_OUTPUT, "cannot be read"),
            ("notes.txt", SCENE, "`txt`"),
            (".", SCENE, "folder"),
            ("folder.ron", INPUT_OUTPUT, "directory"),
            ("cut.glb", SCENE, "cut short"),
        ] {
            assert_helps(&studio.fail(&format!("{command} {name}"), code), &[name, part]);
        }
    }
    assert_helps(&studio.fail("diff nowhere.exr nowhere.exr", INPUT_OUTPUT), &["nowhere.exr"]);
    assert_helps(&studio.fail("diff scene.ron scene.ron", INPUT_OUTPUT), &["scene.ron", "no whole EXR file"]);
}

#[test]
fn places_that_cannot_be_written_to_are_named() {
    let studio = Studio::new();
    let message = studio.fail("render tiny.ron --frames 1 --out scene.ron/below/", INPUT_OUTPUT);
    assert_helps(&message, &["scene.ron/below", "--out"]);
    assert_eq!(studio.names("."), ["scene.ron", "tiny.ron"]);
}

/// Loading may take minutes; and a scene that is refused leaves no folder.
#[test]
fn places_to_write_to_are_looked_at_before_the_scene() {
    let studio = Studio::new();
    std::fs::write(studio.path("bad.ron"), "Scene(").unwrap();
    for out in ["scene.ron/below/", "scene.ron/a/b/x.####.exr"] {
        let message = studio.fail(&format!("render bad.ron --out {out}"), INPUT_OUTPUT);
        assert_helps(&message, &["scene.ron", "--out"]);
        assert!(!message.contains("bad.ron"), "{message}");
    }
    assert_helps(&studio.fail("render bad.ron --out x.png", USAGE), &["--out", ".exr"]);
    for more in ["", " --out a/b/", " --out a/b/x.####.exr"] {
        assert_helps(&studio.fail(&format!("render bad.ron{more}"), SCENE), &["bad.ron"]);
    }
    assert_eq!(studio.names("."), ["bad.ron", "scene.ron", "tiny.ron"]);
}

#[test]
fn a_frame_that_takes_too_long_is_given_up() {
    let studio = Studio::new();
    let line = "render tiny.ron --frames 1-2 --samples 2048 --size 320x180 --frame-timeout 0.02 --out a/ --stats stats.jsonl";
    assert_helps(&studio.fail(line, FRAME), &["frames 1,2", "--frame-timeout", "given up after"]);
    assert_eq!(studio.names("a"), [""; 0]);
    let stats = String::from_utf8(studio.bytes("stats.jsonl")).unwrap();
    let lines: Vec<serde_json::Value> =
        stats.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 3);
    assert!(lines[1..].iter().all(|line| line["outcome"] == "given up"), "{stats}");
}

#[test]
fn statistics_that_cannot_be_written_are_refused_before_anything_is_rendered() {
    let studio = Studio::new();
    let message = studio.fail("render tiny.ron --frames 1 --stats nowhere/stats.jsonl", INPUT_OUTPUT);
    assert_helps(&message, &["nowhere/stats.jsonl", "--stats"]);
    assert_eq!(studio.names("out"), [""; 0]);
}

/// The limit of a file's size stands in for the end of a disk.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_half_written() {
    let studio = Studio::new();
    let line = "trap '' XFSZ; ulimit -f 1; exec sunfleck render tiny.ron --size 64x36 --frames 1 --out a/";
    let outcome = outcome(studio.shell(line).output().unwrap());
    assert_eq!(outcome.code, INPUT_OUTPUT, "{}", outcome.err);
    assert_helps(&outcome.err, &["a/tiny.0001.exr", "--skip valid"]);
    assert_eq!(studio.names("a"), [""; 0]);
}

/// Files below tests/data/invalid.
fn corpus(folder: &str, extensions: &[&str]) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(checkout::file("tests/data/invalid").join(folder)).unwrap();
    let mut files: Vec<_> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| extensions.iter().any(|known| path.extension().unwrap() == *known))
        .collect();
    files.sort();
    files
}

/// A file of the checkout as a word of a command line.
fn word(file: &Path) -> String {
    format!("checkout:{}", file.strip_prefix(checkout::file("")).unwrap().display())
}

/// What is wrong with how a bad file is refused, if anything.
fn complaint(studio: &Studio, input: &str, file: &Path) -> Option<String> {
    let outcome = studio.run(&format!("render --dry-run {input}"));
    let name = file.file_name().unwrap().to_str().unwrap();
    let helps = [name, "error: ", "expected: ", "remedy: "].iter().all(|part| outcome.err.contains(part));
    let every_error_helps = outcome.err.matches("error: ").count() == outcome.err.matches("remedy: ").count();
    let distracts = outcome.err.contains("warning[") || outcome.err.contains("panicked");
    let well = [SCENE, INPUT_OUTPUT].contains(&outcome.code) && helps && every_error_helps && !distracts;
    (!well).then(|| format!("{name}: exit code {}\n{}", outcome.code, outcome.err))
}

fn assert_well_refused(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn the_corpus_of_bad_scenes_is_well_refused() {
    let studio = Studio::new();
    let mut files = corpus("ron", &["ron"]);
    files.extend(corpus("gltf", &["gltf", "glb"]));
    assert!(files.len() > 150, "only {} cases", files.len());
    assert_well_refused(files.iter().filter_map(|file| complaint(&studio, &word(file), file)).collect());
}

#[test]
fn a_unit_behind_a_number_is_named() {
    let studio = Studio::new();
    for unit in ["m", " deg", "%"] {
        let camera = format!(r#"Scene(version: 1, cameras: {{ "c": (fov_deg: 40.0{unit}) }})"#);
        std::fs::write(studio.path("unit.ron"), camera).unwrap();
        let told = studio.fail("render --dry-run unit.ron", SCENE);
        assert_helps(&told, &[&format!("`{}` does not belong here, behind a number", unit.trim())]);
    }
}

#[test]
fn the_corpus_of_bad_meshes_and_images_is_well_refused() {
    let studio = Studio::new();
    let meshes = corpus("obj", &["obj"]).into_iter().map(|file| {
        let mesh = format!("\"it\": Obj({file:?})");
        (file, mesh, "()".to_owned())
    });
    let images = corpus("image", &["png", "ppm", "jpg"]).into_iter().map(|file| {
        let material = format!("(texture: {file:?})");
        (file, "\"it\": Quad(size_m: 1.0)".to_owned(), material)
    });
    let mut complaints = Vec::new();
    for (file, mesh, material) in meshes.chain(images) {
        let choice = if material == "()" { "" } else { ", material: \"it\"" };
        let text = format!(
            "Scene(version: 1, cameras: {{ \"main\": () }}, meshes: {{ {mesh} }}, materials: {{ \"it\": {material} }},
            objects: {{ \"it\": (mesh: \"it\"{choice}) }})"
        );
        std::fs::write(studio.path("bad.ron"), text).unwrap();
        complaints.extend(complaint(&studio, "bad.ron", &file));
    }
    assert_well_refused(complaints);
}
