//! Pixels one by one, in square tiles. Invariant: a pixel depends on its place and the seed alone.

use super::Job;
use crate::film::{Film, Frame};
use crate::math::Sampler;
use crate::scene::Window;
use crate::snapshot::Snapshot;
use crate::transport::{Scratch, radiance};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Tiles are small enough to keep all threads busy to the end, large enough to share cache lines.
const TILE: usize = 32;

/// See [`super::render`].
pub(super) fn render(
    snapshot: &Snapshot,
    job: &Job,
    progress: &(dyn Fn(f64) + Sync),
    cancelled: &AtomicBool,
) -> Frame {
    let tiles = tiles(job.window);
    let finished = AtomicUsize::new(0);
    let films: Vec<Film> = tiles
        .par_iter()
        .map_init(Scratch::default, |scratch, &tile| {
            let mut film = Film::new(job.size, tile, &job.passes);
            if !cancelled.load(Ordering::Relaxed) {
                render_tile(snapshot, job, tile, scratch, &mut film);
                progress((finished.fetch_add(1, Ordering::Relaxed) + 1) as f64 / tiles.len() as f64);
            }
            film
        })
        .collect();
    let mut whole = Film::new(job.size, job.window, &job.passes);
    for film in &films {
        whole.paste(film);
    }
    whole.resolve()
}

fn render_tile(snapshot: &Snapshot, job: &Job, tile: Window, scratch: &mut Scratch, film: &mut Film) {
    let (width, height) = (job.size.width as f64, job.size.height as f64);
    for y in tile.y..tile.y + tile.height {
        for x in tile.x..tile.x + tile.width {
            for sample in 0..job.samples {
                let mut sampler = Sampler::new(job.seed, x as u32, y as u32, sample);
                let (right, down) = if job.samples == 1 { (0.5, 0.5) } else { sampler.next_2d() };
                let ray = snapshot.view.ray((x as f64 + right) / width, (y as f64 + down) / height);
                let value = radiance(snapshot, &job.transport, &ray, &mut sampler, scratch);
                film.add(x, y, 1.0, (right - 0.5).hypot(down - 0.5), &value);
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
