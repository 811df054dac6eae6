//! Sum of a picture's components. In go their films, out come the frame and its statistics. Invariant: errors
//! that are reported are those of the sum.

use super::grid_error::GridError;
use super::refine::{Refined, relative_error};
use super::survey::Survey;
use super::{Job, Rendered, Statistics};
use crate::color::{Rgb, luminance};
use crate::film::{BlockEstimate, Blocks, Channel, Film, Frame};
use crate::passes::{Pass, PassRow};
use crate::scene::{Sampling, Window};

/// The components so far.
#[derive(Default)]
pub(super) struct Sum {
    frame: Option<Frame>,
    blocks: Option<Blocks>,
    /// Variances block by block; those of independent components add.
    variances: Vec<f64>,
    pub(super) statistics: Statistics,
}

impl Sum {
    pub(super) fn add(&mut self, picture: Refined) {
        let Refined { film, blocks, variances, rounds } = picture;
        self.statistics.samples += film.weight() as u64;
        self.statistics.rounds = self.statistics.rounds.max(rounds);
        let resolved = film.into_frame();
        match &mut self.frame {
            None => (self.frame, self.variances) = (Some(resolved), variances),
            Some(frame) => {
                frame.add_light(&resolved);
                for (sum, added) in self.variances.iter_mut().zip(variances) {
                    *sum += added;
                }
            }
        }
        self.blocks = Some(blocks);
    }

    /// The blocks so far; empty before the first component.
    pub(super) fn estimates(&self) -> Vec<BlockEstimate> {
        let (Some(frame), Some(blocks)) = (&self.frame, &self.blocks) else { return Vec::new() };
        let of_block =
            |(block, &variance)| BlockEstimate::new(luminances(frame, blocks.pixels(block)), variance);
        self.variances.iter().enumerate().map(of_block).collect()
    }

    /// The sum of the components so far.
    pub(super) fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    pub(super) fn finish(mut self, job: &Job, survey: &Survey, grid: Option<&GridError>) -> Rendered {
        let frame =
            self.frame.take().unwrap_or_else(|| Film::new(job.size, job.window, &job.passes).resolve());
        let (Some(blocks), true) = (&self.blocks, job.is_judged()) else {
            return Rendered { frame: frame.part(job.window), statistics: self.statistics };
        };
        let errors: Vec<f64> = (0..blocks.count())
            .map(|block| relative_error(self.variances[block], mean_luminance(&frame, blocks, block), survey))
            .collect();
        let within = Blocks::covering(job.window, job.size);
        let is_within = |&block: &usize| {
            let at = blocks.pixels(block);
            within.index(at.x, at.y).is_some()
        };
        let noise = self.noise(&frame, blocks, (0..blocks.count()).filter(is_within));
        let mut frame = frame.part(job.window);
        if job.passes.contains(&Pass::Error) {
            // Noise and the grid's error are independent.
            let all = |block: usize| {
                let of_grid = grid.map_or(0.0, |grid| grid.of_block(blocks, block, job));
                let light = mean_luminance(&frame, blocks, block);
                errors[block].hypot(relative_error(of_grid * of_grid, light, survey)) as f32
            };
            let all: Vec<f32> = (0..blocks.count()).map(all).collect();
            let pixels = job.window.pixels().map(|(x, y)| blocks.index(x, y).map_or(0.0, |block| all[block]));
            let PassRow { channels, precision, .. } = Pass::Error.row();
            frame.channels.push(Channel::new(channels[0], precision, pixels.collect()));
        }
        let judged = (0..blocks.count()).filter(is_within).map(|block| errors[block]);
        let statistics = &mut self.statistics;
        statistics.blocks = within.count();
        if let Sampling::Until { tolerance, .. } = job.sampling {
            statistics.unconverged_blocks = judged.clone().filter(|error| *error > tolerance).count();
        }
        statistics.error = Some(judged.fold(0.0, f64::max));
        statistics.noise = Some(noise);
        statistics.grid_error = grid.map(|grid| grid.relative);
        Rendered { frame, statistics: self.statistics }
    }

    /// Noise of some blocks; a block of unknown variance errs by all of its light.
    fn noise(&self, frame: &Frame, blocks: &Blocks, of: impl Iterator<Item = usize>) -> f64 {
        let block = |block: usize| {
            let window = blocks.pixels(block);
            let luminance = mean_luminance(frame, blocks, block);
            let known = Some(self.variances[block]).filter(|variance| variance.is_finite());
            let variance = known.unwrap_or(luminance * luminance);
            NoisyBlock { pixels: (window.width * window.height) as f64, luminance, variance }
        };
        noise(of.map(block).collect())
    }
}

/// A block of pixels with its luminance, W m^-2 sr^-1, and the variance of that.
#[derive(Clone, Copy)]
struct NoisyBlock {
    pixels: f64,
    luminance: f64,
    variance: f64,
}

/// Root mean square of the standard error over all blocks but the hundredth with most of it, as a share of
/// their mean luminance. A sun in the picture is a few pixels, and would dominate the mean.
fn noise(mut blocks: Vec<NoisyBlock>) -> f64 {
    const LEFT_OUT: usize = 100;
    blocks.sort_by(|a, b| a.variance.total_cmp(&b.variance));
    blocks.truncate(blocks.len() - blocks.len() / LEFT_OUT);
    let sum = |of: fn(&NoisyBlock) -> f64| blocks.iter().map(|block| block.pixels * of(block)).sum::<f64>();
    let (squares, light) = (sum(|block| block.variance), sum(|block| block.luminance));
    if light > 0.0 { (squares * sum(|_| 1.0)).sqrt() / light } else { 0.0 }
}

fn mean_luminance(frame: &Frame, blocks: &Blocks, block: usize) -> f64 {
    BlockEstimate::new(luminances(frame, blocks.pixels(block)), 0.0).luminance
}

/// Luminance of each pixel of a window of a frame, 0 outside it.
fn luminances(frame: &Frame, window: Window) -> impl Iterator<Item = f64> {
    let channels = ["R", "G", "B"].map(|name| frame.channel(name));
    window.pixels().map(move |(x, y)| {
        let of = |channel: Option<&Channel>| {
            frame
                .window
                .index(x, y)
                .zip(channel)
                .map_or(0.0, |(pixel, channel)| f64::from(channel.pixels[pixel]))
        };
        luminance(Rgb::from(channels.map(of)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sun_in_the_picture_is_not_its_noise() {
        let sky = NoisyBlock { pixels: 64.0, luminance: 1.0, variance: 4e-4 };
        let sun = NoisyBlock { luminance: 1e5, variance: 1e9, ..sky };
        assert!((noise(vec![sky; 50]) - 0.02).abs() < 1e-12);
        assert!((noise([vec![sky; 299], vec![sun; 3]].concat()) - 0.02).abs() < 1e-12);
        assert!(noise([vec![sky; 299], vec![sun; 4]].concat()) > 0.1);
    }
}
