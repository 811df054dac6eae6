//! The pass of motion: against closed forms, and against vertices and projection matrices frame by frame.

use crate::checkout;
use crate::common::{EXACT, camera_at, place};
use glam::{DAffine3, DVec2, DVec3};
use sunfleck::math::Ray;
use sunfleck::passes::Pass;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{
    Extend, Instance, Key, Lens, Mesh, Motion, PixelFilter, Rotation, Sampling, Scene, Segment, Size, Track,
    Triangle, Window,
};
use sunfleck::snapshot::{Exposure, MeshTrees, MotionField, Shutter, Snapshot};
use sunfleck::{description, scene};

/// A frame a second, and frame 10 is the one that is looked at.
const TIMES_S: [f64; 3] = [9.0, 10.0, 11.0];
const SIZE: Size = Size { width: 64, height: 36 };

fn linear(from: DVec3, to: DVec3) -> Track<DVec3> {
    let key = |time_s: f64, value: DVec3| Key { time_s, value, to_next: Segment::Linear };
    Track::new(vec![key(0.0, from), key(20.0, to)], Extend::Hold).expect("good keys")
}

fn moving(translation: Track<DVec3>, angles: Track<DVec3>) -> Motion {
    Motion::Keyed { translation, rotation: Rotation::EulerXyz(angles), scale: DVec3::ONE.into() }
}

/// A wall across half of the picture.
fn add_wall(scene: &mut Scene, motion: Motion) {
    let node = place(scene, DAffine3::IDENTITY);
    scene.nodes[node].motion = motion;
    scene.materials.push(sunfleck::scene::Material::default());
    scene.meshes.push(Mesh {
        positions: [
            DVec2::new(-1.0, -9.0),
            DVec2::new(1.0, -9.0),
            DVec2::new(1.0, 9.0),
            DVec2::new(-1.0, 9.0),
        ]
        .map(|corner| corner.extend(0.0).as_vec3())
        .to_vec(),
        triangles: [[0, 1, 2], [0, 2, 3]].map(|vertices| Triangle { vertices, material: 0 }).to_vec(),
        ..Mesh::default()
    });
    let mesh = scene.meshes.len() - 1;
    scene.instances.push(Instance { node, mesh, material: None, leaf_id: 1, deformation: None });
}

/// Vectors and depths of all pixels.
fn pictures(scene: &Scene, open_s: f64) -> Vec<([f64; 4], f64)> {
    let shutter = Shutter { open_s: TIMES_S[1] - 0.5 * open_s, close_s: TIMES_S[1] + 0.5 * open_s };
    let trees = MeshTrees::new(scene);
    let aspect = SIZE.width as f64 / SIZE.height as f64;
    let exposure = Exposure::new(scene, &trees, 0, aspect, shutter);
    let exposure = exposure.with_motion(MotionField::new(scene, 0, SIZE, TIMES_S));
    let job = Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: vec![Pass::Motion, Pass::Depth],
        sampling: Sampling::Exactly(if open_s > 0.0 { 16 } else { 1 }),
        filter: PixelFilter::Box,
        seed: 0,
        mirror_depth: EXACT.mirror_depth,
        bounces: sunfleck::scene::Bounces::NONE,
        method: Method::Segments,
    };
    let frame = render(&exposure, &job, &Watch::NOBODY).frame;
    let channel = |name: &str| &frame.channel(name).expect("a channel").pixels;
    let vectors = ["Vector.X", "Vector.Y", "Vector.Z", "Vector.W"].map(channel);
    let pixels = (0..SIZE.width * SIZE.height)
        .map(|pixel| (vectors.map(|channel| f64::from(channel[pixel])), f64::from(channel("Z")[pixel])));
    pixels.collect()
}

fn assert_vector(found: [f64; 4], expected: [f64; 4], tolerance: f64) {
    let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= tolerance, "{found:?} {expected:?}");
}

