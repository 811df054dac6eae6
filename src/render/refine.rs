//! Rounds until a picture is within its tolerance. In goes a picture that is rendered in rounds, out come its
//! film and the remaining errors of its blocks. Invariant: a crop has the pixels of the whole picture.
//! Whether a block or a pixel goes on depends on its block's samples, and on those by which neighbouring
//! blocks are judged for the first time.

use super::rounds::{LOOSE, Picture, Round, Schedule};
use super::survey::Survey;
use super::{Job, Watch};
use crate::film::{BlockEstimate, Blocks, Film, Mask, PixelEstimate};
use crate::math::large_list;
use rayon::prelude::*;

/// Minimum luminance of blocks for relative errors, as a part of the picture's mean: errors of darker blocks
/// are invisible, and relative errors grow without bound in the dark.
const DARKEST: f64 = 0.1;

/// Part of its block's variance below which a pixel has samples enough, if its neighbours have, too: most of
/// a block's error is in the few pixels with edges.
const NEGLIGIBLE: f64 = 0.25;

/// Variance of a pixel, by its squared luminance and [`completion`], above which few samples found its light:
/// one half has three times as much as the other.
const FOUND_BY_FEW: f64 = 0.25;

/// Visible error in a block without contrast of its own.
const SEEN: f64 = 0.02;

/// Contrast of a block from which any tolerance is masked: that of foliage.
const FOLIAGE: f64 = 0.2;

/// Power of a block's contrast by which the least visible contrast in it grows (Legge & Foley 1980, "Contrast
/// masking in human vision").
const MASKING: f64 = 0.6;

/// Number of blocks that are judged at once.
const JUDGED_AT_ONCE: usize = 1024;

/// Power of the number of samples by which a block's error falls: with edges it is more than one half.
pub(super) const ORDERED: f64 = 0.75;

/// Power where samples have draws of their own and are nearly independent.
pub(super) const DRAWN: f64 = 0.5;

/// A component of a picture, or all of it, after its rounds.
pub(super) struct Refined {
    pub(super) film: Film,
    /// The blocks that it covers, those around the window included.
    pub(super) blocks: Blocks,
    /// Variance of each of them, see [`BlockEstimate::variance`]; empty if blocks are not judged.
    pub(super) variances: Vec<f64>,
    pub(super) rounds: u32,
}

pub(super) struct Goal<'a> {
    /// Maximum standard error of a block relative to its brightness, of all components together.
    pub(super) tolerance: f64,
    /// Maximum number of samples a pixel.
    pub(super) most: u32,
    pub(super) survey: &'a Survey,
    pub(super) budget: &'a Budget,
}

/// Budget of a component: its part of the variance of the sum.
pub(super) struct Budget {
    /// Share of this component.
    pub(super) share: f64,
    /// Sum of that and of the shares of the components before, whose rest it may use.
    pub(super) share_so_far: f64,
    /// Sum of the components before, block by block; empty if there are none.
    pub(super) before: Vec<BlockEstimate>,
}

impl Budget {
    /// Budget of a picture with one component.
    pub(super) const WHOLE: Self = Self { share: 1.0, share_so_far: 1.0, before: Vec::new() };
}

/// Standard error of a block relative to its brightness; 1 if the variance is unknown.
pub(super) fn relative_error(variance: f64, luminance: f64, survey: &Survey) -> f64 {
    if variance == 0.0 {
        // Even without any light.
        0.0
    } else if variance == f64::INFINITY {
        1.0
    } else {
        variance.sqrt() / visible(luminance, survey)
    }
}

/// Luminance that errors are relative to.
fn visible(luminance: f64, survey: &Survey) -> f64 {
    luminance.max(DARKEST * survey.mean)
}

/// Renders exactly the job's samples a pixel, as one round.
pub(super) fn once(picture: &impl Picture, job: &Job, watch: &Watch) -> Refined {
    let needed = job.needed_window();
    let blocks = Blocks::covering(needed, job.size);
    let window = if job.is_judged() { blocks.window() } else { needed };
    let mut film = picture.film(job, window);
    let wanted = Mask::all(window);
    let schedule = Schedule::of(job.sampling);
    picture.add_round(&Round { number: 0, schedule, wanted: &wanted }, &mut film, watch);
    picture.fill_holes(&mut film, watch);
    let estimates = if job.is_judged() {
        judge(&film, &blocks, completion(picture.convergence()), true).blocks
    } else {
        Vec::new()
    };
    let variances = estimates.iter().map(|block| block.variance).collect();
    Refined { film, blocks, variances, rounds: 1 }
}

