//! Pictures from slices: for each light lattices of samples on its slices. Invariant: samples reach the film in the order of their slices, whatever thread solved them.
//!
//! The lattice: slices at equal angles, and on each slice samples at equal steps of picture area,
//! shifted from slice to slice by the golden ratio (a rank-1 lattice). Every sample stands for the
//! same area, so a pixel is the plain mean of its samples.

use super::passes::{Fresh, Pass, Picture};
use super::{Job, Watch};
use crate::film::Film;
use crate::math::Sampler;
use crate::snapshot::{FrozenLight, Luminaire, Snapshot};
use crate::transport::slices::{Fan, Ring, Slice, SliceJob, SliceSample, SliceScratch, solve};
use crate::transport::{Scratch, radiance_of_light};
use glam::DVec2;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Slices solved before their samples go to the film: enough for all threads, few enough for memory.
const BATCH: usize = 128;

/// The golden ratio less one: neighbouring slices' samples are shifted by it (Korobov's lattice in two dimensions).
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Whether slices can render a frame: there must be a light for each picture, none of them with an
/// extent and none at the eye.
pub(super) fn can_serve(snapshot: &Snapshot) -> bool {
    let has_slices = |light: &Luminaire| match light.centre() {
        FrozenLight::Sun { .. } => light.is_delta(),
        FrozenLight::Point { position, .. } => light.is_delta() && position.length_squared() > 0.0,
    };
    !snapshot.lights.is_empty() && snapshot.lights.iter().all(has_slices)
}

/// One light's part of a picture, in passes of a lattice each.
///
/// A pass shifts its lattice, across and along the slices, by a point of a sequence whose first 2 and 4 points are
/// evenly spread (Owen-scrambled Sobol): so many passes together are almost as good as one fine lattice.
pub(super) struct LightPicture<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) job: &'a Job,
    /// The light, as its index in the snapshot.
    pub(super) light: usize,
}

impl Picture for LightPicture<'_> {
    fn add_pass(&self, pass: &Pass, film: &mut Film, watch: &Watch) {
        add_pass(self, pass, film, watch);
    }

    /// A ray of its own, through the pixel's centre.
    fn fill_holes(&self, film: &mut Film, watch: &Watch) {
        let Self { snapshot, job, light } = *self;
        let mut scratch = Scratch::default();
        for (x, y) in film.holes() {
            if (watch.cancelled)() {
                break;
            }
            let (width, height) = (job.size.width as f64, job.size.height as f64);
            let ray = snapshot.view.ray((x as f64 + 0.5) / width, (y as f64 + 0.5) / height);
            let mut sampler = Sampler::new(job.seed, x as u32, y as u32, 0);
            let own = light == 0;
            let value =
                radiance_of_light(snapshot, &job.transport, light, own, &ray, &mut sampler, &mut scratch);
            film.add(x, y, 1.0, 0.0, &value);
        }
    }
}

/// Adds a pass's samples to the film.
fn add_pass(picture: &LightPicture, pass: &Pass, film: &mut Film, watch: &Watch) {
    let LightPicture { snapshot, job, light } = *picture;
    let centre = snapshot.lights[light].centre();
    let Some(fan) = Fan::new(&snapshot.view, job.size, DVec2::ZERO, centre.source()) else {
        return;
    };
    let (shift_across, shift_along) = Sampler::new(job.seed, light as u32, pass.level, pass.number).next_2d();
    // As many slices across as samples along: the lattice's cells are square on average.
    let density = f64::from(pass.samples);
    let wanted_rad = 1.0 / (density.sqrt() * fan.mean_separation_px(Ring::WHOLE));
    let count = (fan.angles.1 / wanted_rad).ceil().max(1.0);
    let step_rad = fan.angles.1 / count;
    // The cell of the slice before the first reaches into the window, unless that is the last one again.
    let count = count as usize + usize::from(fan.angles.1 < TAU);
    let step_area = 1.0 / (density * step_rad);
    let slice_job = SliceJob {
        snapshot,
        transport: &job.transport,
        light: &centre,
        self_luminous: light == 0,
        fan: &fan,
        size: job.size,
        wanted: &|x, y| pass.wanted.contains(x, y),
    };

    // Kept from batch to batch: giving so much memory back and asking for it again costs a tenth of the time.
    let mut solved: Vec<Vec<SliceSample>> = vec![Vec::new(); BATCH];
    for first in (0..count).step_by(BATCH) {
        if (watch.cancelled)() {
            break;
        }
        solved.par_iter_mut().enumerate().for_each_init(
            SliceScratch::default,
            |scratch, (index, samples)| {
                samples.clear();
                let number = first + index;
                let angle = fan.angles.0 + (number as f64 - 1.0 + shift_across) * step_rad;
                let slice = if number < count { fan.slice(angle, Ring::WHOLE) } else { None };
                if let Some(slice) = slice {
                    let shift = (shift_along + GOLDEN * number as f64).fract();
                    let areas = lattice(&slice, shift, step_area);
                    solve(&slice_job, &slice, areas, scratch, |sample| samples.push(sample));
                }
            },
        );
        for (index, samples) in solved.iter().enumerate() {
            // Of a lattice's slices every other one is a lattice too.
            let is_fresh = pass.fresh == Fresh::All || (first + index) % 2 == 1;
            for sample in samples {
                let (x, y) = sample.place.pixel(job.size);
                let from_centre = sample.place.film_px - DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                if is_fresh {
                    film.add_fresh(x, y, 1.0, from_centre.length(), &sample.value);
                } else {
                    film.add(x, y, 1.0, from_centre.length(), &sample.value);
                }
            }
        }
        watch.tell(count.min(first + BATCH) as f64 / count as f64);
    }
}

fn lattice(slice: &Slice, shift: f64, step_area: f64) -> impl Iterator<Item = f64> + use<> {
    let count = (slice.area_per_rad / step_area - shift).ceil().max(0.0) as usize;
    (0..count).map(move |index| (index as f64 + shift) * step_area)
}
