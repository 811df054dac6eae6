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
    /// Which share of the variance that the picture may have is each light's, in the same order.
    pub(super) shares: Vec<f64>,
}

/// What of the variance all lights share evenly, however dark: a few rays may miss what a lamp lights.
const EVEN_SHARE: f64 = 0.1;

impl Survey {
    pub(super) fn new(snapshot: &Snapshot, job: &Job) -> Self {
        let by_light: Vec<f64> =
            (0..snapshot.lights.len()).map(|light| mean_luminance(snapshot, job, light)).collect();
        let mut lights: Vec<usize> = (0..by_light.len()).collect();
        lights.sort_by(|&a, &b| by_light[b].total_cmp(&by_light[a]));
        let mean: f64 = by_light.iter().sum();
        // A light's noise is in proportion to it, and falls with about the power 3/4 of its samples: then all lights
        // together take the fewest if variances are nearly as luminances.
        let even = 1.0 / lights.len() as f64;
        let by_brightness = |light: &usize| if mean > 0.0 { by_light[*light] / mean } else { even };
        let share = |light| EVEN_SHARE * even + (1.0 - EVEN_SHARE) * by_brightness(light);
        let shares = lights.iter().map(share).collect();
        Self { mean, lights, shares }
    }

    /// Of a picture that nobody judges.
    pub(super) fn omitted(snapshot: &Snapshot) -> Self {
        let count = snapshot.lights.len();
        Self { mean: 0.0, lights: (0..count).collect(), shares: vec![1.0 / count as f64; count] }
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
