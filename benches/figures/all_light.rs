//! Light of all orders by both ways, the grid of indirect light and random walks: error against time. In goes
//! a stage, out come rows. Invariant: the reference is by random walks, which are unbiased, from numbers that
//! no row uses; its own noise is taken out of every error.

use crate::inputs;
use std::fmt::Write;
use sunfleck::bench::{Stage, colors, depth_m, mean, seconds, timed};
use sunfleck::film::Frame;
use sunfleck::render::{Job, Method, Watch, render};
use sunfleck::scene::{Bounces, PixelFilter, Sampling, Size, Window};
use sunfleck::snapshot::{Exposure, MeshTrees, Shutter};

/// Prints the errors of `leaves500`.
pub fn run(rounds: usize) {
    let scene = inputs::load("leaves500/leaves500.glb");
    let trees = MeshTrees::new(&scene);
    let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
    let exposure = Exposure::new(&scene, &trees, 0, 16.0 / 9.0, shutter);
    let stage = Stage {
        exposure: &exposure,
        size: Size { width: 240, height: 135 },
        mirror_depth: 4,
        bounces: Bounces::All,
        planes: (depth_m(exposure.middle()), 0.1),
    };
    let plan = Plan { stage, reference_samples: 64, most_samples: 16, rounds };
    println!("{}", table(&measure(&plan)));
}

/// Seeds of the reference's halves.
const HALVES: [u32; 2] = [0x5eed_0d44, 0x5eed_0e55];

/// Pixels along each side of a block.
const BLOCK: usize = 10;

/// Plan of the measurement.
pub(crate) struct Plan<'a> {
    /// The picture.
    pub(crate) stage: Stage<'a>,
    /// Samples a pixel of the reference, at least 2.
    pub(crate) reference_samples: u32,
    /// Samples a pixel of the dearest row, at least 1.
    pub(crate) most_samples: u32,
    /// Number of measurements of each row, at least one.
    pub(crate) rounds: usize,
}

/// A picture by one of the ways.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// Method.
    pub(crate) way: &'static str,
    /// Samples a pixel.
    pub(crate) samples: u32,
    /// Processor time of one thread: the least of all rounds.
    pub(crate) cpu_s: f64,
    /// Mean of the picture over that of the reference.
    pub(crate) mean_ratio: f64,
    /// Root mean square error of pixels and of means of blocks, as shares of the mean.
    pub(crate) errors: [f64; 2],
}

/// Results of the measurement.
pub(crate) struct AllLight {
    /// The grid's rows, then those of random walks.
    pub(crate) rows: Vec<Row>,
    /// Samples a pixel of the reference.
    pub(crate) reference_samples: u32,
    /// Standard error: of its mean, and in the root mean square of its pixels and blocks, as shares of the
    /// mean.
    pub(crate) noise: [f64; 3],
}

/// The picture of both halves together, and what it errs by itself.
struct Reference {
    values: [Vec<f64>; 2],
    mean: f64,
    noise: [f64; 3],
}

/// Measures with one thread; the reference is made on the current rayon pool.
pub(crate) fn measure(plan: &Plan) -> AllLight {
    eprintln!("the reference: {} samples a pixel by random walks", plan.reference_samples);
    let reference = Reference::render(plan);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let ladder = |way, method| {
        let samples = (0..).map(|power| 4_u32.pow(power)).take_while(|samples| *samples <= plan.most_samples);
        samples.map(move |samples| (way, method, samples))
    };
    let points: Vec<_> = ladder("grid", Method::Auto).chain(ladder("paths", Method::Paths)).collect();
    let mut rows: Vec<Row> = Vec::new();
    for round in 0..plan.rounds.max(1) {
        eprintln!("round {} of {}", round + 1, plan.rounds.max(1));
        for (number, &(way, method, samples)) in points.iter().enumerate() {
            let (frame, cpu_s) = one.install(|| timed(|| picture(plan, method, samples, 0)));
            match rows.get_mut(number) {
                Some(row) => row.cpu_s = row.cpu_s.min(cpu_s),
                None => rows.push(reference.row(&frame, way, samples, cpu_s)),
            }
        }
    }
    AllLight { rows, reference_samples: 2 * half(plan), noise: reference.noise }
}

