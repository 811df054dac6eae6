//! Light of all orders by both ways, the grid of indirect light and random walks: error against time. In goes
//! a stage, out come rows. Invariant: the reference is by random walks, which are unbiased, from numbers that
//! no row uses; its own noise is taken out of every error.

use super::Stage;
use super::error::{colors, mean};
use super::method::timed;
use super::report::seconds;
use crate::film::Frame;
use crate::render::{Job, Method, Watch, render};
use crate::scene::{Bounces, PixelFilter, Sampling, Window};
use std::fmt::Write;

/// Seeds of the reference's halves.
const HALVES: [u32; 2] = [0x5eed_0d44, 0x5eed_0e55];

/// Pixels along each side of a block.
const BLOCK: usize = 10;

/// Plan of the measurement.
pub struct AllLightPlan<'a> {
    /// The picture.
    pub stage: Stage<'a>,
    /// Number of scatterings beyond the first.
    pub bounces: Bounces,
    /// Samples a pixel of the reference, at least 2.
    pub reference_samples: u32,
    /// Samples a pixel of the dearest row, at least 1.
    pub most_samples: u32,
    /// Number of measurements of each row, at least one.
    pub rounds: usize,
    /// Seed of the measured pictures.
    pub seed: u32,
}

/// A picture by one of the ways.
#[derive(Clone, Debug)]
pub struct AllLightRow {
    /// Method.
    pub way: &'static str,
    /// Samples a pixel.
    pub samples: u32,
    /// Processor time of one thread: the least of all rounds.
    pub cpu_s: f64,
    /// Mean of the picture over that of the reference.
    pub mean_ratio: f64,
    /// Root mean square error of pixels and of means of blocks, as shares of the mean.
    pub errors: [f64; 2],
}

/// Results of the measurement.
pub struct AllLight {
    /// The grid's rows, then those of random walks.
    pub rows: Vec<AllLightRow>,
    /// Samples a pixel of the reference.
    pub reference_samples: u32,
    /// Standard error: of its mean, and in the root mean square of its pixels and blocks, as shares of the
    /// mean.
    pub noise: [f64; 3],
}

/// The picture of both halves together, and what it errs by itself.
struct Reference {
    values: [Vec<f64>; 2],
    mean: f64,
    noise: [f64; 3],
}

/// Measures on the current rayon pool, which should have one thread; the reference is made on `many`.
pub fn measure(plan: &AllLightPlan, many: &rayon::ThreadPool, report: &dyn Fn(&str)) -> AllLight {
    report(&format!("the reference: {} samples a pixel by random walks", plan.reference_samples));
    let reference = many.install(|| Reference::render(plan));
    let ladder = |way, method| {
        let samples = (0..).map(|power| 4_u32.pow(power)).take_while(|samples| *samples <= plan.most_samples);
        samples.map(move |samples| (way, method, samples))
    };
    let points: Vec<_> = ladder("grid", Method::Auto).chain(ladder("paths", Method::Paths)).collect();
    let mut rows: Vec<AllLightRow> = Vec::new();
    for round in 0..plan.rounds.max(1) {
        report(&format!("round {} of {}", round + 1, plan.rounds.max(1)));
        for (number, &(way, method, samples)) in points.iter().enumerate() {
            let (frame, cpu_s) = timed(|| picture(plan, method, samples, plan.seed));
            match rows.get_mut(number) {
                Some(row) => row.cpu_s = row.cpu_s.min(cpu_s),
                None => rows.push(reference.row(&frame, way, samples, cpu_s)),
            }
        }
    }
    AllLight { rows, reference_samples: 2 * half(plan), noise: reference.noise }
}

/// Samples of each half of the reference.
fn half(plan: &AllLightPlan) -> u32 {
    (plan.reference_samples / 2).max(1)
}

fn picture(plan: &AllLightPlan, method: Method, samples: u32, seed: u32) -> Frame {
    let job = Job {
        size: plan.stage.size,
        window: Window::whole(plan.stage.size),
        passes: Vec::new(),
        sampling: Sampling::Exactly(samples),
        filter: PixelFilter::Box,
        seed,
        mirror_depth: plan.stage.mirror_depth,
        bounces: plan.bounces,
        method,
    };
    render(plan.stage.exposure, &job, &Watch::NOBODY).frame
}

impl Reference {
    fn render(plan: &AllLightPlan) -> Self {
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

    fn row(&self, frame: &Frame, way: &'static str, samples: u32, cpu_s: f64) -> AllLightRow {
        let net = |found: &[f64], wanted: &[f64], noise: f64| {
            let rmse = root_mean_square(found, wanted) / self.mean;
            (rmse * rmse - noise * noise).max(0.0).sqrt()
        };
        let errors = [
            net(&pixels(frame), &self.values[0], self.noise[1]),
            net(&blocks(frame), &self.values[1], self.noise[2]),
        ];
        AllLightRow { way, samples, cpu_s, mean_ratio: mean(frame) / self.mean, errors }
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
pub fn table(measured: &AllLight) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Precision};
    use crate::scene::Size;

    #[test]
    fn blocks_are_means_and_leave_rims_out() {
        let size = Size { width: 23, height: 11 };
        let values = |factor: f32| (0..23 * 11).map(|number| factor * (number % 23) as f32).collect();
        let channel = |name, factor| Channel::new(name, Precision::Float, values(factor));
        let channels = vec![channel("R", 1.0), channel("G", 2.0), channel("B", 0.0)];
        let frame = Frame { full: size, window: Window::whole(size), channels };
        assert_eq!(blocks(&frame), [4.5, 14.5, 9.0, 29.0, 0.0, 0.0]);
    }
}
