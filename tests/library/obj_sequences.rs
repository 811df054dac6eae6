//! Numbered OBJ files as meshes that move: against keyed transforms, and what is said of files that make no
//! sequence.

use crate::common::EXACT;
use glam::Vec3;
use std::fs;
use std::path::{Path, PathBuf};
use sunfleck::color::Rgb;
use sunfleck::description;
use sunfleck::math::Sampler;
use sunfleck::scene::{self, RenderSettings, Scene};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter, Snapshot};
use sunfleck::transport::{Scratch, radiance};

/// What a file a frame has of a leaf.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, String)]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            fs::write(folder.path(name), text).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The scene that shows a mesh, at 24 frames a second.
    fn shown(&self, mesh: &str, object: &str) -> Result<Scene, String> {
        let path = self.path("scene.ron");
        fs::write(&path, scene_text(mesh, object)).unwrap();
        load(&path).map(|(scene, _)| scene)
    }
}

fn scene_text(mesh: &str, object: &str) -> String {
    format!(
        r#"Scene(version: 1, meshes: {{ "leaf": {mesh} }}, objects: {{ "leaf": (mesh: "leaf", {object}) }},
        materials: {{ "veined": (normal_map: (texture: "n.png")), "card": (texture: "a.png", alpha_cutoff: 0.5) }},
        cameras: {{ "main": (position_m: (0.0, 0.0, 4.0), look_at_m: (0.0, 0.0, 0.0), fov_deg: 40.0) }},
        lights: {{ "sun": Sun(to_sun: (0.3, 0.4, 1.0), irradiance_w_per_m2: 3.0) }})"#
    )
}

fn load(path: &Path) -> Result<(Scene, RenderSettings), String> {
    let description = description::load(path).map_err(|error| error.diagnostics().to_string())?;
    scene::resolve(description, None).map_err(|error| error.to_string())
}

/// Two quads that meet at a bend, so far along x, with faces of four corners.
fn leaf(x: f64, bend: f64) -> String {
    let corner = |(at_x, at_y, z): (f64, f64, f64)| format!("v {} {at_y} {z}\n", at_x + x);
    let corners = [
        (-0.5, -0.4, bend),
        (0.0, -0.5, 0.0),
        (0.5, -0.4, bend),
        (-0.5, 0.4, bend),
        (0.0, 0.5, 0.0),
        (0.5, 0.4, bend),
    ];
    let uvs = "vt 0 0\nvt 0.5 0\nvt 1 0\nvt 0 1\nvt 0.5 1\nvt 1 1\n";
    let faces = "s 1\nf 1/1 2/2 5/5 4/4\nf 2/2 3/3 6/6 5/5\n";
    format!("{}{uvs}{faces}", corners.map(corner).concat())
}

/// Frames 3 to 7 of a leaf that goes a tenth of a metre along x in each.
fn travelling() -> Folder {
    let files =
        [3, 4, 5, 6, 7].map(|frame| (format!("l.{frame:04}.obj"), leaf(0.1 * f64::from(frame - 5), 0.2)));
    let files: Vec<_> = files.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
    let folder = Folder::new(&files);
    fs::write(folder.path("still.obj"), leaf(0.0, 0.2)).unwrap();
    folder
}

/// The same as keys of a transform.
const KEYED: &str = "translation_m: Keyed(keys: [(at_s: 0.125, value: (-0.2, 0.0, 0.0)), (at_s: 0.2916666666666667, value: (0.2, 0.0, 0.0))])";

