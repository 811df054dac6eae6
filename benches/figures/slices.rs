//! Whole pictures by slices: time and error against a converged reference.

use crate::checkout;
use crate::inputs;
use cpu_time::ProcessTime;
use std::time::Instant;
use sunfleck::description;
use sunfleck::film::Frame;
use sunfleck::frame_file::{self, Errors, compare, net_rmse};
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{self, PixelFilter, Sampling, Scene, Size, Window};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

const SIZE: Size = Size { width: 480, height: 270 };

/// The errors whose price is quoted.
const TARGETS: [f64; 2] = [0.02, 0.01];

/// Tolerances whose price is quoted too.
const TOLERANCES: [f64; 4] = [0.1, 0.05, 0.02, 0.01];

/// leaves500: a row for each number of samples a pixel, the fastest of `rounds` counts; then what a
/// second thread gains.
pub fn run(rounds: usize) {
    /// Root mean square of the reference's standard error (tests/data/leaves500/README.md).
    const REFERENCE_NOISE: f64 = 0.00143;
    let scene = inputs::load("leaves500/leaves500.glb");
    let trees = MeshTrees::new(&scene);
    let exposure = Exposure::new(&scene, &trees, 0, aspect(), INSTANT);
    let path = checkout::file("tests/data/leaves500/box.exr");
    let reference = frame_file::read(&path).expect("a good file").frame;
    println!("leaves500, {} x {}, one thread", SIZE.width, SIZE.height);
    table(&exposure, &reference, REFERENCE_NOISE, &[1, 2, 4, 8, 16, 32, 64], Method::Slices, rounds);
    threads(&exposure, rounds);
    println!("\nthe same by the per-ray method");
    table(&exposure, &reference, REFERENCE_NOISE, &[4, 8, 16], Method::Segments, 1);
}

/// canopy20k, against itself.
pub fn run_canopy(rounds: usize) {
    let path = checkout::file("tests/data/canopy20k/scene.ron");
    let mut fastest = f64::INFINITY;
    for _ in 0..rounds {
        let started = Instant::now();
        let description = description::load(&path).expect("a good file");
        let scene = scene::resolve(description, None).expect("a good scene").0;
        let trees = MeshTrees::new(&scene);
        Exposure::new(&scene, &trees, 0, aspect(), INSTANT).moments();
        fastest = fastest.min(started.elapsed().as_secs_f64());
    }
    println!("canopy20k, {} x {}, one thread; loaded and built in {fastest:.3} s", SIZE.width, SIZE.height);
    against_itself(&inputs::load("canopy20k/scene.ron"), rounds);
}

/// leaves500 under a sun with an extent, and with the sun in the middle of the picture.
pub fn run_sun(rounds: usize) {
    println!("leaves500, {} x {}, one thread", SIZE.width, SIZE.height);
    for (name, scene) in inputs::suns() {
        println!("\n{name}");
        against_itself(&scene, rounds);
    }
}

/// A table against two converged pictures by slices themselves, of other seeds: the mean of the two is
/// the reference, half their difference its noise. That the mean is true is what `-- bias` tests.
fn against_itself(scene: &Scene, rounds: usize) {
    const SAMPLES: u32 = 512;
    let trees = MeshTrees::new(scene);
    let exposure = Exposure::new(scene, &trees, 0, aspect(), INSTANT);
    let [one, two] =
        [1, 2].map(|seed| render(&exposure, &job(SAMPLES, seed, Method::Slices), &Watch::NOBODY).frame);
    let noise = 0.5 * difference(&one, &two).rmse;
    let reference = mean(one, &two);
    println!("the reference is the mean of two pictures of {SAMPLES} samples; its noise is {noise:.5}");
    table(&exposure, &reference, noise, &[1, 2, 4, 8, 16, 32], Method::Slices, rounds);
}

/// Prints CPU time and error for each number of samples, the time to the targets in between, and by slices
/// the same for pictures of a tolerance.
fn table(
    exposure: &Exposure,
    reference: &Frame,
    reference_noise: f64,
    samples: &[u32],
    method: Method,
    rounds: usize,
) {
    println!("{:>16} {:>10} {:>12} {:>12}", "samples", "CPU s", "net RMSE", "mean ratio");
    let row = |name: &str, job: &Job| {
        let pool = pool(1);
        let (seconds, frame) =
            fastest(rounds, || pool.install(|| render(exposure, job, &Watch::NOBODY).frame));
        let found = difference(&frame, reference);
        let error = net_rmse(found.rmse, reference_noise);
        println!("{name:>16} {seconds:>10.3} {error:>12.5} {:>12.6}", found.mean_ratio);
        (seconds, error)
    };
    let rows: Vec<(f64, f64)> =
        samples.iter().map(|&samples| row(&samples.to_string(), &job(samples, 0, method))).collect();
    for tolerance in if method == Method::Slices { TOLERANCES.as_slice() } else { &[] } {
        let sampling = Sampling::Until { tolerance: *tolerance, most: 1024 };
        row(&format!("tolerance {tolerance}"), &Job { sampling, ..job(1, 0, method) });
    }
    for target in TARGETS {
        let crossed = rows.windows(2).find(|pair| pair[0].1 >= target && target > pair[1].1);
        let Some(&[(t0, e0), (t1, e1)]) = crossed.and_then(|pair| pair.first_chunk::<2>()) else { continue };
        // A straight line between the two rows, both axes logarithmic.
        let seconds = t0 * (t1 / t0).powf((target / e0).ln() / (e1 / e0).ln());
        println!("net RMSE {target} in {seconds:.3} CPU s");
    }
}

/// Wall clock of one thread and of two, in turns.
fn threads(exposure: &Exposure, rounds: usize) {
    let job = job(16, 0, Method::Slices);
    let pools = [pool(1), pool(2)];
    let mut fastest = [f64::INFINITY; 2];
    for _ in 0..rounds {
        for (pool, fastest) in pools.iter().zip(&mut fastest) {
            let started = Instant::now();
            pool.install(|| render(exposure, &job, &Watch::NOBODY).frame);
            *fastest = fastest.min(started.elapsed().as_secs_f64());
        }
    }
    println!("16 samples in one thread: {:.3} s, in two: {:.3} s", fastest[0], fastest[1]);
}

const INSTANT: Shutter = Shutter { open_s: 0.0, close_s: 0.0 };

fn aspect() -> f64 {
    SIZE.width as f64 / SIZE.height as f64
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

fn job(samples: u32, seed: u32, method: Method) -> Job {
    Job {
        size: SIZE,
        window: Window::whole(SIZE),
        passes: vec![],
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed,
        mirror_depth: 0,
        bounces: sunfleck::scene::Bounces::NONE,
        method,
    }
}

fn fastest(rounds: usize, render: impl Fn() -> Frame) -> (f64, Frame) {
    let mut seconds = f64::INFINITY;
    let mut frame = None;
    for _ in 0..rounds.max(1) {
        let started = ProcessTime::now();
        frame = Some(render());
        seconds = seconds.min(started.elapsed().as_secs_f64());
    }
    (seconds, frame.expect("at least one round"))
}

fn difference(frame: &Frame, reference: &Frame) -> Errors {
    compare(frame, reference).ok().and_then(|found| found.color).expect("the same size")
}

fn mean(mut one: Frame, two: &Frame) -> Frame {
    for (a, b) in one.channels.iter_mut().zip(&two.channels) {
        for (a, b) in a.pixels.iter_mut().zip(&b.pixels) {
            *a = 0.5 * (*a + *b);
        }
    }
    one
}
