//! Rounds until a picture is good enough. In goes a picture to be rendered in rounds, out come its film and
//! the errors that its blocks still have. Invariant: a part of a picture has the pixels of the whole. Whether
//! a block or a pixel goes on depends on two things: its block's samples, and those by which the blocks
//! beside it are first judged alone.

use super::rounds::{LOOSE, Picture, Round, Schedule};
use super::survey::Survey;
use super::{Job, Watch};
use crate::film::{BlockEstimate, Blocks, Film, Mask};
use rayon::prelude::*;

/// Blocks darker than this part of the picture's mean are judged as if they were that bright: nobody sees
/// their errors, and where there is hardly any light, relative errors have no end.
const DARKEST: f64 = 0.1;

/// A pixel with less than this part of the variance that its block may have, in itself and next to it, has
/// samples enough: most of a block's error is that of the few pixels in which edges lie.
const NEGLIGIBLE: f64 = 0.25;

/// Error that shows in a block without contrast of its own.
const SEEN: f64 = 0.02;

/// Contrast of a block that masks as much as any tolerance allows: that of foliage.
const FOLIAGE: f64 = 0.2;

/// Power of the contrast by which the least contrast that one sees upon it grows (Legge & Foley 1980,
/// "Contrast masking in human vision").
const MASKING: f64 = 0.6;

/// Number of blocks that are judged at once.
const JUDGED_AT_ONCE: usize = 1024;

/// Power of the number of samples by which a block's error falls: with edges faster than by the root.
pub(super) const ORDERED: f64 = 0.75;

/// Power where samples have draws of their own, and know little of one another.
pub(super) const DRAWN: f64 = 0.5;

/// A light's part of a picture, or all of it.
pub(super) struct Refined {
    pub(super) film: Film,
    /// The blocks that it covers, those around the window included.
    pub(super) blocks: Blocks,
    /// Variance of each of them, see [`BlockEstimate::variance`]; none if nobody judges.
    pub(super) variances: Vec<f64>,
    pub(super) rounds: u32,
}

/// Goal at which a block is good enough.
pub(super) struct Goal<'a> {
    /// Standard error of a block by its brightness, of all pictures together.
    pub(super) tolerance: f64,
    /// Samples a pixel at which to stop all the same.
    pub(super) most: u32,
    pub(super) survey: &'a Survey,
    pub(super) budget: &'a Budget,
}

/// Budget of a picture: its part of the variance of all that are added up.
pub(super) struct Budget {
    /// Share of its own.
    pub(super) share: f64,
    /// Sum of that and the shares of the pictures before it: what they have left is its own too.
    pub(super) share_so_far: f64,
    /// Their sum, block by block; none if there are none.
    pub(super) before: Vec<BlockEstimate>,
}

impl Budget {
    /// Budget of a picture that is all there is.
    pub(super) const WHOLE: Self = Self { share: 1.0, share_so_far: 1.0, before: Vec::new() };
}

