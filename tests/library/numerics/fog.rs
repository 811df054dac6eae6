//! Fog from a breath to a wall, and phase functions like needles. Boxes that share faces, and many boxes.
//! Cameras and lights in their faces, edges and corners.

use crate::common::{EXACT, INSTANT};
use crate::numerics::compare::{SlicePlan, by_slices, per_ray};
use crate::numerics::scenes::{Frame, HIGH_SUN, LAMP, Lamp, empty, fog, grove, light, spread};
use crate::numerics::truth::Truth;
use glam::DVec3;
use sunfleck::color::Rgb;
use sunfleck::math::{Ray, Sampler};
use sunfleck::scene::{Scene, Size, Track};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};

const SIZE: Size = Size { width: 64, height: 64 };

fn hold(name: &str, scene: &Scene, bound: f64) {
    per_ray(scene, 1.0, spread(150)).hold(&format!("{name}, per ray"), bound);
    by_slices(scene, &SlicePlan::even(SIZE, 13, 13)).hold(&format!("{name}, slices"), bound);
}

/// Across the box, whose diagonal is some 16 m.
#[test]
fn optical_depth() {
    for lamp in [HIGH_SUN, LAMP] {
        for tau in [1e-9, 1e-4, 1.0, 30.0, 1e3, 1e4] {
            let mut scene = grove(&Frame::HERE, lamp);
            scene.fogs[0].density_per_m = Track::from(Rgb::splat(tau / 16.0));
            hold(&format!("optical depth {tau:e}, {lamp:?}"), &scene, 1e-6);
        }
    }
}

#[test]
fn anisotropy() {
    let into_the_sun = Lamp::Sun { to_sun: DVec3::new(0.1, 0.2, -1.0) };
    for lamp in [HIGH_SUN, LAMP, into_the_sun] {
        for g in [0.999, -0.999, 0.9999, 1e-12] {
            let mut scene = grove(&Frame::HERE, lamp);
            scene.fogs[0].anisotropy = Track::from(g);
            hold(&format!("g = {g}, {lamp:?}"), &scene, 1e-6);
        }
    }
}

/// A third opinion about needles in the phase function: mpmath's `quad` at 30 digits, over the distance, cut
/// at the place nearest to the lamp and at 2^-6 to 2^39 times the gap on both sides of it. Rays beside the
/// lamp, past it by 40 micrometres, and away from it; red light.
const BY_THIRTY_DIGITS: [([f64; 3], [f64; 4]); 3] = [
    (
        [0.05, 0.1, -1.0],
        [
            0.001_474_355_393_620_77,
            0.000_869_486_589_200_047,
            0.014_831_898_785_660_9,
            0.008_740_706_107_265_67,
        ],
    ),
    (
        [0.0931, 0.2559, -1.0],
        [90_876.859_285_123_1, 69_372.148_435_509_8, 10_070.498_897_043_7, 9_536.630_019_409_17],
    ),
    (
        [0.4, -0.3, -1.0],
        [2.696_609_436_170_39e-5, 9.340_062_218_797_34e-6, 2.720_502_258_201_49e-4, 9.424_154_366_401_51e-5],
    ),
];

/// Of the four values.
const ANISOTROPIES: [f64; 4] = [0.999, -0.999, 0.99, -0.99];

#[test]
fn anisotropy_to_thirty_digits() {
    let mut worst = (0.0_f64, 0.0_f64);
    for (direction, values) in BY_THIRTY_DIGITS {
        for (g, expected) in ANISOTROPIES.into_iter().zip(values) {
            let mut scene = empty(&Frame::HERE);
            let (low, high) = (DVec3::new(-6.0, -1.5, -10.0), DVec3::new(6.0, 4.0, 1.0));
            fog(&mut scene, &Frame::HERE, low, high, 0.15, g);
            light(&mut scene, &Frame::HERE, LAMP);
            let snapshot = Snapshot::new(&scene, &MeshTrees::new(&scene), 0, 1.0, INSTANT);
            let ray = Ray { origin: DVec3::ZERO, direction: DVec3::from(direction).normalize() };
            let mut sampler = Sampler::new(0, 0, 0, 0);
            let found = radiance(&snapshot, &EXACT, &ray, &mut sampler, &mut Scratch::default()).shafts.x;
            let truth = Truth::new(&scene, &snapshot).light(&ray, None, f64::INFINITY);
            let truth = truth.shafts.expect("no shadows to decide about").x;
            let error = |value: f64| (value / expected - 1.0).abs();
            worst = (worst.0.max(error(found)), worst.1.max(error(truth)));
            assert!(error(found) < 1e-6, "g = {g}, {direction:?}: {found} not {expected}");
            assert!(error(truth) < 1e-8, "g = {g}, {direction:?}: the truth {truth} not {expected}");
        }
    }
    println!("needles to thirty digits: {:.1e}, the truth {:.1e}", worst.0, worst.1);
}

