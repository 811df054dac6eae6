//! Error of indirect light, and its correction. In go a snapshot, a job and the grid, out come a correction
//! by random walks and the error that is left. Invariant: it depends on the whole picture, for any wanted
//! part.

use super::Job;
use super::correction::{self, Correction, mean};
use super::error_left::{Left, Light};
use super::importance::Importance;
use super::map::{Map, Shape};
use super::moments::Moments;
use super::probes::{GROUP, PASSES, Plan, probes};
use super::survey::Survey;
use crate::color::{Rgb, luminance};
use crate::film::Blocks;
use crate::indirect::Indirect;
use crate::scene::{Sampling, Size};
use crate::snapshot::Snapshot;
use crate::transport::{Branches, Learned, Noted};
use glam::DVec2;
use std::f64::consts::PI;
use std::sync::Arc;

/// Number of first walks.
const FIRST: u32 = 1 << 13;
/// Maximum number of walks at the usual tolerance: in all, and for each pixel of the picture.
const MOST: f64 = (1 << 20) as f64;
const MOST_A_PIXEL: f64 = 128.0;
/// Multiple of the tolerance above which an estimate allows more walks, and how many times as many.
const FAR: f64 = 1.5;
const MORE: f64 = 2.0;
/// Random points of a walk above which it counts as more than one walk. Most take 3 to 30, and those in deep
/// fog without absorption some 200. Branches count by their points.
const POINTS_OF_A_WALK: f64 = 64.0;
/// The usual tolerance, also used where the error is estimated without a tolerance. The error of walks falls
/// with the root of their number.
const USUAL: f64 = 0.02;
/// Maximum number of walks that branch off a camera ray, of the noisier pass: the ray and the grid's value
/// then cost little.
const MOST_BRANCHES: u32 = 8;
/// Number of walks that are traced before they are added up, and before a cancelled frame ends.
const BATCH: f64 = (1 << 12) as f64;
/// Minimum growth of the number of walks, as a share of it. Their errors fall as its root.
const LEAST_MORE: f64 = 0.25;
/// Number of successive walks of the same half.
const RUN: u32 = 1 << 9;

/// Minimum standard deviation of the Gaussian over which errors are averaged, in cells. It is as wide as
/// blocks of so many pixels in a small picture: a Gaussian covers `4 pi` of its variance.
const SURROUNDINGS: f64 = 1.0;
const PIXELS_OF_BLOCK: f64 = 100.0;
/// Ratio of errors in blocks of pixels to those in surroundings, which are larger.
const FINER: f64 = 1.1;
/// Width of the reported error, in standard errors: nineteen of twenty blocks are within it.
const STANDARD_ERRORS: f64 = 2.0;

/// Estimate of indirect light's error.
pub(super) struct GridError {
    pub(super) correction: Correction,
    squares: Map<f64>,
    /// Root mean square of the reported error, as a share of the picture's mean.
    pub(super) relative: f64,
}

impl GridError {
    /// Adds walks until the error is within the tolerance, or their number is at its maximum.
    pub(super) fn found(
        snapshot: &Snapshot,
        job: &Job,
        indirect: &Indirect,
        survey: &Survey,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let tolerance = match job.sampling {
            Sampling::Until { tolerance, .. } => tolerance,
            Sampling::Exactly(_) => USUAL,
        };
        let most = most_walks(job.size, tolerance);
        let shape = Shape::of(job.size);
        let none = || [Moments::none(shape), Moments::none(shape)];
        let mut halves = none();
        let mut numbers = 0..FIRST;
        let importance = Importance::even(shape);
        let mut plan = Plan { importance, branches: Branches::ONE, learned: None, shares: false };
        let (mut drawn, mut drawn_by_one, mut noted) = (0.0, POINTS_OF_A_WALK, Noted::default());
        loop {
            let rays = (BATCH / plan.branches.mean()) as u32 / GROUP * GROUP;
            for start in numbers.clone().step_by(rays as usize) {
                let batch = start..numbers.end.min(start + rays);
                for (number, probe) in batch.clone().zip(probes(batch, &plan, snapshot, job, indirect)) {
                    halves[(number / RUN % 2) as usize].add(&probe);
                    drawn += f64::from(probe.drawn);
                    noted.extend(probe.noted);
                }
                if cancelled() {
                    break;
                }
            }
            let known = Self::of(&halves, survey, job.size);
            if plan.branches == Branches::ONE {
                drawn_by_one = (drawn / f64::from(FIRST)).clamp(1.0, POINTS_OF_A_WALK);
            }
            let most = if known.relative > FAR * tolerance { MORE * most } else { most };
            let room = most * drawn_by_one / drawn.max(f64::from(numbers.end)) - 1.0;
            if known.relative <= tolerance || room < LEAST_MORE || cancelled() {
                return known;
            }
            if plan.branches == Branches::ONE {
                // First probes are left out of the sums, as they are noisier and would have the same weight.
                let first = halves[0].with(&halves[1]);
                plan = Plan {
                    importance: Importance::of(&Light::of(&first).brightness()),
                    branches: branches_by_noise(&first),
                    learned: Some(Arc::new(Learned::of(&std::mem::take(&mut noted), snapshot))),
                    shares: false,
                };
                halves = none();
                numbers = FIRST..FIRST + FIRST / 2;
            } else {
                let wanted = (known.relative / tolerance).powi(2) - 1.0;
                // Sharing has a price, and pays where walks are too few.
                plan.shares |= wanted > room;
                let more = wanted.clamp(LEAST_MORE, room.min(1.0)) * f64::from(numbers.end - FIRST);
                let runs = (more / f64::from(2 * RUN)).ceil().max(1.0) as u32;
                numbers = numbers.end..numbers.end + 2 * RUN * runs;
            }
        }
    }

