//! Survey of a picture's brightness, before rendering: the scale of errors in dark places, and the order of
//! components. In go a snapshot and a job, out come luminances. Invariant: the whole picture is surveyed for
//! any wanted part, so all crops agree.

use super::Job;
use crate::color::luminance;
use crate::indirect::Indirect;
use crate::math::Sampler;
use crate::snapshot::Snapshot;
use crate::transport::{Component, Scratch};
use rayon::prelude::*;

/// Rays across and down the picture, for each component: at most a hundredth of the picture's time.
const RAYS: (usize, usize) = (16, 9);

/// Brightness of a picture, by a coarse grid of rays.
pub(super) struct Survey {
    /// Mean luminance of the picture.
    pub(super) mean: f64,
    /// Mean luminance without indirect light.
    pub(super) direct: f64,
    /// Components by their luminance, the brightest first.
    pub(super) components: Vec<Component>,
    /// Share of each component in the picture's variance, in the same order.
    pub(super) shares: Vec<f64>,
}

/// Part of the variance that all components share equally, however dark: a few rays may miss the places that
/// a lamp lights.
const EVEN_SHARE: f64 = 0.1;

impl Survey {
    pub(super) fn new(
        snapshot: &Snapshot,
        job: &Job,
        indirect: Option<&Indirect>,
        components: Vec<Component>,
    ) -> Self {
        let mut direct = 0.0;
        let with_luminance = |component| {
            let [all, of_indirect] = mean_luminances(snapshot, job, indirect, component);
            direct += all - of_indirect;
            (component, all)
        };
        let mut by_brightness: Vec<(Component, f64)> = components.into_iter().map(with_luminance).collect();
        by_brightness.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mean: f64 = by_brightness.iter().map(|(_, luminance)| luminance).sum();
        // A component's noise is in proportion to its luminance, and falls with about the power 3/4 of its
        // samples. Then the fewest samples are needed if variances are nearly proportional to luminances.
        let even = 1.0 / by_brightness.len() as f64;
        let proportion = |luminance: f64| if mean > 0.0 { luminance / mean } else { even };
        let share = |luminance| EVEN_SHARE * even + (1.0 - EVEN_SHARE) * proportion(luminance);
        let (components, shares) =
            by_brightness.into_iter().map(|(component, luminance)| (component, share(luminance))).unzip();
        Self { mean, direct, components, shares }
    }

    /// Survey of a picture whose errors are not judged.
    pub(super) fn omitted(components: Vec<Component>) -> Self {
        let count = components.len();
        Self { mean: 0.0, direct: 0.0, components, shares: vec![1.0 / count as f64; count] }
    }
}

/// Mean luminance of a component over the picture, and of indirect light in it. Rays to a sun or lamp are
/// left out, if there are others: it is a thousand times as bright as all else, and among these few rays it
/// would make the whole picture count as dark.
fn mean_luminances(
    snapshot: &Snapshot,
    job: &Job,
    indirect: Option<&Indirect>,
    component: Component,
) -> [f64; 2] {
    let transport = job.transport(indirect);
    let (columns, rows) = RAYS;
    let middle = |index: usize, count: usize| (index as f64 + 0.5) / count as f64;
    let rays = (0..columns * rows).map(|number| {
        let ray = snapshot.view.ray(middle(number % columns, columns), middle(number / columns, rows));
        (number as u32, ray)
    });
    let (mut rays, into_suns): (Vec<_>, Vec<_>) = rays.partition(|(_, ray)| !snapshot.sees_light(ray));
    if rays.is_empty() {
        rays = into_suns;
    }
    let luminances: Vec<[f64; 2]> = rays
        .par_iter()
        .map_init(Scratch::default, |scratch, (number, ray)| {
            let mut sampler = Sampler::new(job.seed, *number, 0, 0);
            let sample = transport.radiance_of(component, snapshot, ray, &mut sampler, scratch);
            [sample.radiance, sample.indirect + sample.indirect_shafts].map(luminance)
        })
        .collect();
    [0, 1].map(|part| luminances.iter().map(|parts| parts[part]).sum::<f64>() / luminances.len() as f64)
}
