//! Every sample from Blender against Blender's own evaluation of the same scene
//! (tests/data/blender/README.md), as `sunfleck inspect --json` tells it.

mod samples;
mod tangents;
mod truth;
mod vertices;

use crate::blender::samples::{SAMPLES, Sample, WITHOUT_TRUTH, What};
use crate::blender::truth::{Truth, light_difference, matrix, projection_difference, world_differences};
use crate::checkout;
use serde_json::Value;
use std::collections::BTreeSet;
use std::process::Command;

/// Matrix elements at whole frames: what single precision leaves.
const AT_WHOLE_FRAMES: f64 = 2e-6;
/// The same between two frames, where the exporter's samples are joined by straight lines.
const BETWEEN_FRAMES: f64 = 1e-2;

/// What the program says of a sample at the frames of its truth.
fn inspect(sample: &Sample, truth: &Truth) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let input = if sample.prepared.is_empty() {
        samples::path(sample.file)
    } else {
        let path = folder.path().join("prepared.glb");
        std::fs::write(&path, samples::prepared(sample.file, sample.prepared)).unwrap();
        path
    };
    let frames: Vec<String> = truth.frames().map(|frame| frame["frame"].to_string()).collect();
    let output = Command::new(checkout::program())
        .args(["inspect", "--json", "--frames", &frames.join(",")])
        .arg(&input)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}: {}", sample.file, String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Compares one sample; what is wrong, and how many values were compared.
fn compare(sample: &Sample, wrong: &mut Vec<String>) -> usize {
    let truth = Truth::read(sample.truth);
    let described = inspect(sample, &truth);
    let mut compared = 0;
    let mut met = BTreeSet::new();
    for (ours, theirs) in described["frames"].as_array().unwrap().iter().zip(truth.frames()) {
        let frame = theirs["frame"].as_f64().unwrap();
        assert_eq!(ours["frame"].as_f64().unwrap(), frame);
        let bar = if frame.fract() == 0.0 { AT_WHOLE_FRAMES } else { BETWEEN_FRAMES };
        let mut check = |object: &str, what: &str, difference: f64, bar: f64| {
            compared += 1;
            if difference <= bar {
                return;
            }
            match sample.known.iter().find_map(|known| known.covers(object, what, frame)) {
                Some(name) => {
                    met.insert((name, what.to_owned()));
                }
                None => {
                    let file = sample.file;
                    wrong.push(format!(
                        "{file}, frame {frame}, {what} of `{object}`: off by {difference:.1e}"
                    ));
                }
            }
        };
        for (name, object) in theirs["objects"].as_object().unwrap() {
            let Some(node) = ours["nodes"].get(name) else {
                check(name, "place", f64::INFINITY, bar);
                continue;
            };
            let (place, axes) = world_differences(&matrix(&node["world"]), &object["world"]);
            check(name, "place", place, bar);
            check(name, "axes", axes, bar);
            if let Some(camera) = object.get("camera") {
                let projection = ours["cameras"].get(name).map(|camera| matrix(&camera["projection"]));
                let difference = projection
                    .map_or(f64::INFINITY, |ours| projection_difference(&ours, &camera["projection_matrix"]));
                check(name, "projection", difference, bar);
            }
            if let Some(light) = object.get("light") {
                let difference = light_difference(ours["lights"].get(name), light);
                check(name, "light", difference, if frame.fract() == 0.0 { sample.light_bar } else { bar });
            }
        }
    }
    for known in sample.known {
        let (What::Always(what) | What::Between(what)) = known.what;
        for name in known.objects.iter().filter(|name| !met.contains(&(**name, what.to_owned()))) {
            wrong.push(format!("{}: {what} of `{name}` is right after all ({})", sample.file, known.reason));
        }
    }
    compared
}

#[test]
fn every_sample_is_what_blender_has() {
    let mut wrong = Vec::new();
    for sample in SAMPLES {
        let compared = compare(sample, &mut wrong);
        assert!(compared >= sample.least_compared, "{}: only {compared} values compared", sample.file);
    }
    assert!(wrong.is_empty(), "{} are wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn every_file_is_compared_or_said_why_not() {
    let listed = SAMPLES.iter().map(|sample| sample.file).chain(WITHOUT_TRUTH.iter().map(|(file, _)| *file));
    let listed: BTreeSet<String> = listed.map(str::to_owned).collect();
    assert_eq!(samples::files(), listed);
}