/// Samples of each half of the reference.
fn half(plan: &Plan) -> u32 {
    (plan.reference_samples / 2).max(1)
}

fn picture(plan: &Plan, method: Method, samples: u32, seed: u32) -> Frame {
    let job = Job {
        size: plan.stage.size,
        window: Window::whole(plan.stage.size),
        passes: Vec::new(),
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed,
        mirror_depth: plan.stage.mirror_depth,
        bounces: plan.stage.bounces,
        method,
    };
    render(plan.stage.exposure, &job, &Watch::NOBODY).frame
}

impl Reference {
    fn render(plan: &Plan) -> Self {
        let halves = HALVES.map(|seed| picture(plan, Method::Paths, half(plan), seed));
        let values = [pixels, blocks].map(|of| halves.each_ref().map(of));
        let mean = 0.5 * (mean(&halves[0]) + mean(&halves[1]));
        // The variance of the mean of two is a quarter of that of their difference.
        let of_values = |[a, b]: &[Vec<f64>; 2]| 0.5 * root_mean_square(a, b) / mean;
        let [of_pixels, of_blocks] = values.each_ref().map(of_values);
        // Blocks err independently of each other, their colours do not.
        let of_mean = of_blocks / (values[1][0].len() as f64 / 3.0).sqrt();
        let both = |[a, b]: &[Vec<f64>; 2]| a.iter().zip(b).map(|(a, b)| 0.5 * (a + b)).collect();
        Self { values: values.each_ref().map(both), mean, noise: [of_mean, of_pixels, of_blocks] }
    }

    fn row(&self, frame: &Frame, way: &'static str, samples: u32, cpu_s: f64) -> Row {
        let net = |found: &[f64], wanted: &[f64], noise: f64| {
            let rmse = root_mean_square(found, wanted) / self.mean;
            (rmse * rmse - noise * noise).max(0.0).sqrt()
        };
        let errors = [
            net(&pixels(frame), &self.values[0], self.noise[1]),
            net(&blocks(frame), &self.values[1], self.noise[2]),
        ];
        Row { way, samples, cpu_s, mean_ratio: mean(frame) / self.mean, errors }
    }
}

fn pixels(frame: &Frame) -> Vec<f64> {
    colors(frame).collect()
}

/// Means over blocks of each colour; what fills none is left out, unless that is all.
fn blocks(frame: &Frame) -> Vec<f64> {
    let (width, height) = (frame.window.width, frame.window.height);
    let (wide, high) = (BLOCK.min(width), BLOCK.min(height));
    let values = pixels(frame);
    let of_channel = |channel: &[f64]| -> Vec<f64> {
        let mean = |number: usize| {
            let (left, top) = (number % (width / wide) * wide, number / (width / wide) * high);
            let rows = (top..top + high).map(|y| channel[y * width + left..][..wide].iter().sum::<f64>());
            rows.sum::<f64>() / (wide * high) as f64
        };
        (0..(width / wide) * (height / high)).map(mean).collect()
    };
    values.chunks(width * height).flat_map(of_channel).collect()
}

fn root_mean_square(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>() / a.len() as f64).sqrt()
}

/// Table for people.
fn table(measured: &AllLight) -> String {
    let [of_mean, of_pixels, of_blocks] = measured.noise.map(|noise| 100.0 * noise);
    let mut text = format!(
        "reference: {} samples a pixel by random walks; its noise {of_mean:.3} % of the mean, {of_pixels:.2} % a pixel, {of_blocks:.2} % a block of {BLOCK}x{BLOCK}\n\n",
        measured.reference_samples
    );
    let _ = writeln!(
        text,
        "{:<6} {:>7} {:>10} {:>10} {:>9} {:>9}",
        "light", "samples", "CPU s", "mean ratio", "pixels %", "blocks %"
    );
    for row in &measured.rows {
        let [of_pixels, of_blocks] = row.errors.map(|error| 100.0 * error);
        let _ = writeln!(
            text,
            "{:<6} {:>7} {:>10} {:>10.4} {of_pixels:>9.2} {of_blocks:>9.2}",
            row.way,
            row.samples,
            seconds(row.cpu_s),
            row.mean_ratio
        );
    }
    text
}