/// A block's standard error by its brightness; 1 where nothing is known of it.
pub(super) fn relative_error(variance: f64, luminance: f64, survey: &Survey) -> f64 {
    if variance == 0.0 {
        // Also where there is no light at all.
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

/// Renders exactly so many samples a pixel, as one round.
pub(super) fn once(picture: &impl Picture, job: &Job, watch: &Watch) -> Refined {
    let needed = job.needed_window();
    let blocks = Blocks::covering(needed, job.size);
    let window = if job.is_judged() { blocks.window() } else { needed };
    let mut film = picture.film(job, window);
    let wanted = Mask::all(window);
    let schedule = Schedule::of(job.sampling);
    picture.add_round(&Round { number: 0, schedule, wanted: &wanted }, &mut film, watch);
    picture.fill_holes(&mut film, watch);
    let estimates =
        if job.is_judged() { judge(&film, &blocks, completion(picture.convergence())).0 } else { Vec::new() };
    let variances = estimates.iter().map(|block| block.variance).collect();
    Refined { film, blocks, variances, rounds: 1 }
}

/// Renders rounds until every block of the window reaches the goal, or its pixels have all
/// the samples they may.
///
/// Each round doubles the samples of the pixels that take part in it, and its samples judge those before.
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
    /// Blocks of the window, and the ones around: their first estimates tell whether a block at the
    /// window's rim goes on.
    blocks: Blocks,
    variances: Vec<f64>,
    goes_on: Vec<bool>,
    /// The pixels that the next round is for.
    wanted: Mask,
    rounds: u32,
    /// Whether some round has had samples enough to judge by.
    was_judged: bool,
    /// The largest relative error of all blocks that go on.
    worst: Option<f64>,
    work: Work,
}

/// Estimates after a round, and what they ask for.
struct Judgement {
    /// Variance of each pixel of the film; NaN where it has not two halves.
    variances: Vec<f32>,
    blocks: Vec<BlockEstimate>,
    /// The standard error of each block that goes on, by what it may be.
    excess: Vec<f64>,
    /// Whether there are samples enough to decide by.
    decides: bool,
    /// Whether no round has decided before.
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
        let (estimates, variances) = judge(film, blocks, completion(picture.convergence()));
        let excess = |block: usize| {
            if self.goes_on[block] { goal.excess(&estimates[block], block) } else { 0.0 }
        };
        let excess: Vec<f64> = (0..blocks.count()).map(excess).collect();
        let samples = round.before() + round.samples();
        let decides = goal.tolerance >= LOOSE || samples >= picture.fewest_samples();
        self.worst = Some(goal.tolerance * excess.iter().copied().fold(0.0, f64::max));
        let is_first = !std::mem::replace(&mut self.was_judged, decides);
        Judgement { variances, blocks: estimates, excess, decides, is_first }
    }

    /// A block goes on while it exceeds its goal. When first judged it also goes on if one next to it does:
    /// an edge that the one has missed by chance may show in the other.
    fn choose_blocks(&mut self, judgement: &Judgement) {
        for block in 0..self.blocks.count() {
            if !self.goes_on[block] {
                continue;
            }
            self.variances[block] = judgement.blocks[block].variance;
            self.goes_on[block] = !judgement.decides
                || self.is_in_window(block)
                    && if judgement.is_first {
                        self.neighbourhood_exceeds(block, judgement)
                    } else {
                        judgement.excess[block] > 1.0
                    };
        }
    }

    fn is_in_window(&self, block: usize) -> bool {
        let pixels = self.blocks.pixels(block);
        self.window_blocks.index(pixels.x, pixels.y).is_some()
    }

    fn neighbourhood_exceeds(&self, block: usize, judgement: &Judgement) -> bool {
        // What pictures before know of a block next to it depends on how far it went on, so this
        // block's own has to do.
        let exceeds = |near: usize| self.goal.excess(&judgement.blocks[near], block) > 1.0;
        self.blocks.neighbourhood(block).any(exceeds)
    }

    /// A pixel goes on with its block unless it and those next to it have hardly any of the block's variance:
    /// one that has missed an edge by chance lies next to one that has not.
    fn choose_pixels(&mut self, judgement: &Judgement) {
        let Self { goal, film, blocks, goes_on, .. } = self;
        let negligible = |block: usize| NEGLIGIBLE * goal.variance(&judgement.blocks[block], block);
        let negligible: Vec<f64> = (0..blocks.count()).map(negligible).collect();
        let variance = |(x, y)| {
            let variance = judgement.variances[film.window().index(x, y)?];
            (!variance.is_nan()).then(|| f64::from(variance))
        };
        self.wanted = Mask::from_fn(blocks.window(), |x, y| {
            let Some(block) = blocks.index(x, y).filter(|&block| goes_on[block]) else { return false };
            let near = film.window().around(x, y);
            let near = near.filter(|&(x, y)| judgement.is_first || blocks.index(x, y) == Some(block));
            let greatest = near.filter_map(variance).reduce(f64::max).unwrap_or(f64::INFINITY);
            !judgement.decides || greatest > negligible[block]
        });
    }

    /// Foresees the work that is left.
    fn foresee(&mut self, round: &Round, judgement: &Judgement) {
        let going_on = self.goes_on.iter().filter(|goes_on| **goes_on).count();
        let pixels_a_block = self.wanted.count() as f64 / going_on.max(1) as f64;
        let samples = round.before() + round.samples();
        let convergence = self.picture.convergence();
        self.work.left =
            pixels_a_block * samples_left(&judgement.excess, samples, self.goal.most, convergence);
    }
}

