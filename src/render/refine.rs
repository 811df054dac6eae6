//! Rounds until a picture is good enough. In goes a picture to be rendered in rounds, out comes its
//! film and what its blocks are still in error by. Invariant: whether a block or a pixel goes on depends on
//! its block's samples and on those with which the blocks next to it are first judged alone, so that a part of a picture has
//! the pixels of the whole.

use super::rounds::{Picture, Round};
use super::survey::Survey;
use super::{Job, Watch};
use crate::film::{BlockEstimate, Blocks, Film, Mask, PixelEstimate};

/// Blocks darker than this part of the picture's mean are judged as if they were that bright: nobody sees
/// their errors, and where there is hardly any light, relative errors have no end.
const DARKEST: f64 = 0.1;

/// A pixel with less than this part of the variance that its block may have, in itself and next to it, has
/// samples enough: most of a block's error is that of the few pixels in which edges lie.
const NEGLIGIBLE: f64 = 0.25;

/// How a block's error falls with the number of samples, as a power: by edges faster than the root.
pub(super) const ORDERED: f64 = 0.75;

/// The same where samples have draws of their own, and know little of one another.
pub(super) const DRAWN: f64 = 0.5;

/// Samples a pixel of the first round, at most: with 4 many blocks end by chance, with 16 too few could have ended before (docs/decisions/tolerance.md).
const FIRST_SAMPLES: u32 = 8;

/// The same with a tolerance of at least [`LOOSE`], for which 8 are mostly more than enough.
const FIRST_SAMPLES_LOOSE: u32 = 3;

/// See [`FIRST_SAMPLES_LOOSE`].
const LOOSE: f64 = 0.25;

/// A light's part of a picture, or all of it.
pub(super) struct Refined {
    pub(super) film: Film,
    /// The blocks that it covers, those around the window included.
    pub(super) blocks: Blocks,
    /// Of each of them, see [`BlockEstimate::variance`]; none if nobody judges.
    pub(super) variances: Vec<f64>,
    pub(super) rounds: u32,
}

/// When a block is good enough.
pub(super) struct Goal<'a> {
    /// Standard error of a block by its brightness, of all pictures together.
    pub(super) tolerance: f64,
    /// Samples a pixel at which to stop all the same.
    pub(super) most: u32,
    pub(super) survey: &'a Survey,
    pub(super) budget: &'a Budget,
}

/// What a picture may have of the variance of all that are added up.
pub(super) struct Budget {
    /// Its own share.
    pub(super) share: f64,
    /// That, and the shares of the pictures before it: what they have left is its own too.
    pub(super) share_so_far: f64,
    /// Their sum, block by block; none if there are none.
    pub(super) before: Vec<BlockEstimate>,
}

