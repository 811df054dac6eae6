//! Where the scene is and how large it is. It is rendered as if it were here, against the truth there and
//! against the same rays here.

use crate::common::{EXACT, INSTANT};
use crate::numerics::compare::{SlicePlan, by_slices, per_ray};
use crate::numerics::scenes::{Frame, HIGH_SUN, LAMP, Lamp, grove, spread};
use glam::DVec3;
use sunfleck::color::Rgb;
use sunfleck::math::Sampler;
use sunfleck::scene::{Scene, Size};
use sunfleck::snapshot::{MeshTrees, Snapshot};
use sunfleck::transport::{Scratch, radiance};

const SIZE: Size = Size { width: 64, height: 64 };

fn hold(name: &str, frame: &Frame, lamp: Lamp, bound: f64) {
    let scene = grove(frame, lamp);
    per_ray(&scene, 1.0, spread(300)).hold(&format!("{name}, per ray"), bound);
    by_slices(&scene, &SlicePlan::even(SIZE, 17, 20)).hold(&format!("{name}, slices"), bound);
}

/// Radiance and light from the fog of the rays through the same film positions.
fn values(scene: &Scene) -> Vec<(Rgb, Rgb)> {
    let snapshot = Snapshot::new(scene, &MeshTrees::new(scene), 0, 1.0, INSTANT);
    let mut scratch = Scratch::default();
    spread(2000)
        .map(|(x, y)| {
            let mut sampler = Sampler::new(0, 0, 0, 0);
            let sample = radiance(&snapshot, &EXACT, &snapshot.view.ray(x, y), &mut sampler, &mut scratch);
            (sample.radiance, sample.shafts)
        })
        .collect()
}

fn relative_rmse(pairs: impl Iterator<Item = (Rgb, Rgb)>) -> f64 {
    let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
    for (value, expected) in pairs {
        squares += (value - expected).length_squared();
        sum += expected.length();
        count += 1.0;
    }
    (squares / count).sqrt() / (sum / count)
}

#[test]
fn moved() {
    for (axis, distance) in [(DVec3::X, 1e3), (DVec3::new(-1.0, 0.5, 2.0), 1e6), (DVec3::splat(0.7), 1e7)] {
        let frame = Frame { scale: 1.0, offset: distance * axis };
        for lamp in [HIGH_SUN, LAMP] {
            hold(&format!("moved by {distance:e}, {lamp:?}"), &frame, lamp, 1e-6);
        }
    }
}

#[test]
fn scaled() {
    for scale in [1e-4, 1e-3, 1e3, 1e4] {
        let frame = Frame { scale, offset: DVec3::ZERO };
        for lamp in [HIGH_SUN, LAMP] {
            hold(&format!("scaled by {scale:e}, {lamp:?}"), &frame, lamp, 1e-6);
        }
    }
}

#[test]
fn scaled_and_moved() {
    for (scale, distance) in [(1e-4, 1e7), (1e-3, 1e6), (1e4, 1e7)] {
        let frame = Frame { scale, offset: DVec3::new(distance, -distance, 0.3 * distance) };
        for lamp in [HIGH_SUN, LAMP] {
            hold(&format!("scaled by {scale:e}, moved by {distance:e}, {lamp:?}"), &frame, lamp, 1e-6);
        }
    }
}

/// Double precision places a leaf of a millimetre to 1e-10 m at 1e6 m: to 1e-7 of its size.
#[test]
fn the_picture_stays_the_same() {
    for lamp in [HIGH_SUN, LAMP] {
        let here = values(&grove(&Frame::HERE, lamp));
        for (scale, distance) in [
            (1.0, 1e6),
            (1e-3, 0.0),
            (1e3, 0.0),
            (1e-4, 0.0),
            (1e4, 0.0),
            (1e3, 1e6),
            (1.0, 1e7),
            (1e-3, 1e6),
        ] {
            let frame = Frame { scale, offset: distance * DVec3::new(0.6, -0.2, 0.77) };
            let there = values(&grove(&frame, lamp));
            let pairs = || here.iter().zip(&there);
            // A ray that grazes an edge sees one thing here and another there.
            let same = |(here, there): &(&(Rgb, Rgb), &(Rgb, Rgb))| {
                (here.0 - there.0).length() < 0.01 * here.0.length()
            };
            let changed = here.len() - pairs().filter(same).count();
            let error = relative_rmse(pairs().filter(same).map(|(here, there)| (there.0, here.0)));
            println!("scaled by {scale:e}, moved by {distance:e}, {lamp:?}: {error:.1e}, {changed} changed");
            assert!(changed == 0 && error <= 1e-5, "{scale:e} {distance:e}: {error:.1e}, {changed}");
        }
    }
}