/// Factor on what halves of a pixel's samples say of its variance.
///
/// The halves complete one another: slices of the one lie between those of the other. If the error falls
/// as samples to the power -p, the whole varies by 4^-p of what each half, A or B, does; then (A + B) / 2
/// varies by (A - B)^2 / 4 / (4^p - 1), where halves that know nothing of one another have p = 1/2.
fn completion(convergence: f64) -> f64 {
    (4.0_f64.powf(convergence) - 1.0).recip()
}

/// Estimate of each block by its pixels, and the variance of each pixel of the film, NaN where it has not two
/// halves.
fn judge(film: &Film, blocks: &Blocks, completion: f64) -> (Vec<BlockEstimate>, Vec<f32>) {
    let window = film.window();
    let mut variances = vec![f32::NAN; window.width * window.height];
    let of_block = |block: usize| film.estimates(blocks.pixels(block), completion);
    let mut estimates = Vec::with_capacity(blocks.count());
    // A few at a time, as estimates of all pixels would be as much as the film.
    for first in (0..blocks.count()).step_by(JUDGED_AT_ONCE) {
        let some = first..blocks.count().min(first + JUDGED_AT_ONCE);
        for pixels in some.into_par_iter().map(of_block).collect::<Vec<_>>() {
            for &((x, y), estimate) in &pixels {
                if let (Some(index), Some(variance)) = (window.index(x, y), estimate.variance) {
                    variances[index] = variance as f32;
                }
            }
            estimates.push(BlockEstimate::of(pixels.iter().map(|&(_, estimate)| estimate)));
        }
    }
    (estimates, variances)
}

impl Goal<'_> {
    /// The standard error of a block, by what it may be.
    fn excess(&self, estimate: &BlockEstimate, block: usize) -> f64 {
        if estimate.variance == 0.0 {
            0.0
        } else if estimate.variance == f64::INFINITY {
            1.0 / self.tolerance
        } else {
            (estimate.variance / self.variance(estimate, block)).sqrt()
        }
    }

    /// The variance that a block may have.
    fn variance(&self, estimate: &BlockEstimate, block: usize) -> f64 {
        let Budget { share, share_so_far, before } = self.budget;
        // Errors of independent pictures add in squares.
        let none = BlockEstimate { luminance: 0.0, variance: 0.0, detail: 0.0 };
        let others = before.get(block).unwrap_or(&none);
        let luminance = visible(estimate.luminance + others.luminance, self.survey);
        let contrast = (estimate.detail + others.detail).sqrt() / luminance;
        let of_all = (unmasked(self.tolerance, contrast) * luminance).powi(2);
        (share_so_far * of_all - others.variance).max(share * of_all)
    }
}

/// Error that a block of such a contrast may have: fog and sky show what leaves mask.
fn unmasked(tolerance: f64, contrast: f64) -> f64 {
    (tolerance * (contrast / FOLIAGE).powf(MASKING)).max(SEEN).min(tolerance)
}

/// Estimated samples that blocks with so many a pixel still take, in blocks times samples a pixel.
fn samples_left(excess: &[f64], samples: u32, most: u32, convergence: f64) -> f64 {
    let samples = f64::from(samples);
    let wanted = |excess: &f64| (samples * excess.powf(1.0 / convergence)).min(f64::from(most)) - samples;
    excess.iter().filter(|excess| **excess > 1.0).map(wanted).sum()
}

/// Progress for those who wait, in samples.
#[derive(Default)]
struct Work {
    done: f64,
    left: f64,
}

impl Work {
    /// Takes the next piece of the work; which part of all of it that is.
    fn next(&mut self, piece: f64) -> (f64, f64) {
        // Before anything is known, the first piece is a guess at a third of it.
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
