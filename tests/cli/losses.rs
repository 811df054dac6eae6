//! What a file asks for and does not get is said once a kind, and refused by `--strict`.

use crate::checkout;
use crate::program::Studio;
use serde_json::Value;

/// Exit code of scenes that cannot be used.
const SCENE: i32 = 3;

/// A file that asks for back faces to be hidden.
const CARDS: &str = "checkout:tests/data/blender/b_leafcards.glb";

#[test]
fn inspect_and_statistics_list_losses_by_id() {
    let studio = Studio::new();
    let described: Value =
        serde_json::from_str(&studio.succeed(&format!("inspect {} --json", CARDS)).out).unwrap();
    let losses = described["losses"].as_array().unwrap();
    let culling = losses.iter().find(|loss| loss["id"] == "backface-culling").unwrap();
    assert!(
        culling["count"].as_u64().unwrap() > 0 && culling["place"].as_str().unwrap().ends_with(".glb"),
        "{culling}"
    );

    studio
        .succeed(&format!("render {} --size 8x4 --samples 1 --frames 1 --out a/ --stats stats.jsonl", CARDS));
    let stats = String::from_utf8(studio.bytes("stats.jsonl")).unwrap();
    let first: Value = serde_json::from_str(stats.lines().next().unwrap()).unwrap();
    assert_eq!(&first["losses"], &described["losses"]);
}

#[test]
fn strict_refuses_every_loss_and_writes_nothing() {
    let studio = Studio::new();
    for line in [
        "render CARDS --strict --size 8x4 --samples 1 --out a/",
        "inspect CARDS --strict",
        "preview CARDS --strict --out a/",
        "export CARDS a.glb --strict",
    ] {
        let message = studio.fail(&line.replace("CARDS", CARDS), SCENE);
        assert!(
            message.contains("error[backface-culling]: ") && message.contains("remedy: "),
            "{line}: {message}"
        );
    }
    assert_eq!(studio.names("."), ["scene.ron", "tiny.ron"]);
    studio.succeed("render tiny.ron --strict --frames 1 --out a/");
}

/// A cube has no texture coordinates: it has the corner's colour, as its glTF file has.
#[test]
fn textures_of_shapes_without_coordinates_are_told() {
    let studio = Studio::new();
    image::RgbImage::from_pixel(1, 1, image::Rgb([255, 0, 0])).save(studio.path("t.png")).unwrap();
    let scene = r#"Scene(version: 1, meshes: { "cube": Cube(size_m: 1.0) }, materials: { "m": (texture: "t.png") },
        objects: { "a": (mesh: "cube", material: "m"), "b": (mesh: "cube", material: "m", translation_m: (2.0, 0.0, 0.0)) },
        cameras: { "main": (position_m: (0.0, 0.0, 1.0)) },
        lights: { "sun": Sun(to_sun: (0.0, 0.0, 1.0), irradiance_w_per_m2: 3.14159265) })"#;
    std::fs::write(studio.path("cube.ron"), scene).unwrap();
    let flags = "--frames 1 --size 8x4 --samples 1 --bounces 0";
    let told = studio.succeed(&format!("render cube.ron {flags} --out a.exr")).err;
    assert_eq!(told.matches("warning[texture-coordinates-missing]: ").count(), 1, "{told}");
    assert!(told.contains("meshes.cube"), "{told}");
    studio.succeed("export cube.ron cube.glb");
    studio.succeed(&format!("render cube.glb {flags} --out b.exr"));
    for name in ["a.exr", "b.exr"] {
        let frame = studio.frame(name).frame;
        let [red, green] = ["R", "G"].map(|name| frame.channel(name).unwrap().pixels[2 * 8 + 4]);
        assert!((red - 1.0).abs() < 0.01 && green < 0.01, "{name}: {red} {green}");
    }
    studio.fail(&format!("render cube.ron --strict {flags} --out c.exr"), SCENE);
}

/// What a damaged OBJ file leaves is drawn, unless all is wanted.
#[test]
fn damaged_meshes_are_drawn_with_a_word_and_refused_by_strict() {
    let studio = Studio::new();
    let case = |name: &str| format!("checkout:tests/data/obj/obj_mtl_{name}.ron");
    for (name, loss) in [("missing", "mtl-missing"), ("missing_texture", "mtl-texture")] {
        let told = studio.succeed(&format!("render {} --size 8x4 --samples 1 --out a/", case(name))).err;
        assert_eq!(told.matches(&format!("warning[{loss}]: ")).count(), 1, "{told}");
        let message =
            studio.fail(&format!("render {} --strict --size 8x4 --samples 1 --out b/", case(name)), SCENE);
        assert!(message.contains(&format!("error[{loss}]: ")) && message.contains("remedy: "), "{message}");
    }
    studio.succeed(&format!("render {} --strict --size 8x4 --samples 1 --out c/", case("Ks_one_number")));
}

