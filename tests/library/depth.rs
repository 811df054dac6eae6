//! The pass of depth while things move: each pixel shows a place where something was at a moment of
//! the shutter, and over pixels all moments alike. Held against every moment in double precision, by
//! rays and from slices.

use crate::common::{EXACT, add_light, camera_at, place};
use glam::{DAffine3, DVec2, DVec3};
use sunfleck::color::Rgb;
use sunfleck::film::Frame;
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    Extend, Instance, Key, LightKind, Material, Mesh, Motion, PixelFilter, Rotation, Sampling, Scene,
    Segment, Size, Track, Triangle, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

/// Tall, so that every column has many pixels; at 4 m, 16 of them are a metre.
const SIZE: Size = Size { width: 16, height: 128 };
/// How often the shutter looks, see `snapshot/exposure.rs`.
const MOMENTS: usize = 33;
/// Moments of the truth.
const MANY: u32 = 100_000;
const WALL_M: f64 = 9.0;

/// A square of `half_m` to each side of its middle that moves in a straight line while the shutter is open.
fn add_card(scene: &mut Scene, half_m: f64, from: DVec3, to: DVec3) {
    let node = place(scene, DAffine3::IDENTITY);
    let key = |time_s: f64, value: DVec3| Key { time_s, value, to_next: Segment::Linear };
    scene.nodes[node].motion = Motion::Keyed {
        translation: Track::new(vec![key(0.0, from), key(1.0, to)], Extend::Hold).unwrap(),
        rotation: Rotation::EulerXyz(DVec3::ZERO.into()),
        scale: DVec3::splat(half_m).into(),
    };
    scene.materials.push(Material::default());
    let material = scene.materials.len() - 1;
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    scene.meshes.push(Mesh {
        positions: corners.map(|(x, y)| DVec2::new(x, y).extend(0.0).as_vec3()).to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material }).to_vec(),
        ..Mesh::default()
    });
    let (mesh, leaf_id) = (scene.meshes.len() - 1, scene.instances.len() as u32 + 1);
    scene.instances.push(Instance { node, mesh, material: None, leaf_id, deformation: None });
}

fn stage() -> Scene {
    let mut scene = camera_at(DVec3::ZERO);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.2, -1.0, -0.4), Rgb::ONE);
    scene
}

fn picture(scene: &Scene, method: Method, seed: u32) -> Frame {
    let shutter = Shutter { open_s: 0.0, close_s: 1.0 };
    let aspect = SIZE.width as f64 / SIZE.height as f64;
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, aspect, shutter);
    let job = Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: vec![Pass::Depth, Pass::Position, Pass::LeafId],
        sampling: Sampling::Exactly(16),
        filter: PixelFilter::Box,
        seed,
        mirror_depth: EXACT.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    };
    render(&exposure, &job, &Watch::NOBODY).frame
}

fn channel<'a>(frame: &'a Frame, name: &str) -> impl Iterator<Item = f64> + use<'a> {
    frame.channel(name).unwrap().pixels.iter().map(|&value| f64::from(value))
}

/// The mean over the shutter of what a function of time says.
fn over_time(mut depth_m: impl FnMut(f64) -> f64) -> f64 {
    (0..MANY).map(|moment| depth_m((f64::from(moment) + 0.5) / f64::from(MANY))).sum::<f64>()
        / f64::from(MANY)
}

/// Rendered with each of these seeds, so that means over pixels have little noise.
const SEEDS: u32 = 16;

#[test]
fn a_card_that_comes_nearer_is_where_it_was_at_some_moment_and_at_all_of_them_alike() {
    let mut scene = stage();
    let depth_m = |time: f64| 6.0 - 4.0 * time;
    add_card(&mut scene, 90.0, DVec3::new(0.0, 0.0, -6.0), DVec3::new(0.0, 0.0, -2.0));
    for method in [Method::Segments, Method::Slices] {
        let (mut seen, mut sum) = ([0.0; MOMENTS], 0.0);
        for seed in 0..SEEDS {
            let frame = picture(&scene, method, seed);
            for (depth, z) in channel(&frame, "Z").zip(channel(&frame, "Position.Z")) {
                let moment = (6.0 - depth) / 4.0 * MOMENTS as f64 - 0.5;
                assert!(
                    (moment - moment.round()).abs() < 1e-4,
                    "{method:?}: {depth} m is between two moments"
                );
                assert!((depth + z).abs() < 1e-5, "both are of one sample: {depth} {z}");
                seen[moment.round() as usize] += 1.0;
                sum += depth;
            }
        }
        let pixels = f64::from(SEEDS) * (SIZE.width * SIZE.height) as f64;
        let (mean, truth) = (sum / pixels, over_time(depth_m));
        println!("{method:?}: {mean:.3} m on the average, {truth:.3} over all moments");
        // Four standard errors of what slices, whose samples share moments, have.
        assert!((mean - truth).abs() < 0.06, "{method:?}: {mean} {truth}");
        for (moment, seen) in seen.into_iter().enumerate() {
            let share = seen / pixels * MOMENTS as f64;
            assert!((share - 1.0).abs() < 0.25, "{method:?}: moment {moment} is seen {share} times as often");
        }
    }
}

#[test]
fn a_card_that_slides_past_is_seen_for_as_long_as_it_is_there() {
    let mut scene = stage();
    // Its right edge goes from the middle of the picture four pixels to the right.
    add_card(&mut scene, 20.0, DVec3::new(-20.0, 0.0, -4.0), DVec3::new(-19.75, 0.0, -4.0));
    add_card(&mut scene, 90.0, -WALL_M * DVec3::Z, -WALL_M * DVec3::Z);
    for method in [Method::Segments, Method::Slices] {
        let mut sums = [0.0; SIZE.width];
        for seed in 0..SEEDS {
            let frame = picture(&scene, method, seed);
            for (pixel, (depth, id)) in channel(&frame, "Z").zip(channel(&frame, "leaf_id.X")).enumerate() {
                let expected = if id == 1.0 { 4.0 } else { WALL_M };
                assert!((depth - expected).abs() < 1e-5, "{method:?}: {depth} m is no surface's");
                sums[pixel % SIZE.width] += depth;
            }
        }
        for (column, sum) in sums.into_iter().enumerate() {
            let mean = sum / f64::from(SEEDS) / SIZE.height as f64;
            let x_px = column as f64 + 0.5 - 0.5 * SIZE.width as f64;
            let truth = over_time(|time| if x_px < 4.0 * time { 4.0 } else { WALL_M });
            println!("{method:?}, column {column}: {mean:.3} m on the average, {truth:.3} over all moments");
            // Columns that the edge does not reach are exact; in the others 4 % of the time are 0.2 m.
            let tolerance = if (8..12).contains(&column) { 0.2 } else { 1e-5 };
            assert!((mean - truth).abs() < tolerance, "{method:?}, column {column}: {mean} {truth}");
        }
    }
}
