//! By how much the grid of indirect light errs. In go a snapshot and a job, out come its indirect light and,
//! where errors are estimated, a picture of the difference to cells twice as wide. Invariant: it depends on
//! the whole picture, whatever part is wanted.

use super::{Job, Method};
use crate::color::{Rgb, luminance};
use crate::film::Blocks;
use crate::indirect::Indirect;
use crate::math::Sampler;
use crate::scene::{Bounces, Sampling};
use crate::snapshot::Snapshot;
use crate::transport::{Component, Scratch};
use rayon::prelude::*;

/// Parts of the picture across and down, and rays along each side of one.
const PARTS: (usize, usize) = (16, 9);
const RAYS: usize = 4;

/// Indirect light, and what is known of its error.
pub(super) struct Solved {
    pub(super) indirect: Option<Indirect>,
    pub(super) error: Option<GridError>,
}

/// By how much pictures by two grids differ, in parts of the picture, times [`SAFETY`].
pub(super) struct GridError {
    /// Luminances, part by part, in rows from the top.
    differences: Vec<f64>,
    /// Root mean square of them, as a share of the picture's mean.
    pub(super) relative: f64,
}

/// An error that falls with the first to the second power of the cells' side is 1 to 1/3 of the difference to
/// cells twice as wide; of only two grids three times that counts (Roache 1994, "Perspective: a method for
/// uniform reporting of grid refinement studies").
const SAFETY: f64 = 2.0;

impl Solved {
    /// Solves it, again on finer cells if that leaves more than the tolerance.
    pub(super) fn new(snapshot: &Snapshot, job: &Job, cancelled: &(dyn Fn() -> bool + Sync)) -> Self {
        let aspect = job.size.width as f64 / job.size.height as f64;
        let solve = |scale: f64| Indirect::on_cells(scale, snapshot, job.bounces, aspect, cancelled);
        let no_grid = job.bounces == Bounces::NONE || job.method == Method::Paths;
        let solve_if = |wanted: bool, scale: f64| if wanted { solve(scale) } else { None };
        // At once: each has stretches on its way that keep one core busy.
        let (indirect, coarse) =
            rayon::join(|| solve_if(!no_grid, 1.0), || solve_if(!no_grid && job.is_judged(), 2.0));
        let Some(mut indirect) = indirect else { return Self { indirect: None, error: None } };
        let mut error = coarse.map(|coarse| GridError::between(&coarse, &indirect, snapshot, job));
        if let (Some(known), Sampling::Until { tolerance, .. }) = (&error, job.sampling)
            && known.relative > tolerance
            && let Some(finer) = solve(0.5).filter(|finer| finer.cell_m() < indirect.cell_m())
        {
            error = Some(GridError::between(&indirect, &finer, snapshot, job));
            indirect = finer;
        }
        Self { indirect: Some(indirect), error }
    }
}

impl GridError {
    fn between(coarse: &Indirect, fine: &Indirect, snapshot: &Snapshot, job: &Job) -> Self {
        let (columns, rows) = PARTS;
        let parts: Vec<(f64, f64)> = (0..columns * rows)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, part| {
                let mut sums = [Rgb::ZERO; 2];
                for number in 0..RAYS * RAYS {
                    let place = |part: usize, step: usize, parts: usize| {
                        ((part * RAYS + step) as f64 + 0.5) / (parts * RAYS) as f64
                    };
                    let x = place(part % columns, number % RAYS, columns);
                    let y = place(part / columns, number / RAYS, rows);
                    let ray = snapshot.view.ray(x, y);
                    for (sum, indirect) in sums.iter_mut().zip([coarse, fine]) {
                        let transport = job.transport(Some(indirect));
                        // The same numbers for both: what else is in the picture is the same.
                        let mut sampler = Sampler::new(job.seed, (part * RAYS * RAYS + number) as u32, 0, 0);
                        let all = Component::All;
                        *sum += transport.radiance_of(all, snapshot, &ray, &mut sampler, scratch).radiance;
                    }
                }
                let [coarse, fine] = sums.map(|sum| sum / (RAYS * RAYS) as f64);
                (SAFETY * luminance((fine - coarse).abs()), luminance(fine))
            })
            .collect();
        let count = parts.len() as f64;
        let mean = parts.iter().map(|(_, light)| light).sum::<f64>() / count;
        let square = parts.iter().map(|(difference, _)| difference * difference).sum::<f64>() / count;
        let relative = if mean > 0.0 { square.sqrt() / mean } else { 0.0 };
        Self { differences: parts.into_iter().map(|(difference, _)| difference).collect(), relative }
    }

    /// Luminance by which a block of pixels may be wrong.
    pub(super) fn of_block(&self, blocks: &Blocks, block: usize, job: &Job) -> f64 {
        let window = blocks.pixels(block);
        let part = |middle: usize, size: usize, parts: usize| (middle * parts / size.max(1)).min(parts - 1);
        let column = part(window.x + window.width / 2, job.size.width, PARTS.0);
        let row = part(window.y + window.height / 2, job.size.height, PARTS.1);
        self.differences[column + PARTS.0 * row]
    }
}