/// What rays through the picture see, the mean over a shutter of so many frames about one.
fn picture(scene: &Scene, frame: f64, shutter_frames: f64) -> Vec<(Rgb, f64)> {
    let trees = MeshTrees::new(scene);
    let [open_s, close_s] = [-0.5, 0.5].map(|side| (frame + side * shutter_frames) / 24.0);
    let exposure = Exposure::new(scene, &trees, 0, 4.0 / 3.0, Shutter { open_s, close_s });
    let moments = exposure.moments();
    let ray = |index: usize| {
        let (x, y) = ((index % 80) as f64 / 80.0, (index / 80) as f64 / 60.0);
        let seen = |snapshot: &Snapshot| {
            let ray = snapshot.view.ray(x, y);
            let mut sampler = Sampler::new(0, 0, 0, 0);
            radiance(snapshot, &EXACT, &ray, &mut sampler, &mut Scratch::default())
        };
        let samples: Vec<_> = moments.iter().map(seen).collect();
        let count = samples.len() as f64;
        let color = samples.iter().map(|sample| sample.radiance).sum::<Rgb>() / count;
        (color, samples.iter().map(|sample| sample.alpha).sum::<f64>() / count)
    };
    (0..80 * 60).map(ray).collect()
}

/// How many rays see something else, of those that see anything. A vertex rounded otherwise
/// moves an edge by a ten-millionth.
fn differing(one: &[(Rgb, f64)], other: &[(Rgb, f64)]) -> (usize, usize) {
    let differ = |((a, b), (c, d)): (&(Rgb, f64), &(Rgb, f64))| {
        (*a - *c).abs().max_element() > 1e-4 || (b - d).abs() > 1e-4
    };
    let pairs = one.iter().zip(other);
    (pairs.filter(|&pair| differ(pair)).count(), one.iter().filter(|(_, alpha)| *alpha > 0.0).count())
}

#[test]
fn a_leaf_that_travels_is_the_leaf_under_a_keyed_transform() {
    let folder = travelling();
    let keyed = folder.shown("Obj(\"still.obj\")", KEYED).unwrap();
    for name in ["l.####.obj", "l.%04d.obj"] {
        let files = folder.shown(&format!("Obj({name:?})"), "").unwrap();
        // On a frame, between two, before the first and after the last.
        for (frame, shutter) in [(5.0, 0.0), (5.5, 0.0), (4.25, 0.5), (2.0, 0.5), (6.9, 1.0), (9.0, 0.0)] {
            let (one, other) = (picture(&files, frame, shutter), picture(&keyed, frame, shutter));
            let (differ, seen) = differing(&one, &other);
            assert!(differ <= 2 && seen > 300, "{name}, frame {frame}: {differ} of {seen}");
        }
        let (still, moved) = (picture(&files, 5.0, 0.0), picture(&files, 6.0, 0.0));
        assert!(differing(&still, &moved).0 > 40);
    }
}

/// The share of an open shutter in which the leaf covers a ray, by hand: its right edge goes from
/// 0.4 to 0.6 m while it is open for two frames about frame 5.
#[test]
fn a_blurred_edge_covers_as_much_as_the_time_says() {
    let folder = travelling();
    let scene = folder.shown("Obj(\"l.####.obj\")", "").unwrap();
    let trees = MeshTrees::new(&scene);
    let exposure = Exposure::new(&scene, &trees, 0, 1.0, shutter_about(5.0, 2.0));
    let (moments, depth) = (exposure.moments(), 4.0 - 0.2);
    for x in [0.41, 0.45, 0.5, 0.55, 0.59] {
        let film_x = 0.5 + 0.5 * x / (depth * 20.0_f64.to_radians().tan());
        let covers = |moment: &Snapshot| {
            let ray = moment.view.ray(film_x, 0.5);
            radiance(moment, &EXACT, &ray, &mut Sampler::new(0, 0, 0, 0), &mut Scratch::default()).alpha
        };
        let share = moments.iter().map(covers).sum::<f64>() / moments.len() as f64;
        assert!((share - (0.6 - x) / 0.2).abs() <= 1.0 / moments.len() as f64, "{x}: {share}");
    }
}

fn shutter_about(frame: f64, frames: f64) -> Shutter {
    Shutter { open_s: (frame - 0.5 * frames) / 24.0, close_s: (frame + 0.5 * frames) / 24.0 }
}

