//! Cryptomatte: coverages against areas, times and alphas that are known, by rays and from slices.

use crate::common::{EXACT, INSTANT, add_light, camera_at, place};
use glam::{DAffine3, DVec2, DVec3};
use std::collections::BTreeMap;
use sunfleck::color::Rgb;
use sunfleck::film::Frame;
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    AlphaMode, Extend, Instance, Key, LightKind, Material, Mesh, Motion, PixelFilter, Rotation, Sampling,
    Scene, Segment, Size, Track, Triangle, Window, matte_id,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

const SIZE: Size = Size { width: 16, height: 16 };

/// A square of 2 m across, parallel to the picture, called `name`.
fn add_square(scene: &mut Scene, name: &str, motion: Motion, alpha: f64) {
    let node = place(scene, DAffine3::IDENTITY);
    (scene.nodes[node].name, scene.nodes[node].motion) = (name.to_owned(), motion);
    let alpha_mode = if alpha < 1.0 { AlphaMode::Blend } else { AlphaMode::Opaque };
    scene.materials.push(Material { alpha_mode, opacity: alpha, ..Material::default() });
    let material = scene.materials.len() - 1;
    scene.meshes.push(Mesh {
        positions: [
            DVec2::new(-1.0, -1.0),
            DVec2::new(1.0, -1.0),
            DVec2::new(1.0, 1.0),
            DVec2::new(-1.0, 1.0),
        ]
        .map(|corner| corner.extend(0.0).as_vec3())
        .to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.instances.len() as u32 + 1);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

fn at(place: DVec3) -> Motion {
    Motion::Still(DAffine3::from_translation(place))
}

fn picture(scene: &Scene, shutter: Shutter, samples: u32, method: Method) -> Frame {
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, 1.0, shutter).with_mattes(scene);
    let job = Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: vec![Pass::Cryptomatte],
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed: 0,
        mirror_depth: EXACT.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    };
    render(&exposure, &job, &Watch::NOBODY).frame
}

/// Coverages of a pixel by id, as a reader finds them: ids and coverages in turns, ranked.
fn coverages(frame: &Frame, x: usize, y: usize) -> BTreeMap<u32, f64> {
    let pixel = frame.window.index(x, y).expect("a pixel");
    let mut found = BTreeMap::new();
    let mut last = f32::INFINITY;
    for layer in 0..3 {
        for (id, coverage) in [("R", "G"), ("B", "A")] {
            let value = |letter: &str| {
                frame.channel(&format!("CryptoObject{layer:02}.{letter}")).expect("a channel").pixels[pixel]
            };
            let (id, coverage) = (value(id), value(coverage));
            assert!(coverage <= last, "ranks descend");
            last = coverage;
            if coverage > 0.0 {
                assert!(found.insert(id.to_bits(), f64::from(coverage)).is_none(), "an id has one rank");
            }
        }
    }
    found
}

/// A right angle 4 m away has 2 pixels a metre.
#[test]
fn edges_cover_as_much_as_their_area() {
    let mut scene = camera_at(DVec3::ZERO);
    // From x = 0.125 m, so 8.25 pixels, to 2.125 m, so 12.25 pixels.
    add_square(&mut scene, "leaf", at(DVec3::new(1.125, 0.0, -4.0)), 1.0);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.2, -1.0, -0.4), Rgb::ONE);
    for method in [Method::Segments, Method::Slices] {
        let frame = picture(&scene, INSTANT, 256, method);
        for (x, expected) in [(7, 0.0), (8, 0.75), (9, 1.0), (11, 1.0), (12, 0.25), (13, 0.0)] {
            let found = coverages(&frame, x, 8);
            let share = found.get(&matte_id("leaf")).copied().unwrap_or(0.0);
            assert!((share - expected).abs() < 0.04, "{method:?} {x}: {share} {expected}");
            assert!(found.keys().all(|id| *id == matte_id("leaf")));
        }
    }
}

/// A square that crosses a pixel covers it for a part of the time; who stands behind it covers the rest.
#[test]
fn motion_blur_covers_as_long_as_it_lasts() {
    let mut scene = camera_at(DVec3::ZERO);
    let key = |time_s: f64, x: f64| Key { time_s, value: DVec3::new(x, 0.0, -4.0), to_next: Segment::Linear };
    // Its right edge comes from the middle of the picture and goes four pixels to the right.
    let track = Track::new(vec![key(0.0, -1.0), key(1.0, 1.0)], Extend::Hold).expect("good keys");
    let angles = Rotation::EulerXyz(DVec3::ZERO.into());
    add_square(
        &mut scene,
        "passing",
        Motion::Keyed { translation: track, rotation: angles, scale: DVec3::ONE.into() },
        1.0,
    );
    let large =
        DAffine3::from_scale_rotation_translation(DVec3::splat(9.0), glam::DQuat::IDENTITY, -5.0 * DVec3::Z);
    add_square(&mut scene, "wall", Motion::Still(large), 1.0);
    let frame = picture(&scene, Shutter { open_s: 0.0, close_s: 1.0 }, 512, Method::Segments);
    for column in 0..4 {
        // The edge passes a pixel's middle after so much of the time.
        let expected = 1.0 - (f64::from(column) + 0.5) / 4.0;
        let found = coverages(&frame, 8 + column as usize, 8);
        let [passing, wall] = ["passing", "wall"].map(|name| found[&matte_id(name)]);
        // One of 33 moments is 3 %.
        assert!((passing - expected).abs() < 0.03, "{column}: {passing} {expected}");
        assert!((passing + wall - 1.0).abs() < 1e-6);
    }
}

/// What is seen through blended surfaces is covered by what they leave.
#[test]
fn blended_surfaces_share_a_pixel_by_their_alpha() {
    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, "veil", at(-2.0 * DVec3::Z), 0.3);
    add_square(&mut scene, "glass", at(-3.0 * DVec3::Z), 0.5);
    add_square(&mut scene, "leaf", at(-4.0 * DVec3::Z), 1.0);
    add_square(&mut scene, "hidden", at(-5.0 * DVec3::Z), 1.0);
    let found = coverages(&picture(&scene, INSTANT, 4, Method::Segments), 8, 8);
    let expected = [("veil", 0.3), ("glass", 0.35), ("leaf", 0.35)];
    assert_eq!(found.len(), 3, "{found:?}");
    for (name, share) in expected {
        assert!((found[&matte_id(name)] - share).abs() < 1e-6, "{name}: {found:?}");
    }
}

/// Leaves of one name are one matte.
#[test]
fn equal_names_are_one_object() {
    let mut scene = camera_at(DVec3::ZERO);
    add_square(&mut scene, "leaf", at(DVec3::new(-1.0, 0.0, -4.0)), 1.0);
    add_square(&mut scene, "leaf", at(DVec3::new(1.0, 0.0, -4.0)), 1.0);
    let frame = picture(&scene, INSTANT, 16, Method::Segments);
    // The border of the two runs between these pixels.
    for x in [7, 8] {
        assert_eq!(coverages(&frame, x, 8).len(), 1);
    }
}