/// Renders rounds until every block of the window reaches the goal, or its pixels have the maximum number of
/// samples.
///
/// Each round doubles the samples of its pixels; they judge those before.
pub(super) fn refine(picture: &impl Picture, job: &Job, goal: &Goal, watch: &Watch) -> Refined {
    let mut refinement = Refinement::new(picture, job, goal);
    let schedule = Schedule::of(job.sampling);
    loop {
        let wanted = refinement.wanted.clone();
        let round = schedule.round(refinement.rounds, &wanted).filter(|_| wanted.count() > 0);
        let Some(round) = round.filter(|_| !(watch.cancelled)()) else { break };
        refinement.render(&round, watch);
        let judgement = refinement.judge(&round);
        refinement.choose_blocks(&judgement);
        if round.is_last() {
            break;
        }
        refinement.choose_pixels(&judgement);
        refinement.foresee(&round, &judgement);
    }
    picture.fill_holes(&mut refinement.film, watch);
    let Refinement { film, blocks, variances, rounds, .. } = refinement;
    Refined { film, blocks, variances, rounds }
}

/// A picture between two rounds.
struct Refinement<'a, P> {
    picture: &'a P,
    goal: &'a Goal<'a>,
    film: Film,
    window_blocks: Blocks,
    /// Blocks of the window and their neighbours, whose first estimates decide with it whether a block at the
    /// window's rim goes on.
    blocks: Blocks,
    variances: Vec<f64>,
    goes_on: Vec<bool>,
    /// Pixels of the next round.
    wanted: Mask,
    rounds: u32,
    /// Whether some round had samples enough to judge by.
    was_judged: bool,
    /// Largest relative error of all blocks that go on.
    worst: Option<f64>,
    work: Work,
}

/// Estimates of a film.
struct Estimates {
    blocks: Vec<BlockEstimate>,
    /// Variance of each pixel of the film, NaN where it lacks two halves; empty after the last round.
    pixels: Vec<f32>,
    /// Greatest variance in each block of a pixel whose light few samples found, so that others may have
    /// missed theirs.
    of_few: Vec<f64>,
}

/// Estimates after a round, and the resulting decisions.
struct Judgement {
    estimates: Estimates,
    /// Ratio of the standard error of each block that goes on to its maximum.
    excess: Vec<f64>,
    /// Whether there are samples enough to decide.
    decides: bool,
    /// Whether no round before had enough.
    is_first: bool,
}

impl<'a, P: Picture> Refinement<'a, P> {
    fn new(picture: &'a P, job: &Job, goal: &'a Goal) -> Self {
        let window_blocks = Blocks::covering(job.needed_window(), job.size);
        let blocks = window_blocks.with_neighbours();
        Self {
            picture,
            goal,
            film: picture.film(job, blocks.window()),
            window_blocks,
            variances: vec![f64::INFINITY; blocks.count()],
            goes_on: vec![true; blocks.count()],
            wanted: Mask::all(blocks.window()),
            blocks,
            rounds: 0,
            was_judged: false,
            worst: None,
            work: Work::default(),
        }
    }

    fn render(&mut self, round: &Round, watch: &Watch) {
        let Self { picture, film, work, worst, .. } = self;
        film.let_fresh_be_known(round.wanted);
        let part = work.next(round.wanted.count() as f64 * f64::from(round.samples()));
        watch.part(part, *worst, |watch| picture.add_round(round, film, watch));
        self.rounds += 1;
    }

    fn judge(&mut self, round: &Round) -> Judgement {
        let Self { picture, goal, film, blocks, .. } = self;
        let estimates = judge(film, blocks, completion(picture.convergence()), round.is_last());
        let excess = |block: usize| {
            if self.goes_on[block] { goal.excess(&estimates.blocks[block], block) } else { 0.0 }
        };
        let excess: Vec<f64> = (0..blocks.count()).map(excess).collect();
        let samples = round.before() + round.samples();
        let decides = goal.tolerance >= LOOSE || samples >= picture.fewest_samples();
        self.worst = Some(goal.tolerance * excess.iter().copied().fold(0.0, f64::max));
        let is_first = !std::mem::replace(&mut self.was_judged, decides);
        Judgement { estimates, excess, decides, is_first }
    }

