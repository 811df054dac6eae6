//! Lights where they should not be: in the plane of a leaf, on a leaf, in a vertex, at the camera. And images
//! of lights (epipoles) on corners, centres and edges of pixels.

use crate::numerics::compare::{SlicePlan, by_slices, per_ray};
use crate::numerics::scenes::{Frame, Lamp, add_triangles, empty, fog, grove, light, spread};
use glam::{DVec3, Vec3};
use sunfleck::scene::{Scene, Size};

const SIZE: Size = Size { width: 64, height: 64 };

fn hold(name: &str, scene: &Scene, bound: f64) {
    per_ray(scene, 1.0, spread(200)).hold(&format!("{name}, per ray"), bound);
    by_slices(scene, &SlicePlan::even(SIZE, 17, 15)).hold(&format!("{name}, slices"), bound);
}

/// Two level sheets, an upright one and a slanted one, on round numbers.
fn sheets(lamp: Lamp) -> Scene {
    let mut scene = empty(&Frame::HERE);
    let sheet = |a: [f32; 3], b: [f32; 3], c: [f32; 3]| [a, b, c].map(Vec3::from_array);
    let sheets = [
        sheet([-2.0, 1.0, -4.0], [1.0, 1.0, -4.0], [-0.5, 1.0, -7.0]),
        sheet([-3.0, -1.0, -3.0], [3.0, -1.0, -3.0], [0.0, -1.0, -8.0]),
        sheet([1.5, -0.5, -4.0], [1.5, 1.5, -4.0], [1.5, 0.5, -6.0]),
        sheet([-2.0, -0.5, -5.0], [-1.0, 0.5, -6.0], [-1.5, 1.0, -4.0]),
    ];
    add_triangles(&mut scene, &Frame::HERE, &sheets);
    fog(&mut scene, &Frame::HERE, DVec3::new(-4.0, -2.0, -9.0), DVec3::new(4.0, 3.0, 1.0), 0.2, 0.5);
    light(&mut scene, &Frame::HERE, lamp);
    scene
}

#[test]
fn in_the_plane_of_a_leaf() {
    for to_sun in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z, DVec3::new(3.0, 0.0, -4.0), DVec3::Y] {
        let lamp = Lamp::Sun { to_sun };
        hold(&format!("in the plane of a leaf, {lamp:?}"), &sheets(lamp), 1e-6);
        let grazing = Lamp::Sun { to_sun: to_sun.normalize() + 1e-7 * DVec3::new(0.3, 1.0, 0.2) };
        hold(&format!("nearly in the plane of a leaf, {grazing:?}"), &sheets(grazing), 1e-6);
    }
    for position in [DVec3::new(2.0, 1.0, -5.0), DVec3::new(0.5, -1.0, 0.5), DVec3::new(1.5, 2.0, -5.0)] {
        let lamp = Lamp::Point { position };
        hold(&format!("in the plane of a leaf, {lamp:?}"), &sheets(lamp), 1e-6);
    }
}

/// In the middle of a sheet, on its edge, and in its vertices.
#[test]
fn on_a_leaf() {
    for position in [
        DVec3::new(-0.5, 1.0, -5.0),
        DVec3::new(-0.25, 1.0, -4.0),
        DVec3::new(1.5, 0.5, -5.0),
        DVec3::new(-2.0, 1.0, -4.0),
        DVec3::new(-1.5, 1.0, -4.0),
        DVec3::new(0.0, -1.0, -8.0),
    ] {
        let lamp = Lamp::Point { position };
        let scene = sheets(lamp);
        per_ray(&scene, 1.0, spread(200)).hold_sane(&format!("on a leaf, {lamp:?}, per ray"));
        by_slices(&scene, &SlicePlan::even(SIZE, 17, 15)).hold_sane(&format!("on a leaf, {lamp:?}, slices"));
    }
}

/// As near to the camera as makes no difference. At the camera itself the fog's light has no bound.
#[test]
fn at_the_camera() {
    for distance in [1e-12, 1e-6, 1e-3, 0.1] {
        for direction in [DVec3::NEG_Z, DVec3::Z, DVec3::Y, DVec3::new(0.3, -0.5, 0.2)] {
            let lamp = Lamp::Point { position: distance * direction };
            let scene = grove(&Frame::HERE, lamp);
            per_ray(&scene, 1.0, spread(40)).hold(&format!("at the camera, {lamp:?}, per ray"), 1e-6);
            let plan = SlicePlan::even(SIZE, 7, 7);
            by_slices(&scene, &plan).hold(&format!("at the camera, {lamp:?}, slices"), 1e-6);
        }
    }
}

