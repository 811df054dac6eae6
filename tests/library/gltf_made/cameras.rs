//! Cameras from the file to the frame: orthographic, keyed, with their lens shifted.

use crate::checkout;
use crate::gltf_made::file::{File, sample};
use serde_json::json;
use std::path::Path;
use std::process::Command;
use sunfleck::frame_file;

/// A square that shines in one colour on black.
fn shining() -> File {
    let mut file = File::new();
    file.material()["extensions"] = json!({ "KHR_materials_unlit": {} });
    file.json["scenes"][0]["extras"]["sunfleck"]["frame_start"] = json!(0);
    file.json["scenes"][0]["extras"]["sunfleck"]["frame_end"] = json!(24);
    file
}

fn orthographic(file: &mut File, half_width: f64, half_height: f64) {
    file.json["cameras"][0] = json!({ "type": "orthographic", "orthographic": {
        "xmag": half_width, "ymag": half_height, "znear": 0.1, "zfar": 10 } });
}

/// The program's frame of a file, red.
fn rendered(folder: &Path, file: &File, flags: &[&str]) -> Vec<f32> {
    std::fs::write(folder.join("made.gltf"), file.text()).unwrap();
    let output = Command::new(checkout::program())
        .current_dir(folder)
        .args(["render", "made.gltf", "--out", "made.####.exr"])
        .args(flags)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let number = flags.iter().skip_while(|flag| **flag != "--frames").nth(1).unwrap();
    let path = folder.join(format!("made.{:0>4}.exr", number));
    let frame = frame_file::read(&path).unwrap();
    std::fs::remove_file(path).unwrap();
    frame.frame.channel("R").unwrap().pixels.clone()
}

/// The share of the picture that a square of 2 m covers, box-filtered, is its share of the picture's area; a
/// keyed height changes it.
#[test]
fn orthographic_pictures_show_areas_true() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = shining();
    orthographic(&mut file, 2.5, 2.5);
    file.animate("/cameras/0/orthographic/ymag", "SCALAR", "LINEAR", &[0.0, 1.0], &[1.25, 2.5]);
    for (frame, half_height) in [("0", 1.25), ("12", 1.875), ("24", 2.5)] {
        let flags =
            ["--frames", frame, "--size", "25%", "--samples", "64", "--volume", "segments", "--bounces", "0"];
        let red = rendered(folder.path(), &file, &flags);
        let mean = red.iter().map(|value| f64::from(*value)).sum::<f64>() / red.len() as f64;
        let share = f64::min(1.0, 1.0 / (half_height * half_height));
        assert!((mean / share - 1.0).abs() < 0.01, "{frame}: {mean} {share}");
    }
}

/// Where a shifted lens shows the middle of the square: half a picture's width to the left per half.
#[test]
fn a_shifted_lens_moves_the_picture() {
    for (shift, middle) in
        [([0.0, 0.0], (0.5, 0.5)), ([0.25, 0.0], (0.25, 0.5)), ([0.0, -0.125], (0.5, 0.375))]
    {
        let mut file = shining();
        file.json["cameras"][0]["extras"] = json!({ "sunfleck_camera": { "shift": shift } });
        let scene = file.scene();
        let half = 0.5 / (3.0 * 0.75_f64.tan());
        for (side, shows) in [(0.98, true), (1.02, false)] {
            for (x, y) in [(side, 0.0), (-side, 0.0), (0.0, side), (0.0, -side)] {
                let film = (middle.0 + x * half, middle.1 + y * half);
                assert_eq!(sample(&scene, 0.0, film).surface.is_some(), shows, "{shift:?} {x} {y}");
            }
        }
    }
}

/// Slices against single rays, both from the file to the frame, with fog and a shifted lens.
#[test]
fn slices_see_through_a_shifted_lens() {
    let folder = tempfile::tempdir().unwrap();
    let mut file = File::new();
    file.json["cameras"][0]["extras"] = json!({ "sunfleck_camera": { "shift": [0.2, -0.1] } });
    let extras = &mut file.json["scenes"][0]["extras"];
    extras["sunfleck_fog"] =
        json!({ "density": 0.2, "anisotropy": 0.3, "bounds": [[-6, -6, -6], [6, 6, 6]] });
    // From above and the side.
    file.json["nodes"][2]["rotation"] = json!([-0.6, 0.2, 0.1, 0.768_114_574_786_860_8]);
    let picture = |volume: &str, samples: &str| {
        rendered(folder.path(), &file, &["--frames", "1", "--volume", volume, "--samples", samples])
    };
    let (slices, rays) = (picture("slices", "64"), picture("segments", "256"));
    let mean = rays.iter().sum::<f32>() / rays.len() as f32;
    let square = slices.iter().zip(&rays).map(|(a, b)| (a - b).powi(2)).sum::<f32>() / rays.len() as f32;
    assert!(square.sqrt() < 0.02 * mean, "{} of {mean}", square.sqrt());
    assert!(rays.iter().any(|value| *value > 1.2 * mean) && rays.iter().all(|value| *value > 0.0));
}
