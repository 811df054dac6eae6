//! Light scattered by fog without anything in the way. It is held against closed forms, and against dense
//! quadrature written straight from the reference model.

use crate::common::{EXACT, add_fog, add_light, camera_at, look};
use glam::DVec3;
use std::f64::consts::PI;
use sunfleck::color::Rgb;
use sunfleck::scene::{LightKind, Scene, Track};

/// Fog of the dense quadrature: an axis-parallel box in coordinates relative to the eye.
struct Fog {
    low: DVec3,
    high: DVec3,
    sigma_t: f64,
    sigma_s: f64,
    g: f64,
}

impl Fog {
    /// Length inside of the way from `a` to `b`.
    fn length(&self, a: DVec3, b: DVec3) -> f64 {
        let (from, to) = self.inside(a, b);
        (to - from).max(0.0) * a.distance(b)
    }

    /// The part of the way from `a` (0) to `b` (1) that lies inside.
    fn inside(&self, a: DVec3, b: DVec3) -> (f64, f64) {
        let way = b - a;
        let (mut from, mut to): (f64, f64) = (0.0, 1.0);
        for axis in 0..3 {
            if way[axis].abs() < 1e-300 {
                if a[axis] < self.low[axis] || a[axis] > self.high[axis] {
                    return (0.0, 0.0);
                }
                continue;
            }
            let x = (self.low[axis] - a[axis]) / way[axis];
            let y = (self.high[axis] - a[axis]) / way[axis];
            from = from.max(x.min(y));
            to = to.min(x.max(y));
        }
        (from, to)
    }

    fn phase(&self, cos: f64) -> f64 {
        (1.0 - self.g * self.g) / (4.0 * PI * (1.0 + self.g * self.g - 2.0 * self.g * cos).powf(1.5))
    }
}

/// Midpoint rule with a million points over the foggy part of the ray.
fn dense(fog: &Fog, direction: DVec3, light: impl Fn(DVec3) -> (DVec3, f64, f64)) -> f64 {
    let count = 1_000_000;
    let (enter, leave) = fog.inside(DVec3::ZERO, direction * 100.0);
    let step = 100.0 * (leave - enter) / f64::from(count);
    let mut sum = 0.0;
    for index in 0..count {
        let p = direction * (100.0 * enter + (f64::from(index) + 0.5) * step);
        let (to_light, distance, irradiance) = light(p);
        let tau = fog.sigma_t * (fog.length(DVec3::ZERO, p) + fog.length(p, p + to_light * distance));
        sum += step * fog.sigma_s * fog.phase(to_light.dot(direction)) * irradiance * (-tau).exp();
    }
    sum
}

fn foggy(fog: &Fog, eye: DVec3) -> Scene {
    let mut scene = camera_at(eye);
    let albedo = Rgb::splat(fog.sigma_s / fog.sigma_t);
    add_fog(&mut scene, fog.low + eye, fog.high + eye, Rgb::splat(fog.sigma_t), albedo, fog.g);
    scene
}

const FILM: [(f64, f64); 5] = [(0.5, 0.5), (0.1, 0.2), (0.93, 0.4), (0.31, 0.87), (0.7, 0.02)];

fn film_direction(x: f64, y: f64) -> DVec3 {
    DVec3::new(2.0 * x - 1.0, 1.0 - 2.0 * y, -1.0).normalize()
}

#[test]
fn sun_equals_dense_quadrature() {
    let fog = Fog {
        low: DVec3::new(-5.0, -1.0, -9.0),
        high: DVec3::new(4.0, 6.0, 3.0),
        sigma_t: 0.3,
        sigma_s: 0.2,
        g: 0.6,
    };
    let to_sun = DVec3::new(0.35, 0.75, -0.56).normalize();
    let mut scene = foggy(&fog, DVec3::new(1000.0, 20.0, -300.0));
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, -to_sun, Rgb::splat(20.0));
    for (x, y) in FILM {
        let expected = dense(&fog, film_direction(x, y), |_| (to_sun, 1e3, 20.0));
        let found = look(&scene, &EXACT, x, y).shafts.x;
        assert!((found / expected - 1.0).abs() < 1e-9, "({x}, {y}): {found} {expected}");
    }
}

