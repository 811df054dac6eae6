//! Rays that run nearly or exactly along the light. The sun or a lamp is in the picture, behind the camera,
//! or at any angle between a tenth of a radian and nothing.

use crate::common::INSTANT;
use crate::numerics::compare::{SlicePlan, by_slices, per_ray_of};
use crate::numerics::scenes::{Frame, Lamp, grove};
use glam::DVec3;
use std::f64::consts::TAU;
use sunfleck::light::LightPlace;
use sunfleck::math::Ray;
use sunfleck::scene::{Scene, Size};
use sunfleck::snapshot::{MeshTrees, Snapshot};

const SIZE: Size = Size { width: 64, height: 64 };

/// In the picture, and behind the camera.
const SIDES: [f64; 2] = [1.0, -1.0];

/// Directions in which to put the light: through gaps and through leaves.
fn towards(number: u32) -> DVec3 {
    let turn = TAU * f64::from(number) / 6.0;
    DVec3::new(0.05 + 0.3 * turn.cos(), 0.1 + 0.25 * turn.sin(), -1.0)
}

fn lamps(towards: DVec3, side: f64) -> [Lamp; 3] {
    let towards = side * towards;
    let near = |distance: f64| Lamp::Point { position: distance * towards };
    // A lamp in the fog, and one beyond it.
    [Lamp::Sun { to_sun: towards }, near(if side > 0.0 { 5.0 } else { 0.5 }), near(30.0)]
}

fn axis_of(snapshot: &Snapshot) -> DVec3 {
    match snapshot.lights[0].centre().place() {
        LightPlace::Towards(to_light) => to_light,
        LightPlace::At(position) => position.normalize(),
    }
}

/// A unit vector at a small angle from another.
fn tilted(axis: DVec3, angle: f64, turn: f64) -> DVec3 {
    let side = axis.any_orthonormal_vector();
    let side = turn.cos() * side + turn.sin() * axis.cross(side);
    (angle.cos() * axis + angle.sin() * side).normalize()
}

fn each_scene(mut check: impl FnMut(Lamp, f64, &Scene)) {
    for side in SIDES {
        for number in 0..6 {
            for lamp in lamps(towards(number), side) {
                check(lamp, side, &grove(&Frame::HERE, lamp));
            }
        }
    }
}

#[test]
fn rays_along_the_light() {
    let mut worst = 0.0_f64;
    for exponent in 1..=13 {
        // The last of them is no angle at all.
        let angle = if exponent == 13 { 0.0 } else { 10_f64.powi(-exponent) };
        each_scene(|lamp, side, scene| {
            let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
            let axis = side * axis_of(&snapshot);
            let turns = (0..12).map(|index| 0.1 + TAU * f64::from(index) / 12.0);
            let rays = turns.map(|turn| Ray { origin: DVec3::ZERO, direction: tilted(axis, angle, turn) });
            let errors = per_ray_of(scene, &snapshot, rays);
            worst = worst.max(errors.shafts());
            errors.hold(&format!("{angle:.0e} rad from {lamp:?}"), 1e-6);
        });
    }
    println!("rays along the light: {worst:.1e}");
}

/// The same rays from slices: places at tiny distances from the light's image.
#[test]
fn slices_around_the_light() {
    each_scene(|lamp, _, scene| {
        // The area passed grows as the square of the distance from the image, which is where a slice
        // starts or ends.
        let from_start = (0..=12).map(|exponent| 10_f64.powi(-2 * exponent));
        let from_end = (1..=8).map(|exponent| 1.0 - 10_f64.powi(-2 * exponent));
        let mut areas: Vec<f64> = from_start.chain(from_end).chain([0.0]).collect();
        areas.sort_by(f64::total_cmp);
        let angles = (0..12).map(|index| 0.05 + f64::from(index) / 12.0).collect();
        let plan = SlicePlan { size: SIZE, angles, areas };
        by_slices(scene, &plan).hold(&format!("slices around {lamp:?}"), 1e-6);
    });
}