/// A wall parallel to the picture, 4 m away: moves by the same everywhere, whenever it was seen.
#[test]
fn a_wall_that_slides() {
    let mut scene = camera_at(DVec3::ZERO);
    let (from, step) = (DVec3::new(-2.0, 1.0, -4.0), DVec3::new(0.2, -0.1, 0.0));
    add_wall(&mut scene, moving(linear(from, from + 20.0 * step), DVec3::ZERO.into()));
    // A right angle up and down: 36 pixels are 8 m at that distance.
    let pixels = 36.0 / 8.0 * step;
    for open_s in [0.0, 0.5] {
        let mut seen = 0;
        for (vector, depth) in pictures(&scene, open_s) {
            if depth < 1e9 {
                seen += 1;
                assert_vector(vector, [-pixels.x, -pixels.y, -pixels.x, -pixels.y], 1e-4);
            } else {
                assert_vector(vector, [0.0; 4], 1e-9);
            }
        }
        assert!(seen > 200, "{seen}");
    }
}

/// A camera that pans by the angle a, anticlockwise from above: what lies in the middle was at the left, by
/// the tangent of a. The background moves as surfaces do.
#[test]
fn a_camera_that_pans() {
    let mut scene = camera_at(DVec3::ZERO);
    let angle = 0.02_f64;
    let turn = |frame: f64| DVec3::new(0.0, (frame - 10.0) * angle, 0.0);
    let node = scene.cameras[0].node;
    scene.nodes[node].motion = moving(DVec3::ZERO.into(), linear(turn(0.0), turn(20.0)));
    add_wall(&mut scene, Motion::Still(DAffine3::from_translation(DVec3::new(1.0, 0.0, -3.0))));
    let shift = 18.0 * angle.tan();
    let (mut walls, mut skies) = (0, 0);
    for (pixel, (vector, depth)) in pictures(&scene, 0.0).into_iter().enumerate() {
        // By the two pixels on either side of the middle, whose tangents are +- 1 / 36.
        let (column, row) = (pixel % SIZE.width, pixel / SIZE.width);
        let place = DVec2::new(column as f64 + 0.5 - 32.0, 18.0 - row as f64 - 0.5) / 18.0;
        let seen_from = |turned: f64| {
            let (sin, cos) = turned.sin_cos();
            let ahead = cos + place.x * sin;
            18.0 * DVec2::new((place.x * cos - sin) / ahead, place.y / ahead)
        };
        // Turned by an angle, the camera sees all of it turned the other way.
        let (before, now, after) = (seen_from(angle), 18.0 * place, seen_from(-angle));
        let (back, forth) = (before - now, now - after);
        assert_vector(vector, [back.x, back.y, forth.x, forth.y], 1e-3);
        (walls, skies) = if depth < 1e9 { (walls + 1, skies) } else { (walls, skies + 1) };
        if place.abs().max_element() < 0.03 {
            assert!((vector[0].abs() - shift).abs() < 2e-3, "{vector:?} {shift}");
        }
    }
    assert!(walls > 100 && skies > 100);
}

