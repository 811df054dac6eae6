//! A component of the picture by rays, in square tiles. In go a job and a round, out come samples on a film.
//! Invariant: a pixel depends on its place and the seed alone.

use super::correction::Correction;
use super::refine::ORDERED;
use super::rounds::{Picture, Round};
use super::{Job, Light, Watch, camera_ray};
use crate::film::{Film, Splat, filter};
use crate::math::Sampler;
use crate::scene::{PixelFilter, Sampling, Window};
use crate::snapshot::Exposure;
use crate::transport::{Component, Scratch, Transport};
use glam::DVec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Tiles are small enough to keep all threads busy to the end, large enough to share cache lines.
const TILE: usize = 32;

/// A picture of one component, with a ray for each sample.
pub(super) struct RayPicture<'a, 'scene> {
    exposure: &'a Exposure<'scene>,
    job: &'a Job,
    transport: Transport<'a>,
    correction: Option<&'a Correction>,
    component: Component,
}

impl Picture for RayPicture<'_, '_> {
    fn film(&self, job: &Job, window: Window) -> Film {
        Film::new(job.size, window, &job.passes)
    }

    fn convergence(&self) -> f64 {
        ORDERED
    }

    /// Every pixel's rays have draws of their own.
    fn fewest_samples(&self) -> u32 {
        1
    }

    fn add_round(&self, round: &Round, film: &mut Film, watch: &Watch) {
        let tiles: Vec<Window> = tiles(film.window())
            .into_iter()
            .filter(|tile| tile.pixels().any(|(x, y)| round.wanted.contains(x, y)))
            .collect();
        let finished = AtomicUsize::new(0);
        // Tiles do not overlap, so that their order does not matter.
        let whole = Mutex::new(film);
        tiles.par_iter().for_each_init(Scratch::default, |scratch, &tile| {
            if (watch.cancelled)() {
                return;
            }
            let mut film = self.film(self.job, tile);
            self.render_tile(round, tile, scratch, &mut film, watch);
            whole.lock().unwrap_or_else(PoisonError::into_inner).paste(&film);
            watch.tell((finished.fetch_add(1, Ordering::Relaxed) + 1) as f64 / tiles.len() as f64);
        });
    }

    /// Does nothing: every pixel has samples of its own.
    fn fill_holes(&self, _: &mut Film, _: &Watch) {}
}

impl<'a, 'scene> RayPicture<'a, 'scene> {
    pub(super) fn new(
        exposure: &'a Exposure<'scene>,
        job: &'a Job,
        light: &Light<'a>,
        component: Component,
    ) -> Self {
        let (transport, correction) = (job.transport(light.indirect), light.correction());
        Self { exposure, job, transport, correction, component }
    }

    fn render_tile(
        &self,
        round: &Round,
        tile: Window,
        scratch: &mut Scratch,
        film: &mut Film,
        watch: &Watch,
    ) {
        let Self { exposure, job, ref transport, correction, component } = *self;
        for (x, y) in tile.pixels().filter(|&(x, y)| round.wanted.contains(x, y)) {
            if (watch.cancelled)() {
                return;
            }
            for number in 0..round.samples() {
                let mut sampler = Sampler::new(job.seed, x as u32, y as u32, round.before() + number);
                let from_centre = match (job.sampling, job.filter) {
                    (Sampling::Exactly(1), _) => DVec2::ZERO,
                    (_, PixelFilter::Box) => DVec2::from(sampler.next_2d()) - 0.5,
                    (_, PixelFilter::BlackmanHarris) => DVec2::from(sampler.next_2d()).map(filter::offset_px),
                };
                let film_px = DVec2::new(x as f64, y as f64) + 0.5 + from_centre;
                let (snapshot, ray) = camera_ray(exposure, job.size, film_px, &mut sampler);
                let mut value = transport.radiance_of(component, snapshot, &ray, &mut sampler, scratch);
                if let Some(correction) = correction {
                    correction.apply(&mut value, film_px);
                }
                let splat = Splat { pixel: (x, y), weight: 1.0, from_centre_px: from_centre.length() };
                // The sequence's first half is well distributed, and so is its second; its even points are
                // not.
                let is_fresh = !round.is_first() || 2 * number >= round.samples();
                if is_fresh { film.add_fresh(&splat, &value) } else { film.add(&splat, &value) }
            }
        }
    }
}

fn tiles(window: Window) -> Vec<Window> {
    let (right, bottom) = (window.x + window.width, window.y + window.height);
    let mut tiles = Vec::new();
    for y in (window.y..bottom).step_by(TILE) {
        for x in (window.x..right).step_by(TILE) {
            tiles.push(Window { x, y, width: TILE.min(right - x), height: TILE.min(bottom - y) });
        }
    }
    tiles
}