/// Frames 1 and 2 of a leaf that folds up, in a material and with a normal map.
#[test]
fn every_frame_is_its_file_in_masks_and_normal_maps_too() {
    let folder =
        Folder::new(&[("l1.obj", leaf(0.0, 0.0)), ("l2.obj", leaf(0.1, 0.4)), ("l3.obj", leaf(0.2, -0.3))]);
    let tilted = image::RgbImage::from_fn(8, 8, |x, _| image::Rgb([90 + 8 * x as u8, 150, 240]));
    tilted.save(folder.path("n.png")).unwrap();
    let disc = image::RgbaImage::from_fn(32, 32, |x, y| {
        let inside = (f64::from(x) - 15.5).hypot(f64::from(y) - 15.5) < 13.0;
        image::Rgba([200, 180, 60, if inside { 255 } else { 0 }])
    });
    disc.save(folder.path("a.png")).unwrap();
    for object in ["", "material: \"veined\"", "material: \"card\""] {
        let files = folder.shown("Obj(\"l#.obj\")", object).unwrap();
        for frame in 1..=3 {
            let alone = folder.shown(&format!("Obj(\"l{frame}.obj\")"), object).unwrap();
            let (one, other) = (picture(&files, f64::from(frame), 0.0), picture(&alone, 0.0, 0.0));
            let (differ, seen) = differing(&one, &other);
            // Colours in tangent space come from a few more sums.
            assert!(differ <= seen / 100 && seen > 150, "{object}, frame {frame}: {differ} of {seen}");
        }
    }
}

#[test]
fn rates_of_sequences_say_when_a_frame_is() {
    let folder = travelling();
    fs::write(folder.path("scene.ron"), scene_text("Obj(\"l.####.obj\")", "")).unwrap();
    let text = r#"Sequence(version: 1, scene: "scene.ron", frames: (3, 7), frame_rate: (10, 1))"#;
    fs::write(folder.path("shot.ron"), text).unwrap();
    let (scene, settings) = load(&folder.path("shot.ron")).unwrap();
    for frame in 3..=7 {
        let time_s = settings.frame_rate.seconds(f64::from(frame));
        let placements = scene.placements(time_s);
        let (positions, _) = scene.vertices(&scene.instances[0], &placements, time_s);
        let right = positions.iter().copied().reduce(Vec3::max).unwrap();
        assert!((f64::from(right.x) - 0.5 - 0.1 * f64::from(frame - 5)).abs() < 1e-6, "{frame}: {right}");
    }
}

#[test]
fn a_sequence_is_an_input_by_itself() {
    let (scene, settings) = load(&travelling().path("l.####.obj")).unwrap();
    assert_eq!((settings.name.as_str(), settings.frames, scene.instances.len()), ("l", 3..=7, 1));
    assert!(scene.instances[0].deformation.is_some());
    // A file by its own name is one file, whatever lies beside it.
    let (alone, settings) = load(&travelling().path("l.0004.obj")).unwrap();
    assert!(alone.instances[0].deformation.is_none() && settings.frames == (1..=1));
    assert!(alone.remarks.losses().next().is_none());
}

#[test]
fn what_is_no_sequence_is_told() {
    let gap = Folder::new(&[("l.0001.obj", leaf(0.0, 0.0)), ("l.0003.obj", leaf(0.0, 0.1))]);
    let message = gap.shown("Obj(\"l.####.obj\")", "").unwrap_err();
    let told = "l.0002.obj: error: this file is missing in the sequence";
    assert!(message.contains(told) && message.contains("remedy: "), "{message}");
    let nothing = Folder::new(&[]).shown("Obj(\"l.####.obj\")", "").unwrap_err();
    assert!(
        nothing.contains("no file is called so") && nothing.contains("scene.ron: meshes.leaf"),
        "{nothing}"
    );
    for field in [
        "emitter: Surface(object: \"leaf\")",
        "emitter: Box(min_m: (0.0, 1.0, 0.0), max_m: (0.0, 1.0, 0.0)), ground: (object: \"leaf\")",
    ] {
        let folder = travelling();
        let fall = format!(
            r#"fall: {{ "f": (count: 1, species: [(meshes: ["leaf"], length_m: 0.1)], {field}) }}, lights"#
        );
        fs::write(folder.path("s.ron"), scene_text("Obj(\"l.####.obj\")", "").replace("lights", &fall))
            .unwrap();
        let message = load(&folder.path("s.ron")).unwrap_err();
        assert!(message.contains("changes its shape"), "{message}");
    }
}