/// Whatever turns, bends or travels: the place of the hit in its triangle, put into that triangle a frame
/// before and after, and through OpenGL's matrices.
fn assert_equal_to_vertices(scene: &Scene, times_s: [f64; 3], least: usize) {
    let trees = MeshTrees::new(scene);
    let shutter = Shutter { open_s: times_s[1], close_s: times_s[1] };
    let aspect = SIZE.width as f64 / SIZE.height as f64;
    let mut snapshot = Snapshot::new(scene, &trees, 0, aspect, shutter);
    snapshot.motion = Some(MotionField::new(scene, 0, SIZE, times_s).into());
    let (mut hits, mut moved) = (0, 0.0_f64);
    for number in 0..1000 {
        let film = DVec2::new((f64::from(number) * 0.618_034).fract(), (f64::from(number) + 0.5) / 1000.0);
        let Ray { origin, direction } = snapshot.view.ray(film.x, film.y);
        let ray = Ray { origin, direction };
        let Some(hit) = snapshot.tree.nearest_hit(&ray, f64::INFINITY, None) else { continue };
        let point = snapshot.surface(&ray, &hit);
        let found = snapshot.motion_px(Some(&point), direction);
        let is_met = |instance: &&Instance| instance.leaf_id == point.leaf_id;
        let instance = scene.instances.iter().find(is_met).expect("what was met");
        let corners = scene.meshes[instance.mesh].triangles[hit.primitive.triangle as usize].vertices;
        let [v, w] = hit.barycentrics;
        let places = times_s.map(|time_s| {
            let placements = scene.placements(time_s);
            let (vertices, world_from_shape) = scene.vertices(instance, &placements, time_s);
            let [a, b, c] =
                corners.map(|corner| world_from_shape.transform_point3(vertices[corner as usize].as_dvec3()));
            let camera = &scene.cameras[0];
            let camera_from_world = placements[camera.node].world_from_node.inverse();
            let clip = camera.projection(aspect, time_s)
                * camera_from_world.transform_point3((1.0 - v - w) * a + v * b + w * c).extend(1.0);
            0.5 * DVec2::new(SIZE.width as f64, SIZE.height as f64) * DVec2::new(clip.x, clip.y) / clip.w
        });
        let (back, forth) = (places[0] - places[1], places[1] - places[2]);
        assert_vector(found, [back.x, back.y, forth.x, forth.y], 1e-3);
        hits += 1;
        moved = moved.max(back.length());
    }
    assert!(hits >= least && moved > 0.02, "{hits} hits, by up to {moved} pixels");
}

#[test]
fn a_wall_that_turns_before_a_camera_that_travels() {
    let mut scene = camera_at(DVec3::ZERO);
    let node = scene.cameras[0].node;
    scene.nodes[node].motion = Motion::Aimed {
        position: linear(DVec3::new(-1.0, 0.0, 1.0), DVec3::new(1.0, 0.5, 0.0)),
        target: linear(DVec3::new(0.0, 0.0, -5.0), DVec3::new(0.5, 0.0, -4.0)),
        up: DVec3::Y.into(),
    };
    let travel = linear(DVec3::new(0.5, 0.0, -4.0), DVec3::new(-0.5, 1.0, -3.0));
    add_wall(&mut scene, moving(travel, linear(DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0))));
    assert_equal_to_vertices(&scene, TIMES_S, 100);
}

/// Skins and morph targets, as Blender exports them.
#[test]
fn meshes_that_bend() {
    for name in ["c_morph.glb", "d_skin.glb"] {
        let path = checkout::file("tests/data/blender").join(name);
        let (mut scene, settings) =
            scene::resolve(description::load(&path).expect("a good file"), None).expect("a good scene");
        let middle = 0.5 * (*settings.frames.start() + *settings.frames.end()) as f64;
        // They bend slowly: so many frames apart, it shows.
        let times_s = [-3.0, 0.0, 3.0].map(|offset| settings.frame_rate.seconds(middle + offset));
        // Close to the first that bends.
        let placements = scene.placements(times_s[1]);
        let bent =
            scene.instances.iter().find(|instance| instance.deformation.is_some()).expect("one that bends");
        let (vertices, world_from_shape) = scene.vertices(bent, &placements, times_s[1]);
        let points = || vertices.iter().map(|p| world_from_shape.transform_point3(p.as_dvec3()));
        let (low, high) =
            points().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        let (centre, size) = (0.5 * (low + high), (high - low).length());
        let motion = Motion::Aimed {
            position: (centre + 4.0 * size * DVec3::new(0.6, 0.8, 1.0)).into(),
            target: centre.into(),
            up: DVec3::Y.into(),
        };
        scene.cameras[0].lens = Lens::Perspective { fov_y: 0.25.into() };
        let node = scene.cameras[0].node;
        (scene.nodes[node].motion, scene.nodes[node].parent) = (motion, None);
        assert_equal_to_vertices(&scene, times_s, 10);
    }
}
