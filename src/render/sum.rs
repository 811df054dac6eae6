//! Pictures of single lights, added up and judged. In go their films, out come a frame and what it
//! took. Invariant: what is said of the frame's errors is said of the sum.

use super::grid_error::GridError;
use super::refine::{Refined, relative_error};
use super::survey::Survey;
use super::{Job, Rendered, Statistics};
use crate::color::{Rgb, luminance};
use crate::film::{BlockEstimate, Blocks, Channel, Film, Frame};
use crate::passes::{Pass, PassRow};
use crate::scene::Sampling;

/// The pictures so far.
#[derive(Default)]
pub(super) struct Sum {
    frame: Option<Frame>,
    blocks: Option<Blocks>,
    /// Block by block; those of independent pictures add.
    variances: Vec<f64>,
    pub(super) statistics: Statistics,
}

impl Sum {
    pub(super) fn add(&mut self, picture: Refined) {
        let Refined { film, blocks, variances, rounds } = picture;
        self.statistics.samples += film.weight() as u64;
        self.statistics.rounds = self.statistics.rounds.max(rounds);
        let resolved = film.resolve();
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

    /// The blocks so far; none before the first picture.
    pub(super) fn estimates(&self) -> Vec<BlockEstimate> {
        let (Some(frame), Some(blocks)) = (&self.frame, &self.blocks) else { return Vec::new() };
        let luminance = |block| mean_luminance(frame, blocks, block);
        let blocks = self.variances.iter().enumerate();
        blocks.map(|(block, &variance)| BlockEstimate { luminance: luminance(block), variance }).collect()
    }

    /// The pictures so far, added up.
    pub(super) fn frame(&self) -> Option<&Frame> {
        self.frame.as_ref()
    }

    pub(super) fn finish(mut self, job: &Job, survey: &Survey, grid: Option<&GridError>) -> Rendered {
        let mut frame =
            self.frame.take().unwrap_or_else(|| Film::new(job.size, job.window, &job.passes).resolve());
        let (Some(blocks), true) = (&self.blocks, job.is_judged()) else {
            return Rendered { frame, statistics: self.statistics };
        };
        if let Some(grid) = grid {
            grid.correction.apply(&mut frame);
        }
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
            // Noise and the grid's error know nothing of one another.
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
}

impl Sum {
    /// Root mean square of the standard error over some blocks, as a share of their mean; a block of which
    /// nothing is known errs by all of its light.
    fn noise(&self, frame: &Frame, blocks: &Blocks, of: impl Iterator<Item = usize>) -> f64 {
        let (mut squares, mut light, mut pixels) = (0.0, 0.0, 0.0);
        for block in of {
            let window = blocks.pixels(block);
            let (count, luminance) =
                ((window.width * window.height) as f64, mean_luminance(frame, blocks, block));
            let variance = self.variances[block];
            squares += count * if variance.is_finite() { variance } else { luminance * luminance };
            (light, pixels) = (light + count * luminance, pixels + count);
        }
        if light > 0.0 { (squares * pixels).sqrt() / light } else { 0.0 }
    }
}

fn mean_luminance(frame: &Frame, blocks: &Blocks, block: usize) -> f64 {
    let window = blocks.pixels(block);
    let channel = |name: &str, x: usize, y: usize| {
        let pixel = frame.window.index(x, y);
        pixel.zip(frame.channel(name)).map_or(0.0, |(pixel, channel)| f64::from(channel.pixels[pixel]))
    };
    let sum: f64 = window
        .pixels()
        .map(|(x, y)| luminance(Rgb::new(channel("R", x, y), channel("G", x, y), channel("B", x, y))))
        .sum();
    sum / (window.width * window.height) as f64
}
