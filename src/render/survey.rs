//! How bright the picture is, roughly, before any of it is rendered: what errors are measured
//! against where it is dark, and which light matters most. In go a snapshot and a job, out come luminances.
//! Invariant: the whole picture is surveyed whatever part of it is wanted, so all parts agree.

use super::Job;
use crate::color::luminance;
use crate::math::Sampler;
use crate::snapshot::Snapshot;
use crate::transport::{Scratch, radiance_of_light};
use rayon::prelude::*;

/// Rays across and down the picture, for each light: a hundredth and less of what the picture takes.
const RAYS: (usize, usize) = (16, 9);

/// What a coarse grid of rays finds.
pub(super) struct Survey {
    /// Mean luminance of the picture.
    pub(super) mean: f64,
    /// The lights by what they add to it, the brightest first.
    pub(super) lights: Vec<usize>,
}

impl Survey {
    pub(super) fn new(snapshot: &Snapshot, job: &Job) -> Self {
        let by_light: Vec<f64> =
            (0..snapshot.lights.len()).map(|light| mean_luminance(snapshot, job, light)).collect();
        let mut lights: Vec<usize> = (0..by_light.len()).collect();
        lights.sort_by(|&a, &b| by_light[b].total_cmp(&by_light[a]));
        Self { mean: by_light.iter().sum(), lights }
    }

    /// Of a picture that nobody judges.
    pub(super) fn omitted(snapshot: &Snapshot) -> Self {
        Self { mean: 0.0, lights: (0..snapshot.lights.len()).collect() }
    }
}

/// Mean over the picture of one light's part of it.
fn mean_luminance(snapshot: &Snapshot, job: &Job, light: usize) -> f64 {
    let (columns, rows) = RAYS;
    let luminances: Vec<f64> = (0..columns * rows)
        .into_par_iter()
        .map_init(Scratch::default, |scratch, ray| {
            let middle = |index: usize, count: usize| (index as f64 + 0.5) / count as f64;
            let number = ray as u32;
            let ray = snapshot.view.ray(middle(ray % columns, columns), middle(ray / columns, rows));
            let mut sampler = Sampler::new(job.seed, number, 0, 0);
            let own = light == 0;
            let transport = &job.transport;
            luminance(
                radiance_of_light(snapshot, transport, light, own, &ray, &mut sampler, scratch).radiance,
            )
        })
        .collect();
    luminances.iter().sum::<f64>() / luminances.len() as f64
}
