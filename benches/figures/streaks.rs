//! Whether the error of few samples lies in streaks along the slices, and whether it has a bias.

use crate::inputs;
use glam::DVec2;
use sunfleck::color::luminance;
use sunfleck::film::Frame;
use sunfleck::math::Sampler;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{PixelFilter, Sampling, Scene, Size, Window};
use sunfleck::snapshot::{Exposure, FrozenLight, MeshTrees, Shutter};

const SIZE: Size = Size { width: 240, height: 135 };

fn luminances(exposure: &Exposure, samples: u32, seed: u32, method: Method) -> Vec<f64> {
    let job = Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: vec![],
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed,
        mirror_depth: 0,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    };
    let frame: Frame = render(exposure, &job, &Watch::NOBODY).frame;
    let channel = |name: &str| frame.channel(name).expect("a colour").pixels.iter().map(|&v| f64::from(v));
    let colours = channel("R").zip(channel("G")).zip(channel("B"));
    colours.map(|((r, g), b)| luminance(glam::DVec3::new(r, g, b))).collect()
}

/// Where the light is in the picture, pixels.
fn epipole(exposure: &Exposure) -> DVec2 {
    let view = &exposure.middle().view;
    let towards = match exposure.middle().lights[0].centre() {
        FrozenLight::Sun { to_light, .. } => to_light,
        FrozenLight::Point { position, .. } => position,
    };
    let (right, up, forward) = view.axes();
    let on_plane =
        DVec2::new(towards.dot(right), towards.dot(up)) / towards.dot(forward) / view.half_extents();
    DVec2::new(0.5 + 0.5 * on_plane.x, 0.5 - 0.5 * on_plane.y)
        * DVec2::new(SIZE.width as f64, SIZE.height as f64)
}

/// Correlation of the errors of pixels so far apart, along their slice or across it.
fn correlation(errors: &[f64], epipole: DVec2, distance_px: f64, across: bool) -> f64 {
    let (mut products, mut squares) = (0.0, 0.0);
    for (index, error) in errors.iter().enumerate() {
        let place = DVec2::new((index % SIZE.width) as f64 + 0.5, (index / SIZE.width) as f64 + 0.5);
        let along = (place - epipole).normalize_or_zero();
        let other = place + distance_px * if across { along.perp() } else { along };
        if other.x < 0.0 || other.y < 0.0 || other.x >= SIZE.width as f64 || other.y >= SIZE.height as f64 {
            continue;
        }
        products += error * errors[other.y as usize * SIZE.width + other.x as usize];
        squares += error * error;
    }
    products / squares
}

fn report(name: &str, scene: &Scene, open_for_s: f64) {
    let trees = MeshTrees::new(scene);
    let shutter = Shutter { open_s: -0.5 * open_for_s, close_s: 0.5 * open_for_s };
    let exposure = Exposure::new(scene, &trees, 0, 16.0 / 9.0, shutter);
    let epipole = epipole(&exposure);
    let truth = luminances(&exposure, 512, 1000, Method::Slices);
    let mean = truth.iter().sum::<f64>() / truth.len() as f64;
    for samples in [2, 4, 8, 16, 32] {
        let picture = luminances(&exposure, samples, 0, Method::Slices);
        let errors: Vec<f64> = picture.iter().zip(&truth).map(|(a, b)| a - b).collect();
        let rmse = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt();
        let row = |across| [2.0, 4.0, 8.0].map(|d| correlation(&errors, epipole, d, across));
        let ([a2, a4, a8], [c2, c4, c8]) = (row(false), row(true));
        println!(
            "{name:<16} {samples:>7} {:>10.4} {a2:>7.3} {a4:>7.3} {a8:>7.3} {c2:>8.3} {c4:>7.3} {c8:>7.3}",
            rmse / mean
        );
    }
}

/// Prints the correlation of the error along slices and across them.
pub fn run() {
    println!(
        "correlation of the errors of pixels 2, 4 and 8 apart, leaves500, {} x {}",
        SIZE.width, SIZE.height
    );
    println!(
        "{:<16} {:>7} {:>10} {:>23} {:>24}",
        "seen with", "samples", "rel. RMSE", "along the slices", "across them"
    );
    let leaves500 = || inputs::load("leaves500/leaves500.glb");
    report("a direction", &leaves500(), 0.0);
    report("0.53 degrees", &inputs::with_a_disc(leaves500()), 0.0);
    report("and a lens", &inputs::with_a_lens(inputs::with_a_disc(leaves500())), 0.0);
    report("and a shutter", &inputs::with_flying_leaves(inputs::with_a_disc(leaves500())), 0.5);
}

/// Prints, for pictures of few samples with many seeds, how far their mean is from the truth of the
/// per-ray method, in standard errors of that distance.
///
/// Pictures of fewer samples are that many more, so that each row takes as long and tells as much.
///
/// Pixels of one picture share their random numbers, so the pictures' means are what is tested, not
/// the pixels: they are independent from seed to seed.
pub fn run_bias(seeds: u32) {
    const MOST_SAMPLES: u32 = 16;
    println!("mean of the picture against the per-ray method, leaves500, {} x {}", SIZE.width, SIZE.height);
    println!(
        "{:<16} {:>7} {:>7} {:>14} {:>12} {:>8}",
        "sun", "samples", "seeds", "ratio - 1", "std. error", "z"
    );
    for (name, scene) in [
        ("a direction", inputs::load("leaves500/leaves500.glb")),
        ("0.53 degrees", inputs::with_a_disc(inputs::load("leaves500/leaves500.glb"))),
    ] {
        let trees = MeshTrees::new(&scene);
        let exposure = Exposure::new(&scene, &trees, 0, 16.0 / 9.0, Shutter { open_s: 0.0, close_s: 0.0 });
        let statistics = |samples: u32, seeds: u32, method: Method| {
            let means: Vec<f64> = (0..seeds)
                .map(|seed| {
                    // Hashed: neighbouring seeds are as good as independent.
                    let seed = (Sampler::new(seed, 7, 7, 0).next_1d() * f64::from(u32::MAX)) as u32;
                    let values = luminances(&exposure, samples, seed, method);
                    values.iter().sum::<f64>() / values.len() as f64
                })
                .collect();
            let mean = means.iter().sum::<f64>() / f64::from(seeds);
            let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / f64::from(seeds - 1);
            (mean, variance / f64::from(seeds))
        };
        let (truth, truth_variance) = statistics(64, 8, Method::Segments);
        for samples in [1, 4, MOST_SAMPLES] {
            let seeds = seeds * MOST_SAMPLES / samples;
            let (mean, variance) = statistics(samples, seeds, Method::Slices);
            let error = (variance + truth_variance).sqrt();
            println!(
                "{name:<16} {samples:>7} {seeds:>7} {:>14.6} {:>12.6} {:>8.2}",
                mean / truth - 1.0,
                error / truth,
                (mean - truth) / error
            );
        }
    }
}