#[test]
fn point_light_inside_and_outside_the_fog_equals_dense_quadrature() {
    let fog = Fog {
        low: DVec3::new(-5.0, -1.0, -9.0),
        high: DVec3::new(4.0, 6.0, -1.0),
        sigma_t: 0.5,
        sigma_s: 0.4,
        g: 0.8,
    };
    for position in [DVec3::new(0.3, 0.7, -4.0), DVec3::new(2.0, 9.0, -3.0), DVec3::new(-1.0, 0.2, 0.5)] {
        let mut scene = foggy(&fog, DVec3::new(3.0, 2.0, 1.0));
        let world = position + DVec3::new(3.0, 2.0, 1.0);
        add_light(&mut scene, LightKind::Point, world, DVec3::X, Rgb::splat(7.0));
        for (x, y) in FILM {
            let expected = dense(&fog, film_direction(x, y), |p| {
                let way = position - p;
                (way.normalize(), way.length(), 7.0 / way.length_squared())
            });
            let found = look(&scene, &EXACT, x, y).shafts.x;
            assert!((found / expected - 1.0).abs() < 1e-6, "{position} ({x}, {y}): {found} {expected}");
        }
    }
}

#[test]
fn spot_equals_dense_quadrature() {
    let fog = Fog {
        low: DVec3::new(-9.0, -9.0, -12.0),
        high: DVec3::new(9.0, 9.0, 1.0),
        sigma_t: 0.2,
        sigma_s: 0.15,
        g: 0.3,
    };
    let position = DVec3::new(-2.0, 3.0, -5.0);
    let axis = DVec3::new(0.5, -1.0, 0.1).normalize();
    let (outer, blend) = (0.5_f64, 0.4);
    let mut scene = foggy(&fog, DVec3::ZERO);
    let kind = LightKind::Spot {
        outer_angle: Track::from(outer),
        blend: Track::from(blend),
        radius: Track::from(0.0),
    };
    add_light(&mut scene, kind, position, axis, Rgb::splat(30.0));
    for (x, y) in [(0.5, 0.5), (0.45, 0.35), (0.52, 0.7), (0.1, 0.9)] {
        let expected = dense(&fog, film_direction(x, y), |p| {
            let way = position - p;
            let cos = -way.normalize().dot(axis);
            let edge = ((cos - outer.cos()) / ((1.0 - outer.cos()) * blend)).clamp(0.0, 1.0);
            let falloff = edge * edge * (3.0 - 2.0 * edge);
            (way.normalize(), way.length(), 30.0 * falloff / way.length_squared())
        });
        let found = look(&scene, &EXACT, x, y).shafts.x;
        assert!((found - expected).abs() <= 1e-6 * expected.max(1e-9), "({x}, {y}): {found} {expected}");
    }
}

/// Looking into the sun the depth along the way does not change with `t`:
/// `L = sigma_s phase(1) E exp(-sigma_t b) b` for fog that ends at distance `b`.
#[test]
fn looking_into_the_sun_has_a_closed_form() {
    let mut scene = camera_at(DVec3::ZERO);
    let (low, high) = (DVec3::new(-1.0, -1.0, -3.0), DVec3::new(1.0, 1.0, 1.0));
    add_fog(&mut scene, low, high, Rgb::splat(0.4), Rgb::splat(0.5), 0.7);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::Z, Rgb::splat(5.0));
    let phase = (1.0 - 0.49) / (4.0 * PI * 0.3_f64.powi(3));
    let expected = 0.2 * phase * 5.0 * (-0.4 * 3.0_f64).exp() * 3.0;
    let found = look(&scene, &EXACT, 0.5, 0.5).shafts.x;
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    // And nothing jumps on the way there.
    let nearly = look(&scene, &EXACT, 0.5 + 1e-9, 0.5).shafts.x;
    assert!((nearly / expected - 1.0).abs() < 1e-7, "{nearly} {expected}");
}

#[test]
fn each_channel_has_its_own_fog() {
    let mut scene = camera_at(DVec3::ZERO);
    let (low, high) = (DVec3::splat(-4.0), DVec3::splat(4.0));
    let sigma_t = Rgb::new(0.1, 0.5, 2.0);
    add_fog(&mut scene, low, high, sigma_t, Rgb::new(0.9, 0.5, 0.3), 0.2);
    add_light(&mut scene, LightKind::Sun, DVec3::ZERO, DVec3::new(0.2, -1.0, 0.1), Rgb::ONE);
    let together = look(&scene, &EXACT, 0.3, 0.6);
    for channel in 0..3 {
        let mut grey = scene.clone();
        grey.fogs[0].density_per_m = Track::from(Rgb::splat(sigma_t[channel]));
        let alone = look(&grey, &EXACT, 0.3, 0.6);
        assert!((together.shafts[channel] / alone.shafts[channel] - 1.0).abs() < 1e-12);
        assert!((together.transmittance[channel] / alone.transmittance[channel] - 1.0).abs() < 1e-12);
    }
}
