//! The keys of exported motion, as Blender takes them: at every frame everything is where the scene has it.

use crate::checkout;
use glam::{DAffine3, DQuat, DVec3};
use gltf::animation::Interpolation;
use gltf::animation::util::ReadOutputs;
use std::collections::BTreeMap;
use std::path::Path;
use sunfleck::scene::{RenderSettings, Scene};
use sunfleck::{description, export, scene};

/// Keys nearer than this are one to Blender (measured in 5.0.1): with the last one's value, and at the
/// frame if one was there.
const ONE_KEY_FRAMES: f64 = 0.01;
/// Nearer than this to a key its value is shown.
const AT_KEY_FRAMES: f64 = 1e-4;

fn load(path: &Path) -> (Scene, RenderSettings) {
    scene::resolve(description::load(path).unwrap(), None).unwrap_or_else(|problems| panic!("{problems}"))
}

/// A curve in Blender: frames and values.
struct Curve {
    keys: Vec<(f64, Vec<f64>)>,
    are_steps: bool,
}

impl Curve {
    fn new(keys: impl Iterator<Item = (f64, Vec<f64>)>, are_steps: bool) -> Self {
        let mut merged: Vec<(f64, Vec<f64>)> = Vec::new();
        for (frame, value) in keys {
            match merged.last_mut() {
                Some(last) if frame - last.0 < ONE_KEY_FRAMES => {
                    let is_nearer = (frame - frame.round()).abs() < (last.0 - last.0.round()).abs();
                    *last = (if is_nearer { frame } else { last.0 }, value);
                }
                _ => merged.push((frame, value)),
            }
        }
        Self { keys: merged, are_steps }
    }

    fn at(&self, frame: f64) -> Vec<f64> {
        if let Some((_, value)) = self.keys.iter().find(|(key, _)| (key - frame).abs() < AT_KEY_FRAMES) {
            return value.clone();
        }
        let next = self.keys.partition_point(|(key, _)| *key <= frame);
        if next == 0 || next == self.keys.len() || self.are_steps {
            return self.keys[next.saturating_sub(1)].1.clone();
        }
        let (a, b) = (&self.keys[next - 1], &self.keys[next]);
        let share = (frame - a.0) / (b.0 - a.0);
        a.1.iter().zip(&b.1).map(|(a, b)| a + share * (b - a)).collect()
    }
}

/// All curves by node and property.
fn curves(glb: &[u8], frames_per_s: f64) -> BTreeMap<(String, &'static str), Curve> {
    let file = gltf::Gltf::from_slice(glb).unwrap();
    let blob = file.blob.as_deref().unwrap();
    let mut curves = BTreeMap::new();
    for channel in file.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>()) {
        let reader = channel.reader(|_| Some(blob));
        let frames: Vec<f64> =
            reader.read_inputs().unwrap().map(|time| frames_per_s * f64::from(time)).collect();
        let wide = |values: &[f32]| values.iter().map(|&value| f64::from(value)).collect::<Vec<f64>>();
        let (name, values): (_, Vec<Vec<f64>>) = match reader.read_outputs().unwrap() {
            ReadOutputs::Translations(all) => ("translation", all.map(|value| wide(&value)).collect()),
            ReadOutputs::Scales(all) => ("scale", all.map(|value| wide(&value)).collect()),
            ReadOutputs::Rotations(all) => ("rotation", all.into_f32().map(|value| wide(&value)).collect()),
            ReadOutputs::MorphTargetWeights(_) => continue,
        };
        // Blender reads no slopes.
        let interpolation = channel.sampler().interpolation();
        let values: Vec<Vec<f64>> = match interpolation {
            Interpolation::CubicSpline => values.into_iter().skip(1).step_by(3).collect(),
            _ => values,
        };
        assert_eq!(frames.len(), values.len());
        let curve = Curve::new(frames.into_iter().zip(values), interpolation == Interpolation::Step);
        curves.insert((channel.target().node().name().unwrap().to_owned(), name), curve);
    }
    curves
}

/// Opens the exported scene as Blender does; how many places were compared.
fn check(scene: &Scene, settings: &RenderSettings) -> usize {
    let exported = export::glb(scene, settings, Path::new("")).unwrap();
    let rate = f64::from(settings.frame_rate.numerator) / f64::from(settings.frame_rate.denominator);
    let curves = curves(&[exported.head, exported.binary].concat(), rate);
    let mut compared = 0;
    for frame in settings.frames.clone() {
        let placements = scene.placements(settings.frame_rate.seconds(frame as f64));
        for (node, placement) in scene.nodes.iter().zip(placements) {
            let of = |name| curves.get(&(node.name.clone(), name)).map(|curve| curve.at(frame as f64));
            let (place, turn, size) = (of("translation"), of("rotation"), of("scale"));
            if place.is_none() && turn.is_none() && size.is_none() {
                continue;
            }
            let still = placement.world_from_node.to_scale_rotation_translation();
            let found = DAffine3::from_scale_rotation_translation(
                size.map_or(still.0, |size| DVec3::from_slice(&size)),
                turn.map_or(still.1, |turn| DQuat::from_slice(&turn).normalize()),
                place.map_or(still.2, |place| DVec3::from_slice(&place)),
            );
            assert!(
                found.abs_diff_eq(placement.world_from_node, 1e-5),
                "`{}` at frame {frame}: {found} instead of {}",
                node.name,
                placement.world_from_node
            );
            compared += 1;
        }
    }
    compared
}

fn check_file(path: &Path) {
    let (scene, mut settings) = load(path);
    settings.frames = 1..=48;
    for shutter in [0.0, 0.5, 0.012] {
        settings.shutter = shutter;
        assert!(check(&scene, &settings) > 5 * 48);
    }
}

#[test]
fn curves_and_jumps_are_exact_at_every_frame() {
    check_file(&checkout::file("tests/data/valid/ron/keyed_every_way_moving.ron"));
}

#[test]
fn falling_leaves_are_exact_at_every_frame() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.ron");
    std::fs::write(&path, FALLING).unwrap();
    check_file(&path);
}

const FALLING: &str = r#"Scene(version: 1, meshes: { "leaf": Leaf(length_m: 0.1, width_m: 0.06), "ground": Quad(size_m: 20.0) },
    materials: { "gold": (base_color: 0.5) },
    objects: { "ground": (mesh: "ground") },
    fall: { "shower": (count: 60, seed: 3, species: [(meshes: ["leaf"], materials: ["gold"], length_m: (0.06, 0.1))],
        emitter: Box(min_m: (-2.0, 0.2, -2.0), max_m: (2.0, 2.0, 2.0)), release_s: (-1.0, 1.0)) },
    cameras: { "main": (position_m: (0.0, 1.0, 14.0), look_at_m: (0.0, 1.0, 0.0)) },
)"#;