/// How much of the picture is seen.
fn covered(scene: &Scene, frame: f64) -> usize {
    picture(scene, frame, 0.0).iter().filter(|(_, alpha)| *alpha > 0.0).count()
}

/// Two frames of a leaf, one of half of it, none at all, and the leaf again: each from its frame on.
#[test]
fn other_faces_take_turns() {
    let half = leaf(0.1, 0.1).replace("f 2/2 3/3 6/6 5/5\n", "");
    let nothing = String::from("v 1 2 3\n");
    let files = [leaf(0.0, 0.1), leaf(0.1, 0.1), half, nothing, leaf(0.1, 0.1)];
    let files: Vec<_> = (1..).zip(files).map(|(number, text)| (format!("l{number}.obj"), text)).collect();
    let files: Vec<_> = files.iter().map(|(name, text)| (name.as_str(), text.clone())).collect();
    let folder = Folder::new(&files);
    let scene = folder.shown("Obj(\"l#.obj\")", "casts_shadow: false").unwrap();
    let alone = |number: usize| folder.shown(&format!("Obj(\"l{number}.obj\")"), "").unwrap();
    for (frame, number) in [(0.0, 1), (1.0, 1), (2.0, 2), (2.9, 2), (3.0, 3), (3.9, 3), (5.0, 5), (9.0, 5)] {
        let (one, other) = (picture(&scene, frame, 0.0), picture(&alone(number), 0.0, 0.0));
        let (differ, seen) = differing(&one, &other);
        assert!(differ <= 2 && seen > 150, "frame {frame}: {differ} of {seen}");
    }
    assert_eq!(covered(&scene, 4.0), 0);
    assert!(covered(&scene, 3.0) * 3 < covered(&scene, 2.0) * 2);
    // To passes and mattes all of them are one leaf.
    assert_eq!(scene.instances.len(), 3);
    assert!(scene.instances.iter().all(|one| one.leaf_id == 1 && scene.nodes[one.node].name == "leaf"));
    assert_eq!(scene.ray_visibility.len(), 4);
}

/// What does not move along takes turns as faces do: materials, by their own MTL files.
#[test]
fn other_materials_take_turns() {
    let folder = travelling();
    for frame in 3..=7 {
        let name = format!("l.{frame:04}");
        let text = format!("mtllib {name}.mtl\nusemtl m\n{}", leaf(0.1 * f64::from(frame - 5), 0.0));
        fs::write(folder.path(&format!("{name}.obj")), text).unwrap();
        let color = if frame < 5 { "1 0 0" } else { "0 1 0" };
        fs::write(folder.path(&format!("{name}.mtl")), format!("newmtl m\nKd {color}\nillum 1\n")).unwrap();
    }
    let scene = folder.shown("Obj(\"l.####.obj\")", "").unwrap();
    assert_eq!(scene.instances.iter().filter(|instance| instance.deformation.is_some()).count(), 2);
    assert!(scene.remarks.losses().next().is_none());
    for (frame, is_red) in [(3.0, true), (4.9, true), (5.0, false), (7.0, false)] {
        let seen = picture(&scene, frame, 0.0);
        let (color, _) = seen[30 * 80 + 40];
        assert!((color.x > 0.1, color.y > 0.1) == (is_red, !is_red), "frame {frame}: {color}");
    }
}
