//! A hundred thousand slats: as many lit intervals on one ray, whose light is a geometric series.

use crate::common::{EXACT, look};
use crate::scenes::{Frame, Lamp, add_instance, add_mesh, empty, fog, light};
use glam::{DAffine3, DVec3, Vec3};
use std::f64::consts::PI;
use sunfleck::scene::Scene;

const SLATS: u32 = 100_000;
/// A power of two, so that every slat lies where it should.
const PITCH_M: f64 = 1.0 / 1024.0;

/// Level slats a metre above the ray along -Z; every second half pitch is open.
fn fence(lamp: Lamp) -> Scene {
    let mut scene = empty(&Frame::HERE);
    let half = 0.5 * PITCH_M as f32;
    let corners = [[-1.0, 0.0], [1.0, 0.0], [1.0, -half], [-1.0, -half]].map(|[x, z]| Vec3::new(x, 1.0, z));
    let slat = add_mesh(&mut scene, corners.into(), &[[0, 1, 2], [0, 2, 3]]);
    for number in 0..SLATS {
        let at = DVec3::new(0.0, 0.0, -PITCH_M * f64::from(number));
        add_instance(&mut scene, slat, &Frame::HERE, DAffine3::from_translation(at));
    }
    let length = PITCH_M * f64::from(SLATS);
    fog(&mut scene, &Frame::HERE, DVec3::new(-2.0, -1.0, -length), DVec3::new(2.0, 2.0, 1.0), 0.02, 0.3);
    light(&mut scene, &Frame::HERE, lamp);
    scene
}

#[test]
fn under_a_sun() {
    let scene = fence(Lamp::Sun { to_sun: DVec3::Y });
    let (sigma_t, g, irradiance) = (0.02_f64, 0.3_f64, 5.0);
    // Every gap passes its half pitch, weakened by the way to it; two metres of fog above all of them.
    let open = ((-0.5 * sigma_t * PITCH_M).exp() - (-sigma_t * PITCH_M).exp()) / sigma_t;
    let series = -(-sigma_t * PITCH_M * f64::from(SLATS)).exp_m1() / -(-sigma_t * PITCH_M).exp_m1();
    let phase = (1.0 - g * g) / (4.0 * PI * (1.0 + g * g).powf(1.5));
    let expected = 0.8 * sigma_t * phase * irradiance * (-2.0 * sigma_t).exp() * open * series;
    let found = look(&scene, &EXACT, 0.5, 0.5).shafts.x;
    println!("{SLATS} slats under a sun: {:.1e}", (found / expected - 1.0).abs());
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
}