/// Each file is drawn without what is damaged, unless that is not wanted.
#[test]
fn strict_refuses_what_is_only_nearly_drawn() {
    let studio = Studio::new();
    for (name, id) in [
        ("missing_image_file.gltf", "texture-unreadable"),
        ("basisu_used_not_required.gltf", "texture-unreadable"),
        ("rotation_zero.gltf", "transform-repaired"),
        ("camera_yfov_above_pi.gltf", "camera-unusable"),
        ("root_here_child_in_other_scene.gltf", "hierarchy-repaired"),
        ("glb_unknown_third_chunk.glb", "container-rest"),
        ("points_beside_triangles.gltf", "points-and-lines"),
        ("two_clips.gltf", "animations-left-out"),
        ("asset_only.gltf", "nothing-to-draw"),
    ] {
        let path = format!("checkout:tests/data/cases/gltf/{name}");
        studio.succeed(&format!("inspect {path}"));
        let message = studio.fail(&format!("inspect {path} --strict"), SCENE);
        assert!(message.contains(&format!("error[{id}]: ")), "{name}: {message}");
    }
    let clean = "checkout:tests/data/cases/gltf/ok.gltf";
    studio.succeed(&format!("inspect {clean} --strict"));
}

#[test]
fn animations_are_chosen_by_name_and_listed() {
    let studio = Studio::new();
    let clips = "checkout:tests/data/cases/gltf/two_clips.gltf";
    let described: Value =
        serde_json::from_str(&studio.succeed(&format!("inspect {clips} --animation up --json")).out).unwrap();
    let animations = described["animations"].as_array().unwrap();
    assert_eq!(animations[0]["name"], "right");
    assert_eq!((&animations[0]["played"], &animations[1]["played"]), (&false.into(), &true.into()));
    assert_eq!(animations[1]["frame_end"], 24.0);
    assert_eq!(animations[1]["moves"], serde_json::json!(["node 0"]));
    assert!(studio.succeed(&format!("inspect {clips}")).out.contains("animation  `up`: frames 0 to 24"));

    let message = studio.fail(&format!("inspect {clips} --animation down"), 2);
    assert!(message.contains("`right`, `up`") && message.contains("remedy: "), "{message}");
    studio.fail("inspect scene.ron --animation down", 2);

    let sequence = |animation: &str| {
        let scene = checkout::file("tests/data/cases/gltf/two_clips.gltf");
        let text = format!("Sequence(version: 1, scene: {scene:?}, animation: \"{animation}\")");
        std::fs::write(studio.path("clip.ron"), text).unwrap();
    };
    sequence("up");
    assert!(studio.succeed("inspect clip.ron").out.contains("`up`: frames 0 to 24, moves `node 0`; played"));
    // The command line goes before the file.
    assert!(
        studio
            .succeed("inspect clip.ron --animation right")
            .out
            .contains("`up`: frames 0 to 24, moves `node 0`; not played")
    );
    sequence("down");
    assert!(studio.fail("inspect clip.ron", SCENE).contains("there is no animation `down`"));
    std::fs::write(studio.path("clip.ron"), "Sequence(version: 1, scene: \"scene.ron\", animation: \"up\")")
        .unwrap();
    assert!(studio.fail("inspect clip.ron", SCENE).contains("clip.ron: animation: error"));
}

/// Frames of one animation are none of another; without the flag the hash is what it was.
#[test]
fn frames_of_another_animation_are_rendered_again() {
    let studio = Studio::new();
    let clips = "checkout:tests/data/cases/gltf/two_clips.gltf";
    let render = |more: &str| {
        let line = format!(
            "render {clips} --size 8x4 --samples 1 --frames 12 --out a/ --skip valid --progress plain {more}"
        );
        studio.succeed(&line).err
    };
    render("--animation up");
    let bytes = studio.bytes("a/two_clips.0012.exr");
    render("--animation right");
    assert_ne!(bytes, studio.bytes("a/two_clips.0012.exr"));
}

/// Indirect light that may be wrong by far more than was asked for is said. It is no frame for who wants all.
#[test]
fn indirect_light_far_from_the_tolerance_is_said_and_refused_by_strict() {
    /// Exit code of a frame that fails its checks.
    const FRAME: i32 = 5;
    let studio = Studio::new();
    let render = "render checkout:tests/data/leaves500/leaves500.glb --frames 1 --size 32x18 --samples 2";
    let told = studio.succeed(&format!("{render} --tolerance 0.0005 --out a/")).err;
    assert_eq!(told.matches("warning[indirect-light]: ").count(), 1, "{told}");
    let message = studio.fail(&format!("{render} --tolerance 0.0005 --strict --out b/"), FRAME);
    assert!(message.contains("error[indirect-light]: ") && message.contains("remedy: "), "{message}");
    assert!(studio.names(".").iter().all(|name| name != "b") || studio.names("b").is_empty());
    let quiet = studio.succeed(&format!("{render} --tolerance 0.5 --strict --out c/")).err;
    assert!(!quiet.contains("indirect-light"), "{quiet}");
}
