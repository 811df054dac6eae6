//! glTF files as people have them, with something missing, damaged or unusual. Each is seen as well
//! as it can be, and what is lost is told by its kind. Most show the triangle of ok.gltf: then the
//! rest of them must look like it.

use crate::checkout;
use crate::common::{EXACT, INSTANT, camera_at, look};
use glam::DVec3;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use sunfleck::color::Rgb;
use sunfleck::description::{self, Description, Files, SceneSource, gltf};
use sunfleck::math::Sampler;
use sunfleck::scene::{self, Baking, RenderSettings, ResolveOptions, Scene};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};

/// What the light of ok.gltf brings: 2000 lux, straight onto the triangle.
const IRRADIANCE: f64 = 2000.0 / 683.0;
/// Losses that have nothing to do with what is tested.
const BESIDE: [&str; 2] = ["backface-culling", "no-light"];
/// Rays a side of the picture.
const SIDE: usize = 12;

fn folder() -> PathBuf {
    checkout::file("tests/data/cases/gltf")
}

type Resolved = Result<(Scene, RenderSettings), String>;

fn resolved(description: Description, animation: Option<&str>) -> Resolved {
    let options = ResolveOptions { animation: animation.map(str::to_owned), ..ResolveOptions::default() };
    scene::resolve_telling(description, &options, &Baking::ALONE).map_err(|problems| problems.to_string())
}

fn load(name: &str, animation: Option<&str>) -> Resolved {
    resolved(
        description::load(&folder().join(name)).map_err(|error| error.diagnostics().to_string())?,
        animation,
    )
}

/// A file whose JSON is at hand.
fn load_json(document: &Value) -> Resolved {
    let path = folder().join("changed.gltf");
    let mut files = Files::default();
    let bytes = serde_json::to_vec(document).unwrap();
    let scene = gltf::parse(&bytes, &path, &mut files).map_err(|error| error.diagnostics().to_string())?;
    let scene = SceneSource::Gltf(scene);
    resolved(
        Description { path, scene, sequence: None, content_hash: files.content_hash(), files: Vec::new() },
        None,
    )
}

fn json_of(name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder().join(name)).unwrap()).unwrap()
}

/// The ids of what is lost, in order, each once.
fn losses(scene: &Scene) -> Vec<&'static str> {
    let mut ids: Vec<_> = scene.remarks.losses().map(|(loss, _)| loss.id()).collect();
    ids.retain(|id| !BESIDE.contains(id));
    ids.sort_unstable();
    ids
}

/// What a camera three metres before the triangle sees, at so many seconds, row by row.
fn seen(mut scene: Scene, time_s: f64) -> Vec<Rgb> {
    let own = camera_at(DVec3::new(0.0, 0.0, 3.0));
    let node = scene.nodes.len();
    scene.nodes.extend(own.nodes);
    scene.cameras.extend(own.cameras);
    let camera = scene.cameras.len() - 1;
    scene.cameras[camera].node = node;
    let trees = MeshTrees::new(&scene);
    let mut shutter = INSTANT;
    (shutter.open_s, shutter.close_s) = (time_s, time_s);
    let snapshot = Snapshot::new(&scene, &trees, camera, 1.0, shutter);
    let mut scratch = Scratch::default();
    let mut look = |x: usize, y: usize| {
        let film = ((x as f64 + 0.437) / SIDE as f64, (y as f64 + 0.561) / SIDE as f64);
        let ray = snapshot.view.ray(film.0, film.1);
        radiance(&snapshot, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut scratch).radiance
    };
    (0..SIDE * SIDE).map(|pixel| look(pixel % SIDE, pixel / SIDE)).collect()
}

fn mean(pixels: &[Rgb]) -> Rgb {
    pixels.iter().sum::<Rgb>() / pixels.len() as f64
}

