//! Whole pictures by slices: time and error against the converged reference, one thread.

use crate::inputs;
use std::path::Path;
use std::time::Instant;
use sunfleck::frame_file::{self, compare, net_rmse};
use sunfleck::render::{Job, Placement, Watch, render};
use sunfleck::scene::{Sampling, Size, Window};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};
use sunfleck::transport::{Transport, VolumeMethod};

/// Root mean square of the reference's standard error (tests/data/leaves500/README.md).
const REFERENCE_NOISE: f64 = 0.00143;

/// Prints a row for each number of samples a pixel; the median of `rounds` counts.
pub fn run(rounds: usize) {
    let scene = inputs::load("leaves500/leaves500.glb");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/leaves500/box.exr");
    let reference = frame_file::read(&path).expect("a good file").frame;
    let size = Size { width: 480, height: 270 };
    let trees = MeshTrees::new(&scene);
    let instant = Shutter { open_s: 0.0, close_s: 0.0 };
    let exposure = Exposure::new(&scene, &trees, 0, 480.0 / 270.0, instant);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    println!("leaves500, {} x {}, one thread, median of {rounds} rounds", size.width, size.height);
    println!("{:<10} {:>8} {:>10} {:>12} {:>12}", "method", "samples", "seconds", "net RMSE", "mean ratio");
    for samples in [1, 2, 4, 8, 16, 32, 64] {
        for (name, placement) in [("slices", Placement::Slices), ("segments", Placement::Pixels)] {
            // Segments take many times as long: a few rows tell.
            if placement == Placement::Pixels && samples > 16 {
                continue;
            }
            let transport = Transport { volume: VolumeMethod::Segments, mirror_depth: 0, features: false };
            let window = Window::whole(size);
            let sampling = Sampling::Exactly(samples);
            let job = Job { size, window, passes: vec![], sampling, seed: 0, transport, placement };
            let mut times = Vec::new();
            let mut frame = None;
            for _ in 0..rounds {
                let started = Instant::now();
                frame = Some(pool.install(|| render(&exposure, &job, &Watch::NOBODY).frame));
                times.push(started.elapsed().as_secs_f64());
            }
            times.sort_unstable_by(f64::total_cmp);
            let color =
                frame.and_then(|frame| compare(&frame, &reference).ok()).and_then(|found| found.color);
            let color = color.expect("the same size");
            println!(
                "{name:<10} {samples:>8} {:>10.3} {:>12.5} {:>12.6}",
                times[times.len() / 2],
                net_rmse(color.rmse, REFERENCE_NOISE),
                color.mean_ratio
            );
        }
    }
}