fn boxes(lamp: Lamp, boxes: &[(DVec3, DVec3)]) -> Scene {
    let mut scene = empty(&Frame::HERE);
    for (index, (low, high)) in boxes.iter().enumerate() {
        fog(&mut scene, &Frame::HERE, *low, *high, 0.1 + 0.05 * (index % 3) as f64, 0.4);
    }
    light(&mut scene, &Frame::HERE, lamp);
    scene
}

/// The camera, at the origin, in a face, an edge and a corner of a box; outside, and deep inside.
#[test]
fn camera_at_the_border() {
    let (low, high) = (DVec3::new(-3.0, -2.0, -6.0), DVec3::new(3.0, 2.0, 0.0));
    let to_the_right = DVec3::new(3.0, 0.0, 0.0);
    let up = DVec3::new(0.0, 2.0, 0.0);
    let away = DVec3::new(0.0, 0.0, -2.0);
    for (name, offset) in [
        ("a face", DVec3::ZERO),
        ("an edge", to_the_right),
        ("a corner", to_the_right + up),
        ("outside", away),
    ] {
        for lamp in [HIGH_SUN, LAMP, Lamp::Sun { to_sun: DVec3::Y }, Lamp::Sun { to_sun: DVec3::NEG_Z }] {
            hold(
                &format!("camera at {name}, {lamp:?}"),
                &boxes(lamp, &[(low + offset, high + offset)]),
                1e-6,
            );
        }
    }
}

/// Dense boxes with faces along the light to its last bit but one: nothing shines through a
/// face's last 1e-16 m.
#[test]
fn faces_along_the_light() {
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let cases = [
        (DVec3::new(-1.0, -0.5, 0.0), 1.0, corner(-1.0, -1.0, -1.0), corner(0.0, 0.0, -0.5), 613.4),
        (DVec3::new(-1.0, -0.5, 0.0), 1.0, corner(-1.0, -1.0, -1.0), corner(0.5, 0.0, -0.5), 1327.7),
        (DVec3::Y, 202.554_173_078_352_28, corner(-1.0, -1.0, -1.5), corner(-0.5, -0.5, -1.0), 1182.1),
    ];
    for (to_sun, scale, low, high, density) in cases {
        let frame = Frame { scale, offset: DVec3::ZERO };
        let mut scene = empty(&frame);
        fog(&mut scene, &frame, low, high, density, -0.999);
        light(&mut scene, &frame, Lamp::Sun { to_sun });
        let plan = SlicePlan::even(Size { width: 8, height: 8 }, 5, 5);
        assert_eq!(by_slices(&scene, &plan).verdict_above(1e-4, 1e-6), Ok(()), "{to_sun}, {low} to {high}");
    }
}

#[test]
fn lamp_at_the_border() {
    let (low, high) = (DVec3::new(-3.0, -2.0, -6.0), DVec3::new(3.0, 2.0, 1.0));
    for at in
        [DVec3::new(0.5, 2.0, -3.0), DVec3::new(3.0, 2.0, -3.0), high, DVec3::new(0.5, 2.0 + 1e-9, -3.0)]
    {
        let lamp = Lamp::Point { position: at };
        hold(&format!("lamp at the border, {at}"), &boxes(lamp, &[(low, high)]), 1e-6);
    }
}

#[test]
fn boxes_that_share_faces() {
    let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let halves = [
        (corner(-3.0, -2.0, -6.0), corner(0.0, 2.0, 1.0)),
        (corner(0.0, -2.0, -6.0), corner(3.0, 2.0, 1.0)),
        // And one that overlaps both, up to the same faces.
        (corner(-1.0, -2.0, -6.0), corner(3.0, 1.0, 0.0)),
    ];
    for lamp in [HIGH_SUN, LAMP, Lamp::Sun { to_sun: DVec3::Y }] {
        hold(&format!("shared faces, {lamp:?}"), &boxes(lamp, &halves), 1e-6);
    }
}

#[test]
fn sixty_four_boxes() {
    let grid: Vec<(DVec3, DVec3)> = (0..64)
        .map(|index| {
            let cell = DVec3::new(f64::from(index % 4), f64::from(index / 4 % 4), f64::from(index / 16));
            let low = DVec3::new(-3.0, -2.0, -6.0) + cell * 1.5;
            (low, low + 1.5)
        })
        .collect();
    for lamp in [HIGH_SUN, LAMP] {
        let scene = boxes(lamp, &grid);
        per_ray(&scene, 1.0, spread(30)).hold(&format!("64 boxes, {lamp:?}, per ray"), 1e-6);
        by_slices(&scene, &SlicePlan::even(SIZE, 5, 6)).hold(&format!("64 boxes, {lamp:?}, slices"), 1e-6);
    }
}