#[test]
fn each_case_shows_the_triangle_and_tells_what_is_lost() {
    let whole = seen(load("ok.gltf", None).unwrap().0, 0.0);
    assert!(mean(&whole).x > 0.05, "the triangle is not seen");
    let cases: &[(&str, &[&str])] = &[
        ("bom.gltf", &[]),
        ("integer_as_0.0_index.gltf", &[]),
        ("integer_as_3.0_count.gltf", &[]),
        ("basisu_used_not_required.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
        ("missing_image_file.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
        ("broken_png.gltf", &["texture-coordinates-missing", "texture-unreadable"]),
        ("camera_yfov_above_pi.gltf", &["camera-unusable"]),
        ("no_scenes.gltf", &[]),
        ("node_in_two_scenes.gltf", &["other-scenes"]),
        (
            "root_here_child_in_other_scene.gltf",
            &["hierarchy-repaired", "nodes-outside-scene", "other-scenes"],
        ),
        ("rotation_length_0.9.gltf", &["transform-repaired"]),
        ("rotation_zero.gltf", &["transform-repaired"]),
        ("one_zero_normal.gltf", &["normals-without-length"]),
        ("points_beside_triangles.gltf", &["points-and-lines"]),
        ("ok.glb", &[]),
        ("glb_empty_bin.glb", &[]),
        ("glb_trailing_bytes.glb", &["container-rest"]),
        ("glb_unknown_third_chunk.glb", &["container-rest"]),
    ];
    for (name, expected) in cases {
        let (scene, _) = load(name, None).unwrap_or_else(|problems| panic!("{name}: {problems}"));
        assert_eq!(losses(&scene), *expected, "{name}");
        assert_eq!(seen(scene, 0.0), whole, "{name}");
    }
}

#[test]
fn what_holds_nothing_is_told_and_what_cannot_be_understood_is_refused() {
    let (scene, _) = load("asset_only.gltf", None).unwrap();
    assert_eq!(losses(&scene), ["nothing-to-draw"]);
    let (scene, _) = load("zero_scale.gltf", None).unwrap();
    assert_eq!(mean(&seen(scene, 0.0)), Rgb::ZERO);
    let problems = load("required_unknown_extension.gltf", None).unwrap_err();
    assert!(problems.contains("EXT_foo") && problems.contains("remedy: "), "{problems}");
}

/// A second primitive of the same mesh, or a part of the file that the first one does not need, is damaged.
#[test]
fn what_is_damaged_is_left_out_and_the_rest_is_drawn() {
    let whole = seen(load("ok.gltf", None).unwrap().0, 0.0);
    let primitive = "/meshes/0/primitives/-";
    let cases: Vec<(&str, Value, &[&str])> = vec![
        (primitive, json!({ "attributes": {}, "material": 0 }), &["primitive-without-positions"]),
        (primitive, json!({}), &["primitive-without-positions"]),
        (primitive, json!({ "attributes": { "POSITION": 9 } }), &["primitive-damaged"]),
        (primitive, json!({ "attributes": { "POSITION": 0 }, "mode": 7 }), &["primitive-damaged"]),
        (primitive, json!({ "attributes": { "POSITION": 1 } }), &["primitive-damaged"]),
        ("/meshes/0/primitives/0/attributes/NORMAL", json!(1), &["attribute-damaged"]),
        ("/meshes/0/primitives/0/attributes/COLOR_0", json!(77), &["attribute-damaged"]),
        ("/meshes/0/primitives/0/targets", json!([{ "POSITION": 1 }]), &["morph-targets-damaged"]),
        ("/meshes/0/weights", json!([1.0]), &["morph-weights-without-targets"]),
        ("/nodes/0/skin", json!(4), &["reference-missing"]),
        ("/nodes/0/camera", json!(4), &["reference-missing"]),
        ("/nodes/0/children", json!([0, 5]), &["hierarchy-repaired", "reference-missing"]),
        ("/scene", json!(3), &["reference-missing"]),
        ("/skins", json!([{ "joints": [] }]), &["skin-damaged"]),
        ("/materials/0/alphaMode", json!("SOFT"), &["value-out-of-range"]),
        ("/materials/0/pbrMetallicRoughness/metallicFactor", json!(-1), &["value-out-of-range"]),
        ("/materials/0/pbrMetallicRoughness/roughnessFactor", json!(1.5), &["value-out-of-range"]),
        // Of light that goes through, of which there is none.
        (
            "/materials/0/extras",
            json!({ "sunfleck_material": { "coat_takes": [[1, 1, 1], [-1, 1, 1]] } }),
            &["value-out-of-range"],
        ),
        ("/materials/0/extras", json!({ "sunfleck_object": { "holdout": true } }), &["unknown-property"]),
        ("/meshes/0/extras", json!({ "sunfleck_leaf": { "translucency": 0.5 } }), &["unknown-property"]),
        ("/nodes/0/extras", json!({ "sunfleck_leaf": { "translucency": 0.5 } }), &["unknown-property"]),
        (
            "/extensions/KHR_lights_punctual/lights/0/extras",
            json!({ "sunfleck_light": { "angle": 0.1 } }),
            &["unknown-property"],
        ),
        (
            "/materials/0/pbrMetallicRoughness/metallicRoughnessTexture",
            json!({ "index": 3 }),
            &["texture-coordinates-missing", "texture-unreadable"],
        ),
        (
            "/animations",
            json!([{ "channels": [{ "sampler": 0, "target": { "node": 0, "path": "scale" } }],
                     "samplers": [{ "input": 0, "output": 0 }] }]),
            &["animation-damaged"],
        ),
    ];
    for (at, value, expected) in cases {
        let mut document = json_of("ok.gltf");
        put(&mut document, at, value.clone());
        let (scene, _) = load_json(&document).unwrap_or_else(|problems| panic!("{at} {value}: {problems}"));
        assert_eq!(losses(&scene), expected, "{at} {value}");
        assert!(scene.remarks.refusing_losses().is_some(), "{at}: nothing for --strict to refuse");
        assert_eq!(seen(scene, 0.0), whole, "{at} {value}");
    }
}

/// By its extension where that is all there is, and by its bytes where they stand for a plain image.
#[test]
fn images_of_other_formats_are_called_by_their_names() {
    let avif = "data:image/avif;base64,AAAAHGZ0eXBhdmlmAAAAAGF2aWZtaWYxbWlhZg==";
    let said = |texture: serde_json::Value| {
        let mut document = json_of("missing_image_file.gltf");
        document["textures"] = json!([texture]);
        document["images"] = json!([{ "uri": avif }]);
        let (scene, _) = load_json(&document).unwrap();
        scene.remarks.losses().map(|(_, remark)| remark.found.clone()).collect::<Vec<_>>().join("\n")
    };
    let by_extension = said(json!({ "extensions": { "EXT_texture_avif": { "source": 0 } } }));
    assert!(by_extension.contains("as `EXT_texture_avif` alone, which is not read"), "{by_extension}");
    let by_bytes = said(json!({ "source": 0 }));
    assert!(by_bytes.contains("not an image in a format that is read, but in AVIF"), "{by_bytes}");
    assert!(said(json!({})).contains("the texture has no image that can be read"));
}

#[test]
fn what_is_not_shown_is_not_read() {
    let mut document = json_of("missing_image_file.gltf");
    assert!(losses(&load_json(&document).unwrap().0).contains(&"texture-unreadable"));
    let nodes = document["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "name": "empty" }));
    let empty = nodes.len() - 1;
    document["scenes"] = json!([{ "nodes": [empty] }]);
    let said = losses(&load_json(&document).unwrap().0);
    assert!(!said.contains(&"texture-unreadable"), "{said:?}");
}

/// A member that is null is one that is not there.
#[test]
fn nulls_are_passed_over() {
    let whole = seen(load("ok.gltf", None).unwrap().0, 0.0);
    for at in ["/nodes/0/children", "/nodes/0/skin", "/meshes/0/weights", "/animations", "/asset/extras"] {
        let mut document = json_of("ok.gltf");
        put(&mut document, at, Value::Null);
        let (scene, _) = load_json(&document).unwrap_or_else(|problems| panic!("{at}: {problems}"));
        assert_eq!(losses(&scene), [""; 0], "{at}");
        assert_eq!(seen(scene, 0.0), whole, "{at}");
    }
}

/// A GLB file of chunks.
fn glb(chunks: &[(&[u8; 4], &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (kind, data) in chunks {
        body.extend((data.len() as u32).to_le_bytes());
        body.extend(*kind);
        body.extend(*data);
    }
    let length = (body.len() as u32 + 12).to_le_bytes();
    [b"glTF".as_slice(), &2_u32.to_le_bytes(), &length, &body].concat()
}

/// Its type and its data.
type Chunk<'a> = (&'a [u8; 4], &'a [u8]);

/// Readers have to pass over chunks that they do not know (glTF 2.0, 4.4.3), and may pass over marks.
#[test]
fn chunks_that_gltf_does_not_know_may_stand_anywhere() {
    let whole = seen(load("ok.gltf", None).unwrap().0, 0.0);
    let bytes = std::fs::read(folder().join("ok.glb")).unwrap();
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let (json, binary) = (&bytes[20..20 + json_length], &bytes[28 + json_length..]);
    let alone = std::fs::read(folder().join("ok.gltf")).unwrap();
    let [text, bin, other, empty]: [Chunk; 4] =
        [(b"JSON", json), (b"BIN\0", binary), (b"XYZW", b"12345678"), (b"NONE", b"")];
    let marked = [b"\xef\xbb\xbf".as_slice(), json].concat();
    let zeros = [json, b"\0\0\0\0"].concat();
    let cases: [(&[Chunk], &[&str]); 9] = [
        (&[text, other, bin], &["container-rest"]),
        (&[other, text, bin], &["container-rest"]),
        (&[text, empty, bin, other], &["container-rest"]),
        (&[text, bin, bin], &["container-rest"]),
        (&[text, bin, text], &["container-rest"]),
        (&[(b"JSON", &alone), other], &["container-rest"]),
        (&[(b"JSON", &alone), empty], &["container-rest"]),
        (&[(b"JSON", &marked), bin], &[]),
        (&[(b"JSON", &zeros), bin], &[]),
    ];
    for (number, (chunks, expected)) in cases.into_iter().enumerate() {
        let path = folder().join("changed.glb");
        let mut files = Files::default();
        let scene =
            gltf::parse(&glb(chunks), &path, &mut files).unwrap_or_else(|error| panic!("{number}: {error}"));
        let (scene, content_hash) = (SceneSource::Gltf(scene), files.content_hash());
        let (scene, _) =
            resolved(Description { path, scene, sequence: None, content_hash, files: Vec::new() }, None)
                .unwrap();
        assert_eq!(losses(&scene), *expected, "{number}");
        assert_eq!(seen(scene, 0.0), whole, "{number}");
    }
}

/// Puts a value at a JSON pointer; `-` is the end of a list.
fn put(document: &mut Value, at: &str, value: Value) {
    let (parent, last) = at.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Array(values) => values.push(value),
        Value::Object(values) => drop(values.insert(last.to_owned(), value)),
        other => panic!("{other} holds nothing"),
    }
}

#[test]
fn a_file_of_which_nothing_would_be_left_is_refused_with_the_reason() {
    let mut document = json_of("ok.gltf");
    document["buffers"][0]["uri"] = json!("nowhere.bin");
    let problems = load_json(&document).unwrap_err();
    assert!(problems.contains("nowhere.bin") && problems.contains("cannot be read"), "{problems}");

    // A mesh that no node of the scene has is none that is missed.
    document["nodes"][0] = json!({});
    assert_eq!(
        losses(&load_json(&document).unwrap().0),
        ["buffer-unreadable", "nothing-to-draw", "primitive-damaged"]
    );

    // With another mesh in a buffer that is there, that one is drawn.
    let mut document = json_of("ok.gltf");
    let lost = document["buffers"].as_array().unwrap().len();
    put(&mut document, "/buffers/-", json!({ "uri": "nowhere.bin", "byteLength": 36 }));
    let views = document["bufferViews"].as_array().unwrap().len();
    put(&mut document, "/bufferViews/-", json!({ "buffer": lost, "byteLength": 36 }));
    let accessors = document["accessors"].as_array().unwrap().len();
    let accessor = json!({ "bufferView": views, "componentType": 5126, "count": 3, "type": "VEC3" });
    put(&mut document, "/accessors/-", accessor);
    put(&mut document, "/meshes/0/primitives/-", json!({ "attributes": { "POSITION": accessors } }));
    let (scene, _) = load_json(&document).unwrap();
    assert_eq!(losses(&scene), ["buffer-unreadable", "primitive-damaged"]);
    assert_eq!(seen(scene, 0.0), seen(load("ok.gltf", None).unwrap().0, 0.0));
}

/// Of files that say their units nobody doubts them: those of other programs are dim by intent.
#[test]
fn units_are_doubted_where_they_were_guessed() {
    let path = folder().join("../../first/light_intensity_3_lux.gltf");
    let mut document: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let guessed = |document: &Value| load_json(document).unwrap().0.guessed_light_units;
    assert_eq!(guessed(&document), Some(scene::LightUnits::Spec));
    put(&mut document, "/scenes/0/extras", json!({ "sunfleck": { "version": 1, "light_units": "spec" } }));
    assert_eq!(guessed(&document), None);
}

/// White metal under light along the view, which it meets at right angles. It gives back `D / 4` by single
/// scattering, with `D = 1 / (pi alpha^2)`. All of it together gives back the inverse share of its albedo
/// more (Turquin 2019, equation 8).
#[test]
fn rough_metals_keep_their_energy() {
    for roughness in ["0.2", "0.5", "1.0"] {
        let (scene, _) = load(&format!("metal_roughness_{roughness}.gltf"), None).unwrap();
        let alpha = roughness.parse::<f64>().unwrap().powi(2);
        let found = look(&scene, &EXACT, 0.5, 0.5).radiance.x;
        let expected = IRRADIANCE / (4.0 * PI * alpha * alpha) / albedo_upright(alpha);
        assert!((found / expected - 1.0).abs() < 3e-3, "{roughness}: {found} {expected}");
    }
}

/// What single scattering by GGX with Smith's heights gives back of light along the normal: the integral of
/// `D(h) G1(l) cos(h)` over microfacets `h` that send it upwards.
fn albedo_upright(alpha: f64) -> f64 {
    const STEPS: usize = 20_000;
    let step = PI / 4.0 / STEPS as f64;
    let share = |index: usize| {
        let tilt = (index as f64 + 0.5) * step;
        let squared = alpha * alpha;
        let density = squared / (PI * ((squared - 1.0) * tilt.cos().powi(2) + 1.0).powi(2));
        let unshadowed = 2.0 / (1.0 + (1.0 + squared * (2.0 * tilt).tan().powi(2)).sqrt());
        2.0 * PI * tilt.sin() * tilt.cos() * density * unshadowed * step
    };
    (0..STEPS).map(share).sum()
}

#[test]
fn the_first_of_two_clips_plays_unless_another_is_asked_for() {
    let place = |animation: Option<&str>| {
        let (scene, settings) = load("two_clips.gltf", animation).unwrap();
        assert_eq!(settings.frames, 0..=24);
        let played: Vec<bool> = scene.animations.iter().map(|clip| clip.is_played).collect();
        (scene.placements(1.0)[0].world_from_node.translation, played, losses(&scene))
    };
    let (right, up) = (DVec3::new(3.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0));
    assert_eq!(place(None), (right, vec![true, false], vec!["animations-left-out"]));
    assert_eq!(place(Some("right")), (right, vec![true, false], vec![]));
    assert_eq!(place(Some("up")), (up, vec![false, true], vec![]));
    assert_eq!(place(Some("1")), (up, vec![false, true], vec![]));
    assert_eq!(place(Some("all")), (up, vec![true, true], vec!["animations-conflict"]));
    let problems = load("two_clips.gltf", Some("down")).unwrap_err();
    assert!(problems.contains("`right`, `up`"), "{problems}");
}

/// As Blender exports an action an object.
#[test]
fn clips_that_move_different_things_play_together() {
    let mut document = json_of("two_clips.gltf");
    put(&mut document, "/nodes/-", json!({ "name": "lamp" }));
    put(&mut document, "/scenes/0/nodes/-", json!(2));
    document["animations"][1]["channels"][0]["target"]["node"] = json!(2);
    let (scene, _) = load_json(&document).unwrap();
    assert_eq!(losses(&scene), [] as [&str; 0]);
    let moves: Vec<_> =
        scene.animations.iter().map(|clip| (clip.moves[0].as_str(), clip.is_played)).collect();
    assert_eq!(moves, [("node 0", true), ("lamp", true)]);
    let places: Vec<DVec3> =
        scene.placements(1.0).iter().map(|placement| placement.world_from_node.translation).collect();
    assert!(places.contains(&DVec3::new(3.0, 0.0, 0.0)) && places.contains(&DVec3::new(0.0, 3.0, 0.0)));
}

/// The middle of the triangle is seen and lit along its normal: `F D / 4` with `D = 1 / (pi alpha^2)` above,
/// Lambert beneath (KHR_materials_pbrSpecularGlossiness: `(1 - max(specular)) diffuse / pi`).
#[test]
fn specular_and_gloss_shine_as_their_extension_says() {
    for name in ["specgloss_only_not_required.gltf", "specgloss_required.gltf"] {
        let (scene, _) = load(name, None).unwrap();
        assert_eq!(losses(&scene), [] as [&str; 0], "{name}");
        assert!(scene.remarks.reported().any(|told| told.found.contains("are converted")), "{name}");
        let pixels = seen(scene, 0.0);
        let middle = pixels[SIDE * SIDE / 2 + SIDE / 2];
        let alpha = 0.7_f64 * 0.7;
        let specular = IRRADIANCE * 0.1 / (4.0 * PI * alpha * alpha);
        let diffuse = IRRADIANCE * (1.0 - 0.1) / PI;
        assert!((middle.x / specular - 1.0).abs() < 0.05, "{name}: {middle}, {specular}");
        assert!(((middle.y - middle.x) / diffuse - 1.0).abs() < 0.05, "{name}: {middle}, {diffuse}");
    }
}

/// A texture of specular colour and glossiness says the same as the factors do.
#[test]
fn a_texture_of_specular_and_gloss_multiplies_the_factors() {
    let texel = |red: u8, green: u8, blue: u8, alpha: u8| {
        let mut png = std::io::Cursor::new(Vec::new());
        let image = image::RgbaImage::from_pixel(1, 1, image::Rgba([red, green, blue, alpha]));
        image.write_to(&mut png, image::ImageFormat::Png).unwrap();
        base64::Engine::encode(&base64::engine::general_purpose::STANDARD, png.into_inner())
    };
    let mut document = json_of("specgloss_required.gltf");
    let extension = "/materials/0/extensions/KHR_materials_pbrSpecularGlossiness";
    let plain = seen(load_json(&document).unwrap().0, 0.0);
    // 188 in sRGB is 0.5029; 51 of 255 is 0.2 as it is.
    put(&mut document, &format!("{extension}/specularGlossinessTexture"), json!({ "index": 0 }));
    put(&mut document, "/textures", json!([{ "source": 0 }]));
    let uri = format!("data:image/png;base64,{}", texel(188, 255, 0, 51));
    put(&mut document, "/images", json!([{ "uri": uri }]));
    let textured = seen(load_json(&document).unwrap().0, 0.0);
    document.pointer_mut(extension).unwrap().as_object_mut().unwrap().remove("specularGlossinessTexture");
    put(&mut document, &format!("{extension}/specularFactor"), json!([0.1 * 0.502_886_5, 0.1, 0.0]));
    put(&mut document, &format!("{extension}/glossinessFactor"), json!(0.3 * 0.2));
    let factors = seen(load_json(&document).unwrap().0, 0.0);
    for ((textured, factors), plain) in textured.iter().zip(&factors).zip(&plain) {
        assert!((*textured - *factors).abs().max_element() < 1e-6, "{textured} {factors}");
        assert!(*plain == Rgb::ZERO || textured != plain);
    }
}

#[test]
fn alpha_of_vertices_blends() {
    let (scene, _) = load("vertex_alpha_blend.gltf", None).unwrap();
    assert_eq!(losses(&scene), [] as [&str; 0]);
    let whole = seen(load("ok.gltf", None).unwrap().0, 0.0);
    for (blended, whole) in seen(scene, 0.0).iter().zip(&whole) {
        assert!((*blended - 0.1 * *whole).abs().max_element() < 1e-6, "{blended} {whole}");
    }
}

/// Alpha is 0.1 at the feet of the triangle and 1 at its tip: what is above a half is left of
/// it, 4/9 of its height.
#[test]
fn alpha_of_vertices_masks() {
    let mut document = json_of("vertex_alpha_blend.gltf");
    document["materials"][0]["alphaMode"] = json!("MASK");
    let alphas = [0.1_f32, 0.1, 1.0];
    let bytes: Vec<u8> =
        alphas.iter().flat_map(|alpha| [1.0, 1.0, 1.0, *alpha]).flat_map(f32::to_le_bytes).collect();
    let encoded = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes);
    document["buffers"][1]["uri"] = json!(format!("data:application/octet-stream;base64,{encoded}"));
    let (scene, _) = load_json(&document).unwrap();
    assert_eq!(losses(&scene), [] as [&str; 0]);
    let mesh = &scene.meshes[0];
    let lowest = mesh.triangles.iter().flat_map(|triangle| triangle.vertices);
    let lowest = lowest.map(|vertex| mesh.positions[vertex as usize].y).fold(f32::INFINITY, f32::min);
    // From y = -1 to 1, as (0.5 - 0.1) / 0.9 of the way.
    assert!((f64::from(lowest) - (-1.0 + 2.0 * 0.4 / 0.9)).abs() < 1e-6, "{lowest}");
    assert!(mesh.alphas.is_empty());

    // Where the material is opaque it has no meaning.
    document["materials"][0]["alphaMode"] = json!("OPAQUE");
    let opaque = seen(load_json(&document).unwrap().0, 0.0);
    assert_eq!(opaque, seen(load("ok.gltf", None).unwrap().0, 0.0));
}

#[test]
fn alpha_of_vertices_is_exported() {
    let (scene, settings) = load("vertex_alpha_blend.gltf", None).unwrap();
    let before = seen(scene.clone(), 0.0);
    let exported = sunfleck::export::glb(&scene, &settings, Path::new("")).unwrap();
    let mut files = Files::default();
    let path = Path::new("exported.glb").to_owned();
    let read = gltf::parse(&[exported.head, exported.binary].concat(), &path, &mut files).unwrap();
    let scene = SceneSource::Gltf(read);
    let description =
        Description { path, scene, sequence: None, content_hash: files.content_hash(), files: Vec::new() };
    let after = seen(resolved(description, None).unwrap().0, 0.0);
    for (before, after) in before.iter().zip(&after) {
        assert!((*before - *after).abs().max_element() < 1e-5, "{before} {after}");
    }
}