    /// Error from the sums of two halves of the walks.
    fn of(halves: &[Moments; 2], survey: &Survey, size: Size) -> Self {
        let all = halves[0].with(&halves[1]);
        let near_cells = surroundings(size);
        let of_halves = correction::by_halves(halves, near_cells);
        let correction: [Map<Rgb>; PASSES] = std::array::from_fn(|pass| {
            let [one, other] = of_halves.each_ref().map(|shares| &shares[pass]);
            one.like(|cell| 0.5 * (one.of(cell) + other.of(cell)))
        });
        let light = Light::of(&all);
        let left = Left::of((halves, near_cells), &of_halves, &light);
        let squares = left.squares(&light);
        let mean_light = light.mean();
        // Luminance errs as much as light does: the channels' errors are alike.
        let in_luminance =
            if mean(mean_light) > 0.0 { luminance(mean_light) / mean(mean_light) } else { 0.0 };
        let squares = squares.like(|cell| (FINER * in_luminance).powi(2) * squares.of(cell));
        let cells = squares.shape.count() as f64;
        let added = |pass: usize| {
            squares.like(|cell| correction[pass].of(cell) * light.0[pass].of(cell)).sum() / cells
        };
        let added = luminance((0..PASSES).map(added).sum());
        // The walks' rays are many more than a survey's, so their mean of indirect light is better.
        let picture = survey.direct + luminance(mean_light) + added;
        let error = STANDARD_ERRORS * (squares.sum() / cells).sqrt();
        let relative = if error > 0.0 { error / picture.max(f64::MIN_POSITIVE) } else { 0.0 };
        Self { correction: Correction { size, shares: correction }, squares, relative }
    }

    /// Estimated error of the luminance of a block of pixels.
    pub(super) fn of_block(&self, blocks: &Blocks, block: usize, job: &Job) -> f64 {
        let window = blocks.pixels(block);
        let middle = |from: usize, count: usize, of: usize| (from as f64 + 0.5 * count as f64) / of as f64;
        let place = DVec2::new(
            middle(window.x, window.width, job.size.width),
            middle(window.y, window.height, job.size.height),
        );
        STANDARD_ERRORS * self.squares.of(self.squares.shape.cell_at(place)).sqrt()
    }
}

/// Numbers of branches with the least noise for their cost: in proportion to the standard deviation of one.
fn branches_by_noise(first: &Moments) -> Branches {
    let none = Map::filled(first.shape(), Rgb::ZERO);
    let [at_surfaces, in_fog] =
        std::array::from_fn(|pass| mean(first.squares_left(pass, &none).sum()).max(0.0).sqrt());
    let share = |noise: f64| {
        let of_most = noise / at_surfaces.max(in_fog).max(f64::MIN_POSITIVE);
        MOST_BRANCHES >> (-of_most.log2()).round().clamp(0.0, f64::from(MOST_BRANCHES.ilog2())) as u32
    };
    Branches { at_surfaces: share(at_surfaces), in_fog: share(in_fog) }
}

/// Standard deviation of the Gaussian over which errors of a picture are averaged, in cells.
fn surroundings(size: Size) -> f64 {
    let of_block = PIXELS_OF_BLOCK / (size.width as f64 * size.height as f64);
    (Shape::of(size).count() as f64 * of_block / (4.0 * PI)).sqrt().max(SURROUNDINGS)
}

/// Maximum number of walks for a picture of a size and a tolerance.
fn most_walks(size: Size, tolerance: f64) -> f64 {
    /// Maximum at any tolerance, and factor on the maximum for each pixel at the usual tolerance.
    const AT_ALL: f64 = (1 << 22) as f64;
    const TIMES: f64 = 4.0;
    let pixels = size.width as f64 * size.height as f64;
    let times = (USUAL / tolerance.clamp(1e-6, USUAL)).powi(2);
    (times * MOST.min(MOST_A_PIXEL * pixels)).min(AT_ALL).min(TIMES * MOST_A_PIXEL * pixels)
}
