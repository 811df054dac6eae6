//! The same motion by plain channels and by pointers; what is carried twice; ranges of frames.

use crate::gltf_made::file::{CAMERA, File, SQUARE, seen, vertices};
use serde_json::json;

const TURNS: [f32; 8] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.6, 0.0, 0.8];

fn bent(mut file: File) -> File {
    let raised = file.floats("VEC3", [[0.0, 0.0, 1.0]; 4].as_flattened());
    let widened = file.floats("VEC3", &[-1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0]);
    file.primitive()["targets"] = json!([{ "POSITION": raised }, { "POSITION": widened }]);
    file
}

#[test]
fn pointers_move_and_bend_as_channels_do() {
    let made = |targets: [&str; 4]| {
        let [place, turn, size, weights] = targets;
        let mut file = bent(File::new());
        file.animate(place, "VEC3", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, -3.0, 2.0, 1.0, -4.0]);
        file.animate(turn, "VEC4", "LINEAR", &[0.0, 1.0], &TURNS);
        file.animate(size, "VEC3", "STEP", &[0.0, 0.5], &[1.0, 1.0, 1.0, 2.0, 0.5, 1.0]);
        file.animate(weights, "SCALAR", "LINEAR", &[0.0, 1.0], &[0.0, 1.0, 2.0, -1.0]);
        file.scene()
    };
    let channels = made(["0 translation", "0 rotation", "0 scale", "0 weights"]);
    let pointers = made(["/nodes/0/translation", "/nodes/0/rotation", "/nodes/0/scale", "/nodes/0/weights"]);
    for time_s in [0.0, 0.3, 0.5, 0.9, 1.0] {
        assert_eq!(vertices(&channels, time_s), vertices(&pointers, time_s), "{time_s}");
    }
    assert_ne!(vertices(&pointers, 0.0), vertices(&pointers, 0.3));
}

#[test]
fn nodes_come_and_go() {
    let mut file = File::new();
    let visible = "/nodes/0/extensions/KHR_node_visibility/visible";
    let (input, output) =
        (file.floats("SCALAR", &[0.0, 1.0, 2.0]), file.numbers("SCALAR", 5121, [1, 0, 1], 3));
    file.animate(visible, "SCALAR", "STEP", &[0.0], &[0.0]);
    let animation = &mut file.json["animations"][0];
    (animation["samplers"][0]["input"], animation["samplers"][0]["output"]) = (json!(input), json!(output));
    let scene = file.scene();
    for (time_s, shows) in [(0.0, true), (0.99, true), (1.0, false), (1.99, false), (2.0, true), (5.0, true)]
    {
        assert_eq!(seen(&scene, time_s, (0.5, 0.5)).x > 0.0, shows, "{time_s}");
    }
}

/// `sunfleck_ctl` was put there by hand, and is taken; two of them cannot both be.
#[test]
fn a_value_that_is_carried_twice_is_taken_from_the_property_and_that_is_said() {
    let mut file = File::new();
    file.animate("/cameras/0/perspective/yfov", "SCALAR", "LINEAR", &[0.0, 1.0], &[0.5, 1.0]);
    let carries = |value: f64| {
        json!({ "name": "ctl", "translation": [value, 0, 0], "extras": { "sunfleck_ctl": {
        "target": "camera.sunfleck_camera.yfov", "channel": "translation.x" } } })
    };
    let nodes = file.json["nodes"].as_array_mut().unwrap();
    nodes.extend([carries(0.75), carries(0.875)]);
    file.json["scenes"][0]["nodes"] = json!([SQUARE, CAMERA, 2, 3, 4]);
    let scene = file.scene();
    assert_eq!(scene.cameras[0].lens.number().at(0.5), 0.875);
    let remarks = scene.remarks.to_string();
    for node in [3, 4] {
        let said = format!(
            "nodes[{node}].extras.sunfleck_ctl: note: something else animates `camera.sunfleck_camera.yfov` too"
        );
        assert!(remarks.contains(&said), "{remarks}");
    }
}

#[test]
fn frames_beside_all_keys_are_said() {
    let made = |first: u32, last: u32| {
        let mut file = File::new();
        file.animate("0 translation", "VEC3", "LINEAR", &[1.0, 2.0], &[0.0, 0.0, -3.0, 2.0, 1.0, -4.0]);
        let settings = &mut file.json["scenes"][0]["extras"]["sunfleck"];
        (settings["frame_start"], settings["frame_end"]) = (json!(first), json!(last));
        file.scene().remarks.to_string()
    };
    let said = "frames 50 to 60 are to be rendered, and keys lie on frames 24 to 48";
    assert!(made(50, 60).contains(said), "{}", made(50, 60));
    for (first, last) in [(24, 48), (1, 30), (48, 60)] {
        assert!(!made(first, last).contains("keys lie on frames"));
    }
}

/// Blender's *Start on Frame*, *Centre* and *End*.
#[test]
fn the_shutter_opens_where_the_file_says() {
    for (offset, [open, close]) in [(0.0, [10.0, 10.5]), (-0.25, [9.75, 10.25]), (-0.5, [9.5, 10.0])] {
        let mut file = File::new();
        let settings = &mut file.json["scenes"][0]["extras"]["sunfleck"];
        (settings["shutter"], settings["shutter_offset"]) = (json!(0.5), json!(offset));
        assert_eq!(file.load().1.shutter_around(10.0), [open, close]);
    }
}
