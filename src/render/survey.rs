//! How bright the picture is, roughly, before any of it is rendered: what errors are measured
//! against where a block says too little of itself. In go a snapshot and a job, out come luminances.
//! Invariant: the whole picture is surveyed whatever part of it is wanted, so all parts agree.

use super::Job;
use crate::color::luminance;
use crate::math::Sampler;
use crate::scene::Size;
use crate::snapshot::Snapshot;
use crate::transport::{Scratch, radiance};
use rayon::prelude::*;

/// Rays across and down the picture: a hundredth and less of what the picture takes.
const CELLS: (usize, usize) = (16, 9);

/// Luminances of a coarse grid of rays.
pub(super) struct Survey {
    size: Size,
    /// Row by row.
    cells: Vec<f64>,
    /// Of the whole picture.
    pub(super) mean: f64,
}

impl Survey {
    /// Of a picture of which nobody wants to know.
    pub(super) fn omitted(size: Size) -> Self {
        Self { size, cells: vec![0.0; CELLS.0 * CELLS.1], mean: 0.0 }
    }

    pub(super) fn new(snapshot: &Snapshot, job: &Job) -> Self {
        let (columns, rows) = CELLS;
        let cells: Vec<f64> = (0..columns * rows)
            .into_par_iter()
            .map_init(Scratch::default, |scratch, cell| {
                let middle = |index: usize, count: usize| (index as f64 + 0.5) / count as f64;
                let ray = snapshot.view.ray(middle(cell % columns, columns), middle(cell / columns, rows));
                let mut sampler = Sampler::new(job.seed, cell as u32, 0, 0);
                let sample = radiance(snapshot, &job.transport, &ray, &mut sampler, scratch);
                luminance(sample.radiance)
            })
            .collect();
        let mean = cells.iter().sum::<f64>() / cells.len() as f64;
        Self { size: job.size, cells, mean }
    }

    /// Luminance around a pixel of the full picture.
    pub(super) fn around(&self, x: usize, y: usize) -> f64 {
        let (columns, rows) = CELLS;
        self.cells[y * rows / self.size.height * columns + x * columns / self.size.width]
    }
}
