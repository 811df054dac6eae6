//! Light of a lamp that even fog scatters twice, against its closed form.

use crate::common::{INSTANT, add_fog, add_light, camera_at};
use glam::DVec3;
use std::f64::consts::PI;
use sunfleck::color::Rgb;
use sunfleck::indirect::{Indirect, KeptLight};
use sunfleck::math::gauss_legendre;
use sunfleck::scene::{Bounces, LightKind};
use sunfleck::snapshot::{Exposure, MeshTrees};

/// Extinction of the fog, which absorbs nothing, 1/m.
const SIGMA_PER_M: f64 = 0.05;

/// Mean of a function over an interval, by pieces of 16 nodes.
fn mean(pieces: u32, of: impl Fn(f64) -> f64) -> f64 {
    let piece = |number: u32| -> f64 {
        let at = |node: f64| of((f64::from(number) + 0.5 + 0.5 * node) / f64::from(pieces));
        gauss_legendre(16).iter().map(|(node, weight)| 0.5 * weight * at(*node)).sum()
    };
    (0..pieces).map(piece).sum::<f64>() / f64::from(pieces)
}

/// Fluence of light that was scattered once in boundless fog, about a lamp of 1 W, at an optical distance
/// from it. It is the integral of two inverse squares with their transmittances, in bipolar coordinates.
fn scattered_once(depth: f64) -> f64 {
    // The length of both ways together is `depth / share`.
    let of = |share: f64| (-depth / share).exp() / share * ((1.0 + share) / (1.0 - share)).ln();
    // Nodes crowd at 1, where the logarithm is infinite.
    let integral = mean(8, |x| 2.0 * (1.0 - x) * of(1.0 - (1.0 - x) * (1.0 - x)));
    SIGMA_PER_M * SIGMA_PER_M / (4.0 * PI * depth) * integral
}

/// A box of 36 optical depths, where cells that fill it would be much larger than the lamp's surroundings.
#[test]
fn fog_about_a_lamp_scatters_again_in_a_box_of_any_size() {
    let lamp = DVec3::new(0.5, 2.5, -4.0);
    for half_m in [100.0, 360.0] {
        let mut scene = camera_at(DVec3::ZERO);
        add_fog(
            &mut scene,
            DVec3::splat(-half_m),
            DVec3::splat(half_m),
            Rgb::splat(SIGMA_PER_M),
            Rgb::ONE,
            0.0,
        );
        add_light(&mut scene, LightKind::Point, lamp, DVec3::NEG_Y, Rgb::splat(1.0 / (4.0 * PI)));
        let trees = MeshTrees::new(&scene);
        let exposure = Exposure::new(&scene, &trees, 0, 1.0, INSTANT);
        let snapshot = exposure.middle();
        let indirect =
            Indirect::new(&exposure, Bounces::UpTo(1), 1.0, &KeptLight::default(), &|| false).unwrap();
        let reach_m = 10.0;
        let (mut found, mut expected) = (0.0, 0.0);
        for place in [[0.3, 0.4], [0.5, 0.5], [0.6, 0.1], [0.8, 0.7]] {
            let ray = snapshot.view.ray(place[0], place[1]);
            let through = snapshot.medium.transmittance(ray.origin, ray.direction, reach_m);
            found += indirect.seen_in_fog(snapshot, &ray, reach_m, through).x;
            expected += reach_m
                * mean(64, |share| {
                    let distance_m = share * reach_m;
                    let depth = SIGMA_PER_M * (ray.at(distance_m) - lamp).length();
                    let sent = SIGMA_PER_M / (4.0 * PI) * scattered_once(depth);
                    sent * (-SIGMA_PER_M * distance_m).exp()
                });
        }
        let ratio = found / expected;
        println!("twice scattered, box of {half_m} m: {ratio:.4}");
        assert!((ratio - 1.0).abs() < 0.03, "{half_m}: {ratio}");
    }
}
