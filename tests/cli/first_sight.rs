//! What people see of files that say little. A camera and light are made up, the exposure shows something,
//! and a word is said where next to nothing is seen.

use crate::checkout;
use crate::program::Studio;
use image::RgbImage;
use serde_json::{Value, json};

/// A word of a command line.
fn input(name: &str) -> String {
    format!("checkout:tests/data/first/{name}")
}

fn picture(studio: &Studio, name: &str) -> RgbImage {
    let bytes = studio.bytes(name);
    image::load_from_memory_with_format(&bytes, image::ImageFormat::Png).unwrap().to_rgb8()
}

/// Mean of the bytes of a picture.
fn brightness(picture: &RgbImage) -> f64 {
    picture.as_raw().iter().map(|byte| f64::from(*byte)).sum::<f64>() / picture.as_raw().len() as f64
}

fn statistics(studio: &Studio, name: &str) -> Vec<Value> {
    let text = String::from_utf8(studio.bytes(name)).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

const SMALL: &str = "--size 32x18 --samples 1";
/// Without light of higher orders, which takes most of the time: where it is not what is looked at.
const DIRECT: &str = "--size 32x18 --samples 1 --bounces 0";

#[test]
fn a_file_without_light_and_camera_is_seen_and_that_is_said() {
    let studio = Studio::new();
    let file = input("no_light_no_camera.gltf");
    let outcome =
        studio.succeed(&format!("render {file} {SMALL} --preview png --out a/x.exr --stats s.jsonl"));
    let said = |what: &str| outcome.err.lines().filter(|line| line.contains(what)).count();
    assert_eq!((said("has no camera"), said("--default-light off")), (1, 1), "{}", outcome.err);
    assert_eq!(said("warning"), 0, "{}", outcome.err);
    let shown = picture(&studio, "a/x.png");
    assert!((60.0..200.0).contains(&brightness(&shown)), "{}", brightness(&shown));
    let is_red = |pixel: &image::Rgb<u8>| i32::from(pixel.0[0]) > i32::from(pixel.0[2]) + 30;
    assert!(shown.pixels().filter(|pixel| is_red(pixel)).count() > 30, "the triangle is seen");
    assert_eq!(statistics(&studio, "s.jsonl")[1]["dark"], Value::Bool(false));
    // It is no loss: whoever wants all or nothing gets it all.
    studio.succeed(&format!("render {file} {SMALL} --strict --out b/"));
}

#[test]
fn the_default_light_can_be_switched_off_which_makes_other_frames() {
    let studio = Studio::new();
    // A copy: what is said has the name of the file in it, and the checkout may be called `sunfleck`.
    std::fs::copy(checkout::file("tests/data/first/no_light_no_camera.gltf"), studio.path("no_light.gltf"))
        .unwrap();
    let render = format!("render no_light.gltf {DIRECT} --out a/x.exr --skip valid");
    assert!(studio.succeed(&render).err.contains("1 frame written"));
    assert!(studio.succeed(&render).err.contains("0 frames written"));
    let dark = studio.succeed(&format!("{render} --default-light off --stats s.jsonl --progress jsonl"));
    assert!(
        dark.err.contains("warning[dark-frame]: frame 1 is next to black: nothing lights the scene"),
        "{}",
        dark.err
    );
    assert!(!dark.err.contains("sun"), "{}", dark.err);
    assert_eq!(statistics(&studio, "s.jsonl")[1]["dark"], Value::Bool(true));
    assert!(
        dark.out.lines().any(|line| line.contains("frame_written") && line.contains("\"dark\":true")),
        "{}",
        dark.out
    );
    let beauty = studio.frame("a/x.exr").frame;
    assert!(beauty.channel("R").unwrap().pixels.iter().all(|red| *red == 0.0));
}

/// Blender's scenes that are dark there.
#[test]
fn a_file_that_says_its_sky_gets_no_default_light() {
    let studio = Studio::new();
    let text = std::fs::read_to_string(checkout::file("tests/data/first/no_light_no_camera.gltf")).unwrap();
    let mut file: Value = serde_json::from_str(&text).unwrap();
    file["scenes"][0]["extras"]["sunfleck_env"] = json!({ "color": [0.0, 0.0, 0.0] });
    let described = |file: &Value| -> Value {
        std::fs::write(studio.path("dark.gltf"), file.to_string()).unwrap();
        serde_json::from_str(&studio.succeed("inspect dark.gltf --json").out).unwrap()
    };
    assert_eq!(described(&file)["frames"][0]["lights"].as_object().unwrap().len(), 0);
    // A background lights nothing, and what glows does.
    let is_told = |file: &Value| {
        described(file)["losses"].as_array().unwrap().iter().any(|loss| loss["id"] == "no-light")
    };
    file["scenes"][0]["extras"]["sunfleck_env"] = json!({ "color": [0.1, 0.1, 0.1] });
    assert!(is_told(&file));
    file["materials"][0]["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
    assert!(!is_told(&file));
}

/// What is exported is lit by whoever reads it, and then is the same picture.
#[test]
fn export_leaves_the_default_light_to_whoever_reads_the_file() {
    let studio = Studio::new();
    let file = input("no_light_no_camera.gltf");
    studio.succeed(&format!("export {file} a.glb"));
    let lights = |file: &str| {
        let described: Value =
            serde_json::from_str(&studio.succeed(&format!("inspect {file} --json")).out).unwrap();
        described["frames"][0]["lights"].as_object().unwrap().len()
    };
    assert_eq!(lights("a.glb --default-light off"), 0);
    assert_eq!(lights("a.glb"), 1);
    studio.succeed(&format!("export {file} b.glb --default-light on"));
    assert_eq!(lights("b.glb --default-light off"), 1);
}

/// It is said once and no loss, told by `inspect`, found again in what is exported, and can be switched off.
#[test]
fn a_sun_in_a_picture_of_the_sky_becomes_a_sun() {
    let studio = Studio::new();
    let radiance = |x: usize, y: usize| {
        let is_sun = (60..62).contains(&x) && (20..22).contains(&y);
        if is_sun { (9000.0_f32, 8000.0, 6000.0) } else { (0.3, 0.4, 0.6) }
    };
    exr::prelude::write_rgb_file(studio.path("sky.exr"), 256, 128, radiance).unwrap();
    let scene = r#"Scene(version: 1, meshes: { "ground": Quad(size_m: 4.0) }, objects: { "ground": (mesh: "ground") },
        cameras: { "main": (position_m: (0.0, 1.0, 3.0), look_at_m: (0.0, 0.0, 0.0)) },
        sky: Image(image: "sky.exr"))"#;
    std::fs::write(studio.path("sunny.ron"), scene).unwrap();
    let render = format!("render sunny.ron {SMALL} --strict --out a/x.exr --skip valid");
    let outcome = studio.succeed(&render);
    let said = |text: &str| text.lines().filter(|line| line.contains("--sky-sun off")).count();
    assert_eq!((said(&outcome.err), outcome.err.contains("warning")), (1, false), "{}", outcome.err);
    let off = studio.succeed(&format!("{render} --sky-sun off"));
    assert_eq!((said(&off.err), off.err.contains("1 frame written")), (0, true), "{}", off.err);
    let suns = |flags: &str| {
        let described = studio.succeed(&format!("inspect {flags} --json")).out;
        let described: Value = serde_json::from_str(&described).unwrap();
        described["frames"][0]["sky_suns"].as_array().unwrap().clone()
    };
    studio.succeed("export sunny.ron a.glb");
    assert_eq!((suns("sunny.ron").len(), suns("sunny.ron --sky-sun off").len()), (1, 0));
    assert_eq!(suns("sunny.ron"), suns("a.glb"));
    let told = studio.succeed("inspect sunny.ron").out;
    assert!(told.contains("in the sky, along"), "{told}");
}

#[test]
fn a_mesh_is_an_input_by_itself() {
    let studio = Studio::new();
    let mesh = "mtllib box.mtl\nv -1 0 0\nv 1 0 0\nv 1 2 0\nv -1 2 0\nusemtl red\nf 1 2 3 4\n";
    std::fs::write(studio.path("box.obj"), mesh).unwrap();
    std::fs::write(studio.path("box.mtl"), "newmtl red\nKd 0.8 0.05 0.05\n").unwrap();
    let outcome = studio.succeed(&format!("render box.obj {DIRECT} --preview png"));
    assert!(
        outcome.err.contains("has no camera") && outcome.err.contains("--default-light off"),
        "{}",
        outcome.err
    );
    let shown = picture(&studio, "out/box/box.0001.png");
    let middle = shown.get_pixel(16, 9).0;
    assert!(middle[0] > middle[1] + 40, "{middle:?}");
    // A sequence may wrap it, and name the camera.
    let sequence = r#"Sequence(version: 1, scene: "box.obj", frames: (1, 2), size: (16, 9), samples: 1, camera: "camera")"#;
    std::fs::write(studio.path("turn.ron"), sequence).unwrap();
    assert!(studio.succeed("render turn.ron --out a/").err.contains("2 frames written"));
    assert!(studio.fail("render nothing.obj", 4).contains("nothing.obj: error: cannot be read"));
}

/// As a glTF file of points is: it is a file, and its losses say why there is nothing.
#[test]
fn a_mesh_of_points_alone_is_an_empty_picture_and_says_so() {
    let studio = Studio::new();
    std::fs::write(studio.path("cloud.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\nl 1 2 3\n").unwrap();
    let outcome = studio.succeed(&format!("render cloud.obj {DIRECT}"));
    for loss in ["points-and-lines", "nothing-to-draw"] {
        assert!(outcome.err.contains(&format!("warning[{loss}]")), "{}", outcome.err);
    }
    assert!(studio.fail(&format!("render cloud.obj {DIRECT} --strict"), 3).contains("points-and-lines"));
    let scene = r#"Scene(version: 1, cameras: { "c": () }, meshes: { "m": Obj("cloud.obj") }, objects: { "o": (mesh: "m") })"#;
    std::fs::write(studio.path("names_it.ron"), scene).unwrap();
    assert!(studio.fail(&format!("render names_it.ron {DIRECT}"), 3).contains("no triangles"));
}

/// Scaled to nothing: an object that hides that way, or by mistake.
#[test]
fn an_object_of_scale_0_is_said() {
    let studio = Studio::new();
    for (scale, is_told) in [("(0.0, 0.0, 0.0)", true), ("(1.0, 0.0, 1.0)", false), ("1.0", false)] {
        let object = format!(r#"objects: {{ "o": (mesh: "m", scale: {scale}) }}"#);
        let rest = r#"meshes: { "m": Cube(size_m: 1.0) }, cameras: { "c": (position_m: (0.0, 2.0, 4.0)) }"#;
        std::fs::write(studio.path("scaled.ron"), format!("Scene(version: 1, {object}, {rest})")).unwrap();
        let told = studio.succeed(&format!("render scaled.ron {DIRECT}")).err;
        assert_eq!(told.contains("`o` is scaled by 0"), is_told, "{scale}: {told}");
    }
}

/// Files that are hidden are no frames to other programs.
#[test]
fn frames_of_a_hidden_scene_are_seen() {
    let studio = Studio::new();
    std::fs::copy(studio.path("tiny.ron"), studio.path(".tiny.old.ron")).unwrap();
    studio.succeed("render .tiny.old.ron --frames 1 --size 16x9 --samples 1 --out a/");
    assert_eq!(studio.names("a"), ["tiny.old.0001.exr"]);
}

/// The made-up camera and light depend on the whole range, so a frame is the same alone and in it.
#[test]
fn frames_are_the_same_alone_and_in_a_range() {
    let studio = Studio::new();
    let file = input("two_clips.gltf");
    studio.succeed(&format!("render {file} {SMALL} --frames 1,9,17 --preview png --out a/x.####.exr"));
    studio.succeed(&format!("render {file} {SMALL} --frames 9 --preview png --out b/x.####.exr"));
    for name in ["x.0009.exr", "x.0009.png"] {
        assert_eq!(studio.bytes(&format!("a/{name}")), studio.bytes(&format!("b/{name}")), "{name}");
    }
}

#[test]
fn lights_in_blenders_unitless_mode_are_found_out() {
    let studio = Studio::new();
    let file = input("light_intensity_3_lux.gltf");
    let outcome = studio.succeed(&format!("render {file} {DIRECT} --out a/"));
    let warning = outcome.err.split("warning[dark-frame]").nth(1).unwrap();
    assert!(warning.contains("3.000 lux") && warning.contains("--light-units compat"), "{}", outcome.err);
    let helped = studio.succeed(&format!("render {file} {DIRECT} --light-units compat --out a/"));
    assert!(!helped.err.contains("dark-frame"), "{}", helped.err);
    let inspected = studio.succeed(&format!("inspect {file}")).out;
    assert!(
        inspected.contains("all lights are dim") && inspected.contains("--light-units compat"),
        "{inspected}"
    );
    let drawn = studio.succeed(&format!("preview {file} --size 32x18 --out a.png"));
    assert!(
        drawn.err.contains("warning[dark-frame]") && drawn.err.contains("--light-units compat"),
        "{}",
        drawn.err
    );
}

#[test]
fn dark_frames_are_counted_once_a_run() {
    let studio = Studio::new();
    let scene = String::from_utf8(studio.bytes("scene.ron")).unwrap();
    std::fs::write(studio.path("scene.ron"), scene.replace("(8.0, 7.2, 6.0)", "(0.0, 0.0, 0.0)")).unwrap();
    let outcome = studio.succeed("render tiny.ron --frames 2-4 --out a/ --progress none");
    assert_eq!(outcome.err.matches("dark-frame").count(), 1, "{}", outcome.err);
    assert!(
        outcome.err.contains("3 of 3 frames are next to black, the first is frame 2: all lights are off"),
        "{}",
        outcome.err
    );
}

/// A dim scene: its picture is brightened, its frame is not, and one exposure serves all frames.
#[test]
fn pictures_get_an_exposure_and_frames_do_not() {
    let studio = Studio::new();
    let scene = String::from_utf8(studio.bytes("scene.ron")).unwrap();
    std::fs::write(studio.path("scene.ron"), scene.replace("(8.0, 7.2, 6.0)", "(0.08, 0.072, 0.06)"))
        .unwrap();
    let render = "render tiny.ron --frames 3 --preview png";
    let auto = studio.succeed(&format!("{render} --out a/x.exr"));
    assert!(
        auto.err.contains("brighter than the light is") && auto.err.contains("--exposure 0"),
        "{}",
        auto.err
    );
    let plain = studio.succeed(&format!("{render} --exposure 0 --out b/x.exr"));
    assert!(!plain.err.contains("stops"), "{}", plain.err);
    studio.succeed(&format!("{render} --exposure auto --out c/x.exr"));
    let [auto, plain, said] = ["a/x.png", "b/x.png", "c/x.png"].map(|name| picture(&studio, name));
    assert!(brightness(&auto) > 2.0 * brightness(&plain), "{} {}", brightness(&auto), brightness(&plain));
    assert_eq!(auto, said);
    assert_eq!(studio.bytes("a/x.exr"), studio.bytes("b/x.exr"));
    // What the input says comes before what its pictures need, and the flag before both.
    let sequence = String::from_utf8(studio.bytes("tiny.ron")).unwrap();
    std::fs::write(studio.path("tiny.ron"), sequence.replace("samples: 2", "samples: 2, exposure: 0.0"))
        .unwrap();
    studio.succeed(&format!("{render} --out d/x.exr"));
    assert_eq!(picture(&studio, "d/x.png"), plain);
    studio.succeed(&format!("{render} --exposure auto --out e/x.exr"));
    assert_eq!(picture(&studio, "e/x.png"), auto);
}

/// The look of the input, and the flag's before it; frames know nothing of either.
#[test]
fn pictures_get_a_look_and_frames_do_not() {
    let studio = Studio::new();
    let render = "render tiny.ron --frames 3 --preview png --exposure 0";
    studio.succeed(&format!("{render} --out a/x.exr"));
    studio.succeed(&format!("{render} --look high-contrast --out b/x.exr"));
    let sequence = String::from_utf8(studio.bytes("tiny.ron")).unwrap();
    std::fs::write(studio.path("tiny.ron"), sequence.replace("samples: 2", "samples: 2, look: HighContrast"))
        .unwrap();
    studio.succeed(&format!("{render} --out c/x.exr"));
    studio.succeed(&format!("{render} --look none --out d/x.exr"));
    let [plain, high, said, none] =
        ["a/x.png", "b/x.png", "c/x.png", "d/x.png"].map(|name| picture(&studio, name));
    assert!(plain != high && high == said && plain == none);
    assert_eq!(studio.bytes("a/x.exr"), studio.bytes("b/x.exr"));
    // A glTF file keeps it.
    studio.succeed("export tiny.ron kept.glb");
    assert!(String::from_utf8_lossy(&studio.bytes("kept.glb")).contains("\"look\":\"high-contrast\""));
    studio.succeed("render kept.glb --frames 3 --preview png --exposure 0 --out e/x.exr");
    assert!(picture(&studio, "e/x.png") != plain);
}

#[test]
fn previews_get_an_exposure_too_of_scenes_and_of_frames() {
    let studio = Studio::new();
    let file = input("light_intensity_3_lux.gltf");
    studio.succeed(&format!("render {file} {SMALL} --out a/x.####.exr"));
    for source in [format!("{file} --size 32x18"), String::from("a")] {
        studio.succeed(&format!("preview {source} --out auto.png"));
        studio.succeed(&format!("preview {source} --exposure 0 --out plain.png"));
        let [auto, plain] = ["auto.png", "plain.png"].map(|name| brightness(&picture(&studio, name)));
        assert!(auto > 2.0 * plain + 5.0, "{source}: {auto} {plain}");
    }
    assert!(studio.fail("preview a --exposure bright", 2).contains("or auto"));
}

#[test]
fn noise_is_told_of_frames_and_of_the_run() {
    let studio = Studio::new();
    let rough = studio.succeed("render tiny.ron --tolerance 0.3 --frames 1-2 --out a/ --stats s.jsonl");
    let last = rough.err.lines().last().unwrap();
    assert!(last.contains("2 frames written to a/ in ") && last.contains("; noise up to "), "{}", rough.err);
    let noise = |line: &Value| line["noise"].as_f64().unwrap();
    let lines = statistics(&studio, "s.jsonl");
    studio.succeed("render tiny.ron --tolerance 0.02 --frames 1-2 --out a/ --stats t.jsonl");
    for (rough, fine) in lines.iter().zip(statistics(&studio, "t.jsonl")).skip(1) {
        // All of the picture is less noisy than its worst block, and better to a finer tolerance.
        assert!(noise(rough) > 0.0 && noise(rough) < rough["error"].as_f64().unwrap(), "{rough}");
        assert!(noise(&fine) < noise(rough) && noise(&fine) < 0.02, "{rough} {fine}");
    }
    let told = studio.succeed("render tiny.ron --tolerance 0.3 --frames 1 --out a/ --progress jsonl").out;
    let written: Value = told
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap())
        .find(|line| line["event"] == "frame_written")
        .unwrap();
    assert!(noise(&written) > 0.0 && written["error"].as_f64().is_some(), "{written}");
}
