//! Sequences. In go fields of a file, out come render settings. Invariant: fields that are left out keep the
//! scene's settings.

use super::problems::Problems;
use crate::description::ron::{Frames, Number, SequenceFile, Whole};
use crate::diagnostic::Diagnostics;
use crate::scene::{FrameRate, Keyed, RenderSettings, Sampling, Scene, Size};
use std::collections::BTreeMap;

/// Maximum of `--volume-steps`.
const MOST_MARCH_STEPS: f64 = 1e6;

/// Frame rate of a sequence, if it has one.
pub(in crate::inside::scene) fn frame_rate(sequence: &SequenceFile) -> Option<FrameRate> {
    sequence.fields.frame_rate
}

pub(in crate::inside::scene) fn apply_sequence(
    sequence: SequenceFile,
    scene: &Scene,
    settings: RenderSettings,
) -> Result<RenderSettings, Diagnostics> {
    let mut problems = Problems::of(&sequence.path);
    let mut settings = RenderSettings { name: super::name_of(&sequence.path), ..settings };
    settings.frame_rate = frame_rate(&sequence).unwrap_or(settings.frame_rate);
    let fields = sequence.fields;
    if let Some(Frames(first, last)) = fields.frames {
        settings.frames = first..=last;
        settings.only_these_frames = true;
        outside_animation(&settings, scene, &mut problems);
    }
    if scene.animations.is_empty() && fields.animation.is_some_and(|name| name != "all") {
        let found = "the scene has no animations by name";
        problems.error("animation", found, "a .glb or .gltf scene with animations", "leave `animation` out");
    }
    if let Some((Whole(width), Whole(height))) = fields.size {
        settings.size = Size { width: width as usize, height: height as usize };
    }
    if let Some(name) = fields.camera {
        let known = scene.cameras.iter().map(|camera| (camera.name.as_str(), ()));
        problems.find("camera", "camera", &name, &known.collect::<BTreeMap<&str, ()>>());
        settings.camera = Some(name);
    }
    if let Some(passes) = fields.passes {
        settings.passes = passes;
        settings.passes.sort_unstable();
        settings.passes.dedup();
    }
    if let Some(march) = fields.march {
        settings.march_depth_m = march.depth_m.si();
        settings.march_step_m = march.step_m.si();
        check_march(&settings, &mut problems);
    }
    let (samples, tolerance) = (fields.samples.map(Whole::get), fields.tolerance.map(Number::si));
    settings.sampling = Sampling::said(samples, tolerance).unwrap_or(settings.sampling);
    settings.filter = fields.filter.unwrap_or(settings.filter);
    settings.seed = fields.seed.unwrap_or(settings.seed);
    settings.shutter = fields.shutter_frames.map_or(settings.shutter, |shutter| shutter.si());
    settings.shutter_position = fields.shutter_position.map_or(settings.shutter_position, |at| at.si());
    settings.exposure_stops = fields.exposure.map(|stops| stops.si()).or(settings.exposure_stops);
    settings.look = fields.look.unwrap_or(settings.look);
    settings.mirror_depth = fields.mirror_depth.map_or(settings.mirror_depth, |Whole(depth)| depth);
    settings.bounces = fields.bounces.unwrap_or(settings.bounces);
    problems.unless_any(settings)
}

/// Checks that the march's step is within its depth, and not too small.
fn check_march(settings: &RenderSettings, problems: &mut Problems) {
    let (depth_m, step_m) = (settings.march_depth_m, settings.march_step_m);
    if step_m > depth_m {
        let found = "the step is longer than the whole depth";
        problems.error("march.step_m", found, "a step of at most `depth_m`", "make the step shorter");
    }
    let steps = depth_m / step_m;
    if steps > MOST_MARCH_STEPS {
        let found = format!("{steps:.0} steps a ray would never end");
        let expected = format!("at most {MOST_MARCH_STEPS} steps from the camera to `depth_m`");
        problems.error("march.step_m", found, &expected, "make the step longer");
    }
}

/// Refuses frames that are all before the first key or all after the last, which is surely a mistake.
fn outside_animation(settings: &RenderSettings, scene: &Scene, problems: &mut Problems) {
    let seconds = |frame: i64| settings.frame_rate.seconds(frame as f64);
    let (first, last) = (*settings.frames.start(), *settings.frames.end());
    let Some((start_s, end_s)) = key_span_s(scene) else { return };
    if seconds(last) < start_s || seconds(first) > end_s {
        let frame = |time_s: f64| time_s / settings.frame_rate.seconds(1.0);
        let found = format!("frames {first} to {last} lie outside the animation; nothing would move");
        let expected = format!(
            "frames that meet {} to {} (seconds {start_s} to {end_s})",
            frame(start_s).floor(),
            frame(end_s).ceil()
        );
        problems.error("frames", found, &expected, "choose other frames, or move the keys");
    }
}

/// Times of the first and last key, in seconds; `None` without keys, or if anything repeats.
fn key_span_s(scene: &Scene) -> Option<(f64, f64)> {
    let changing = || scene.tracks().filter(|track| !track.is_constant());
    if changing().any(Keyed::is_endless) {
        return None;
    }
    changing().filter_map(Keyed::span_s).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}
