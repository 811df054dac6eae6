//! Fog from a breath to a wall, phase functions like needles, boxes that share faces, many boxes, and
//! cameras and lights in their faces, edges and corners.

use crate::compare::{SlicePlan, by_slices, per_ray};
use crate::scenes::{Frame, HIGH_SUN, LAMP, Lamp, empty, fog, grove, light, spread};
use glam::DVec3;
use sunfleck::color::Rgb;
use sunfleck::scene::{Scene, Size, Track};

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