    /// A block goes on while it exceeds its goal. When first judged it also goes on if a neighbour exceeds
    /// it: an edge that one block missed by chance may show in the other.
    fn choose_blocks(&mut self, judgement: &Judgement) {
        for block in 0..self.blocks.count() {
            if !self.goes_on[block] {
                continue;
            }
            self.variances[block] = judgement.estimates.blocks[block].variance;
            let pixels = self.blocks.pixels(block);
            self.goes_on[block] = !judgement.decides
                || self.window_blocks.index(pixels.x, pixels.y).is_some()
                    && if judgement.is_first {
                        self.neighbourhood_exceeds(block, judgement)
                    } else {
                        judgement.excess[block] > 1.0
                    };
        }
    }

    fn neighbourhood_exceeds(&self, block: usize, judgement: &Judgement) -> bool {
        // The estimates of earlier components in a neighbouring block depend on its number of samples, so
        // this block's are used.
        let exceeds = |near: usize| self.goal.excess(&judgement.estimates.blocks[near], block) > 1.0;
        self.blocks.neighbourhood(block).any(exceeds)
    }

    /// A pixel goes on with its block unless it and its neighbours have a negligible part of the block's
    /// variance: a pixel that missed an edge by chance lies next to one that did not. Several pixels miss
    /// detail much narrower than a pixel, such as sunlight through a slit. So if few samples found light, the
    /// whole block goes on.
    fn choose_pixels(&mut self, judgement: &Judgement) {
        let Self { goal, film, blocks, goes_on, .. } = self;
        let negligible = |block: usize| NEGLIGIBLE * goal.variance(&judgement.estimates.blocks[block], block);
        let negligible: Vec<f64> = (0..blocks.count()).map(negligible).collect();
        let is_sparse = |block: usize| {
            let near = blocks.neighbourhood(block).filter(|&near| judgement.is_first || near == block);
            near.map(|near| judgement.estimates.of_few[near]).any(|variance| variance > negligible[block])
        };
        let is_sparse: Vec<bool> = (0..blocks.count()).map(is_sparse).collect();
        let variance = |(x, y)| {
            let variance = judgement.estimates.pixels[film.window().index(x, y)?];
            (!variance.is_nan()).then(|| f64::from(variance))
        };
        self.wanted = Mask::from_fn(blocks.window(), |x, y| {
            let Some(block) = blocks.index(x, y).filter(|&block| goes_on[block]) else { return false };
            let near = film.window().around(x, y);
            let near = near.filter(|&(x, y)| judgement.is_first || blocks.index(x, y) == Some(block));
            let greatest = near.filter_map(variance).reduce(f64::max).unwrap_or(f64::INFINITY);
            !judgement.decides || is_sparse[block] || greatest > negligible[block]
        });
    }

    /// Estimates the work that is left.
    fn foresee(&mut self, round: &Round, judgement: &Judgement) {
        let going_on = self.goes_on.iter().filter(|goes_on| **goes_on).count();
        let pixels_a_block = self.wanted.count() as f64 / going_on.max(1) as f64;
        let samples = round.before() + round.samples();
        let convergence = self.picture.convergence();
        self.work.left =
            pixels_a_block * samples_left(&judgement.excess, samples, self.goal.most, convergence);
    }
}

/// Factor from the difference of a pixel's halves to its variance.
///
/// The halves complement each other: slices of one lie between those of the other. If the error falls as
/// samples to the power -p, the variance of the whole is 4^-p of that of each half, A or B. Then (A + B) / 2
/// has the variance (A - B)^2 / 4 / (4^p - 1); independent halves have p = 1/2.
fn completion(convergence: f64) -> f64 {
    (4.0_f64.powf(convergence) - 1.0).recip()
}