/// The camera sees 64 pixels over a right angle: x = pixel / 32 - 1 at distance 1.
#[test]
fn images_of_lights_on_round_places() {
    let at = |x: f64, y: f64| DVec3::new(x / 32.0 - 1.0, 1.0 - y / 32.0, -1.0);
    let places = [
        ("corner of a pixel", at(32.0, 32.0)),
        ("centre of a pixel", at(20.5, 40.5)),
        ("edge of the picture", at(0.0, 17.0)),
        ("corner of the picture", at(64.0, 64.0)),
        ("just outside", at(64.0 + 1e-9, 30.0)),
        ("just inside", at(1e-13, 30.0)),
        ("one row", at(-40.0, 30.0)),
        ("beside the camera", DVec3::X),
        ("above the camera", DVec3::Y),
    ];
    for (name, towards) in places {
        for side in [1.0, -1.0] {
            for lamp in [Lamp::Sun { to_sun: side * towards }, Lamp::Point { position: 4.0 * side * towards }]
            {
                let mut scene = grove(&Frame::HERE, lamp);
                // Without the ground, which leaves nothing of a light below it.
                scene.instances.pop();
                per_ray(&scene, 1.0, spread(40)).hold(&format!("{name}, {lamp:?}, per ray"), 1e-6);
                by_slices(&scene, &SlicePlan::even(SIZE, 11, 11))
                    .hold(&format!("{name}, {lamp:?}, slices"), 1e-6);
            }
        }
    }
}

/// A leaf hides the lamp from all fog before it, but is seen nearly edge on, so that its places
/// are known less well in single precision than where a ray meets its plane. Rays that end on it
/// are dark to their ends.
#[test]
fn behind_a_leaf_seen_edge_on() {
    let dark = |scale: f64,
                triangles: &[[[f32; 3]; 3]],
                bank: [[f64; 3]; 2],
                fog_and_g: [f64; 2],
                lamp: [f64; 3]| {
        let frame = Frame { scale, offset: DVec3::ZERO };
        let mut scene = empty(&frame);
        let triangles: Vec<[Vec3; 3]> =
            triangles.iter().map(|corners| corners.map(Vec3::from_array)).collect();
        add_triangles(&mut scene, &frame, &triangles);
        let [low, high] = bank.map(DVec3::from_array);
        fog(&mut scene, &frame, low, high, fog_and_g[0], fog_and_g[1]);
        light(&mut scene, &frame, Lamp::Point { position: DVec3::from_array(lamp) });
        let errors = by_slices(&scene, &SlicePlan::even(Size { width: 8, height: 8 }, 5, 5));
        println!("behind a leaf seen edge on, slices: {errors}");
        assert_eq!(errors.verdict_above(1e-4, 1e-6), Ok(()), "{lamp:?}");
    };
    dark(
        1418.0,
        &[[[0.5, -1.0, -1.5], [1.0, -0.5, -0.5], [0.0, 1.0, -0.5]]],
        [[-1.0, -1.0, -1.0], [1.0, 0.0, -0.5]],
        [1.0, 0.5],
        [1.25, -0.25, -1.3],
    );
    dark(
        1.0,
        &[[[1.0, 1.0, -0.5], [-0.5, -1.0, -1.5], [-1.0, -0.5, -0.5]]],
        [[0.0, -1.0, -1.0], [1.0, 1.0, -0.5]],
        [1.0, 0.9],
        [0.75, 0.75, -0.8],
    );
    dark(
        1.2e-4,
        &[
            [[-1.0, 0.0, -3.0], [-1.0, 1.0, -1.0], [0.0, 0.0, -0.5]],
            [[-1.0, 0.5, -1.0], [0.5, -1.0, -3.0], [0.0, 0.5, -1.0]],
        ],
        [[-1.0, -1.0, -1.5], [-0.5, 0.5, -0.5]],
        [20.0, -0.9],
        [-0.25, 0.25, -0.8],
    );
}