impl Budget {
    /// Of a picture that is all there is.
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

/// What a luminance counts as when errors are held against it.
fn visible(luminance: f64, survey: &Survey) -> f64 {
    luminance.max(DARKEST * survey.mean)
}

/// Renders exactly so many samples a pixel, as one round.
pub(super) fn once(picture: &impl Picture, job: &Job, samples: u32, watch: &Watch) -> Refined {
    let blocks = Blocks::covering(job.window, job.size);
    let window = if job.is_judged() { blocks.window() } else { job.window };
    let mut film = picture.film(job, window);
    let wanted = Mask::all(window);
    picture.add_round(&Round::only(samples, &wanted), &mut film, watch);
    picture.fill_holes(&mut film, watch);
    let estimates = if job.is_judged() {
        judge(&estimates(&film, picture.convergence()), &film, &blocks)
    } else {
        Vec::new()
    };
    let variances = estimates.iter().map(|block| block.variance).collect();
    Refined { film, blocks, variances, rounds: 1 }
}

/// Renders rounds until every block of the window reaches the goal, or its pixels have all the samples they may.
///
/// Each round doubles the samples of the pixels that take part in it, and its samples judge those before.
pub(super) fn refine(picture: &impl Picture, job: &Job, goal: &Goal, watch: &Watch) -> Refined {
    let window_blocks = Blocks::covering(job.window, job.size);
    // What they show when they are first judged tells whether a block at the window's rim goes on.
    let blocks = window_blocks.with_neighbours();
    let corner = |block: usize| {
        let pixels = blocks.pixels(block);
        (pixels.x, pixels.y)
    };
    let mut film = picture.film(job, blocks.window());
    let mut variances = vec![f64::INFINITY; blocks.count()];
    let mut goes_on = vec![true; blocks.count()];
    let mut mask = Mask::all(blocks.window());
    let (mut work, mut worst, mut rounds, mut was_judged) = (Work::default(), None, 0, false);
    for number in 0.. {
        let active = mask.count() as f64;
        let round = Round::of_doublings(number, goal.first_samples(), goal.most, &mask);
        let Some(round) = round.filter(|_| active > 0.0 && !(watch.cancelled)()) else { break };

        film.let_fresh_be_known(&mask);
        let part = work.next(active * f64::from(round.samples));
        watch.part(part, worst, |watch| picture.add_round(&round, &mut film, watch));
        rounds += 1;
        let samples = round.before() + round.samples;

        let pixels = estimates(&film, picture.convergence());
        let estimates = judge(&pixels, &film, &blocks);
        let excess = |block: usize| {
            if goes_on[block] { goal.excess(&estimates[block], block) } else { 0.0 }
        };
        let excess: Vec<f64> = (0..blocks.count()).map(excess).collect();
        let is_first_judged = !was_judged;
        was_judged = goal.tolerance >= LOOSE || samples >= picture.fewest_samples();
        for block in 0..blocks.count() {
            if !goes_on[block] {
                continue;
            }
            variances[block] = estimates[block].variance;
            let (x, y) = corner(block);
            // An edge that one block has missed by chance may show in the next. What pictures before know of that one depends on how far it went on, so this
            // block's own has to do.
            let exceeds = |near: usize| goal.excess(&estimates[near], block) > 1.0;
            let near_excess = is_first_judged && blocks.neighbourhood(block).any(exceeds);
            goes_on[block] = !was_judged
                || window_blocks.index(x, y).is_some()
                    && if is_first_judged { near_excess } else { excess[block] > 1.0 };
        }
        worst = Some(goal.tolerance * excess.iter().copied().fold(0.0, f64::max));
        // A pixel that has missed an edge by chance lies next to one that has not.
        mask = Mask::from_fn(blocks.window(), |x, y| {
            blocks.index(x, y).filter(|&block| goes_on[block]).is_some_and(|block| {
                let near = film.window().around(x, y);
                let near = near.filter(|&(x, y)| is_first_judged || blocks.index(x, y) == Some(block));
                let variances = near.filter_map(|(x, y)| pixels[film.window().index(x, y)?]?.variance);
                let greatest = variances.reduce(f64::max).unwrap_or(f64::INFINITY);
                !was_judged || greatest > NEGLIGIBLE * goal.variance(&estimates[block], block)
            })
        });
        let pixels_a_block =
            mask.count() as f64 / goes_on.iter().filter(|goes_on| **goes_on).count().max(1) as f64;
        work.left = pixels_a_block * samples_left(&excess, samples, goal.most, picture.convergence());
    }
    picture.fill_holes(&mut film, watch);
    Refined { film, blocks, variances, rounds }
}

/// What each pixel's samples say of it.
///
/// Its halves complete one another: slices of the one lie between those of the other. If the error falls as samples to the power -p, the whole varies by 4^-p of what
/// each half, A or B, does; then (A + B) / 2 varies by (A - B)^2 / 4 / (4^p - 1), where halves that know nothing of one another have p = 1/2.
fn estimates(film: &Film, convergence: f64) -> Vec<Option<PixelEstimate>> {
    let completion = (4.0_f64.powf(convergence) - 1.0).recip();
    let completed = |PixelEstimate { luminance, variance }| PixelEstimate {
        luminance,
        variance: variance.map(|variance| completion * variance),
    };
    film.estimates().into_iter().map(|estimate| estimate.map(completed)).collect()
}

/// What its pixels say of each block.
fn judge(pixels: &[Option<PixelEstimate>], film: &Film, blocks: &Blocks) -> Vec<BlockEstimate> {
    let known = |(x, y)| film.window().index(x, y).and_then(|pixel| pixels[pixel]);
    (0..blocks.count())
        .map(|block| BlockEstimate::of(blocks.pixels(block).pixels().filter_map(known)))
        .collect()
}

impl Goal<'_> {
    /// Samples a pixel of the first round; doubled some times they are the most that a pixel may have, or nearly.
    fn first_samples(&self) -> u32 {
        if self.tolerance >= LOOSE {
            return FIRST_SAMPLES_LOOSE;
        }
        self.most >> self.most.div_ceil(FIRST_SAMPLES).next_power_of_two().ilog2()
    }

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
        let (others, spent) = before.get(block).map_or((0.0, 0.0), |other| (other.luminance, other.variance));
        let of_all = (self.tolerance * visible(estimate.luminance + others, self.survey)).powi(2);
        (share_so_far * of_all - spent).max(share * of_all)
    }
}

/// How many more samples blocks are likely to take that have so many a pixel, in blocks times samples a pixel.
fn samples_left(excess: &[f64], samples: u32, most: u32, convergence: f64) -> f64 {
    let samples = f64::from(samples);
    let wanted = |excess: &f64| (samples * excess.powf(1.0 / convergence)).min(f64::from(most)) - samples;
    excess.iter().filter(|excess| **excess > 1.0).map(wanted).sum()
}

/// How much is done, for those who wait, in samples.
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