/// Estimates of blocks from their pixels; after the last round no pixel is chosen by its own.
fn judge(film: &Film, blocks: &Blocks, completion: f64, is_last: bool) -> Estimates {
    let window = film.window();
    let pixels = if is_last { 0 } else { window.width * window.height };
    let mut variances = large_list(pixels);
    variances.resize(pixels, f32::NAN);
    let of_block = |block: usize| film.estimates(blocks.pixels(block), completion);
    let (mut estimates, mut of_few) =
        (Vec::with_capacity(blocks.count()), Vec::with_capacity(blocks.count()));
    // A few blocks at a time, as estimates of all pixels would be as large as the film.
    for first in (0..blocks.count()).step_by(JUDGED_AT_ONCE) {
        let some = first..blocks.count().min(first + JUDGED_AT_ONCE);
        for pixels in some.into_par_iter().map(of_block).collect::<Vec<_>>() {
            let mut greatest_of_few = 0.0_f64;
            for &((x, y), PixelEstimate { luminance, variance }) in &pixels {
                let (Some(index), Some(variance)) = (window.index(x, y), variance) else { continue };
                if let Some(kept) = variances.get_mut(index) {
                    *kept = variance as f32;
                }
                if variance > FOUND_BY_FEW * completion * luminance * luminance {
                    greatest_of_few = greatest_of_few.max(variance);
                }
            }
            estimates.push(BlockEstimate::of(pixels.iter().map(|&(_, estimate)| estimate)));
            of_few.push(greatest_of_few);
        }
    }
    Estimates { blocks: estimates, pixels: variances, of_few }
}

impl Goal<'_> {
    /// Standard error of a block over its maximum.
    fn excess(&self, estimate: &BlockEstimate, block: usize) -> f64 {
        if estimate.variance == 0.0 {
            0.0
        } else if estimate.variance == f64::INFINITY {
            1.0 / self.tolerance
        } else {
            (estimate.variance / self.variance(estimate, block)).sqrt()
        }
    }

    fn variance(&self, estimate: &BlockEstimate, block: usize) -> f64 {
        let Budget { share, share_so_far, before } = self.budget;
        // Errors of independent components add in squares.
        let none = BlockEstimate { luminance: 0.0, variance: 0.0, detail: 0.0 };
        let others = before.get(block).unwrap_or(&none);
        let luminance = visible(estimate.luminance + others.luminance, self.survey);
        let contrast = (estimate.detail + others.detail).sqrt() / luminance;
        let of_all = (unmasked(self.tolerance, contrast) * luminance).powi(2);
        (share_so_far * of_all - others.variance).max(share * of_all)
    }
}

/// Maximum relative error of a block with such a contrast: it is visible in fog and sky, and masked by
/// leaves.
fn unmasked(tolerance: f64, contrast: f64) -> f64 {
    (tolerance * (contrast / FOLIAGE).powf(MASKING)).max(SEEN).min(tolerance)
}

/// Estimated number of samples that blocks still take which have so many a pixel, in blocks times samples a
/// pixel.
fn samples_left(excess: &[f64], samples: u32, most: u32, convergence: f64) -> f64 {
    let samples = f64::from(samples);
    let wanted = |excess: &f64| (samples * excess.powf(1.0 / convergence)).min(f64::from(most)) - samples;
    excess.iter().filter(|excess| **excess > 1.0).map(wanted).sum()
}

/// Progress, in samples.
#[derive(Default)]
struct Work {
    done: f64,
    left: f64,
}

impl Work {
    /// Takes the next piece of the work; returns its range as fractions of all work.
    fn next(&mut self, piece: f64) -> (f64, f64) {
        // At first, all work is guessed to be three times the first piece.
        let left = if self.done == 0.0 { 3.0 * piece } else { self.left.max(piece) };
        let all = self.done + left;
        let start = self.done;
        (self.done, self.left) = (start + piece, left - piece);
        (start / all, self.done / all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_fog_shows_what_leaves_mask() {
        for contrast in [FOLIAGE, 1.0] {
            assert_eq!(unmasked(0.3, contrast), 0.3);
        }
        for contrast in [0.0, 1e-3, f64::NAN] {
            assert_eq!(unmasked(0.3, contrast), SEEN);
            assert_eq!(unmasked(0.005, contrast), 0.005);
        }
        let half = unmasked(0.3, FOLIAGE / 2.0);
        assert!(SEEN < half && half < 0.3, "{half}");
    }
}
