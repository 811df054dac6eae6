//! Pictures from slices: for each light lattices of its slices. Invariant: samples reach
//! the film in the order of their slices, whatever thread solved them, and weigh as much as the area of the pixel that they stand for, so
//! a pixel is the mean over what its slices see of it.

use super::draws::{Draw, Draws};
use super::lattice::{Differing, Lattice};
use super::refine::{DRAWN, ORDERED};
use super::rings::Rings;
use super::rounds::{Picture, Round};
use super::shares::{PlacedPiece, Shares};
use super::{Job, Watch, camera_ray};
use crate::film::{Film, Splats};
use crate::math::Sampler;
use crate::scattering::LightPlace;
use crate::scene::{PixelFilter, Window};
use crate::snapshot::Exposure;
use crate::transport::slices::{Fan, Outline, Piece, Slice, SliceJob, SliceScratch, count_segments, solve};
use crate::transport::{Component, Sample, Scratch, radiance_of_component};
use glam::DVec2;
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Slices that a thread solves before its samples go to the film: enough for threads to end together, few enough for the caches.
const BATCH_PER_THREAD: usize = 16;

/// Samples a pixel before those of slices with draws of their own are judged: a few points of a light throw a few shadows, each as sharp as if there were
/// no half shadow, and between those all halves agree (docs/decisions/tolerance.md).
const FEWEST_DRAWN_SAMPLES: u32 = 16;

/// The component of one light, in rounds of a lattice each.
pub(super) struct LightPicture<'a> {
    pub(super) exposure: &'a Exposure<'a>,
    pub(super) job: &'a Job,
    /// The light, as its index in the snapshot.
    pub(super) light: usize,
    pub(super) tally: &'a Tally,
    /// As its first round has chosen them.
    pub(super) rings: OnceLock<Rings>,
}

/// What the slices of a picture took, whichever thread solved them.
#[derive(Default)]
pub(super) struct Tally {
    slices: AtomicU64,
    segments: AtomicU64,
}

impl Tally {
    fn add(&self, segments: usize) {
        self.slices.fetch_add(1, Ordering::Relaxed);
        self.segments.fetch_add(segments as u64, Ordering::Relaxed);
    }

    /// Slices and their segments.
    pub(super) fn totals(&self) -> (u64, u64) {
        (self.slices.load(Ordering::Relaxed), self.segments.load(Ordering::Relaxed))
    }
}

impl Picture for LightPicture<'_> {
    fn film(&self, job: &Job, window: Window) -> Film {
        let has_hues = self.exposure.middle().lights[self.light].has_hues();
        let new = if has_hues { Film::with_hues } else { Film::new };
        new(job.size, window, &job.passes)
    }

    fn convergence(&self) -> f64 {
        let are_ordered = self.rings.get().is_some_and(|rings| rings.are_ordered);
        if are_ordered && self.exposure.is_instant() { ORDERED } else { DRAWN }
    }

    fn fewest_samples(&self) -> u32 {
        if self.convergence() == ORDERED { 1 } else { FEWEST_DRAWN_SAMPLES }
    }

    fn add_round(&self, round: &Round, film: &mut Film, watch: &Watch) {
        add_round(self, round, film, watch);
    }

    /// A ray of its own, through the pixel's centre.
    fn fill_holes(&self, film: &mut Film, watch: &Watch) {
        let Self { exposure, job, light, .. } = *self;
        let mut scratch = Scratch::default();
        for (x, y) in film.holes() {
            if (watch.cancelled)() {
                break;
            }
            let mut sampler = Sampler::new(job.seed, x as u32, y as u32, 0);
            let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let (snapshot, ray) = camera_ray(exposure, job.size, centre, &mut sampler);
            let value = radiance_of_component(
                Component::Light(light),
                snapshot,
                &job.transport,
                &ray,
                &mut sampler,
                &mut scratch,
            );
            film.add(x, y, 1.0, 0.0, &value);
        }
    }
}

/// Adds a round's samples to the film.
fn add_round(picture: &LightPicture, round: &Round, film: &mut Film, watch: &Watch) {
    let LightPicture { exposure, job, light, tally, ref rings } = *picture;
    let mut sampler = Sampler::new(job.seed, light as u32, 0, 0);
    let draws = Draws::new(exposure, light, job.seed);
    let fan_of = |draw: &Draw| Fan::new(&draw.snapshot.view, job.size, draw.lens_point, draw.light.place());
    let Some(base) = fan_of(&draws.middle()) else { return };
    let wanders = draws.probes().filter_map(|draw| fan_of(&draw)).map(|own| base.wander(&own));
    let differing = (!draws.is_single()).then(|| Differing {
        deviation_rad: wanders.fold(0.0, f64::max),
        in_time: !exposure.is_instant(),
        in_brightness: matches!(draws.middle().light.place(), LightPlace::At(_)),
    });
    let segments = |slice: &Slice| count_segments(exposure.middle(), &base, slice);
    let seen = round.seen(job.size, job.filter);
    let lattice = Lattice::new(&base, differing, round, &seen, &segments, rings, || sampler.next_2d());
    let count = lattice.count();

    // Kept from batch to batch: giving so much memory back and asking for it again costs a tenth of the time.
    let batch = BATCH_PER_THREAD * rayon::current_num_threads();
    let mut solved: Vec<Splats> = vec![film.splats(); batch];
    for first in (0..count).step_by(batch) {
        if (watch.cancelled)() {
            break;
        }
        solved.par_iter_mut().enumerate().for_each_init(
            || (SliceScratch::default(), Outline::default(), Vec::new()),
            |(scratch, outline, pieces), (index, samples)| {
                let number = first + index;
                // Of a lattice's rows every other one is a lattice too; what nobody judges has no halves.
                samples.start(job.is_judged() && (!round.is_first() || lattice.row(number) % 2 == 1));
                if !lattice.is_wanted(number) || (watch.cancelled)() {
                    return;
                }
                let draw = draws.get(lattice.draw(number));
                let Some(own) = fan_of(&draw) else { return };
                let Some(placed) = lattice.slice(&base, &own, number) else { return };
                let slice_job = SliceJob {
                    snapshot: draw.snapshot,
                    transport: &job.transport,
                    light: &draw.light,
                    hue: draw.hue,
                    self_luminous: light == 0,
                    fan: &own,
                };
                let shares = Shares { round, size: job.size, placed: &placed };
                let chords = placed.chords(job.size, &seen);
                pieces.clear();
                let has_outline = placed.has_swath() && job.filter == PixelFilter::Box;
                let add = |piece: &Piece, value: &Sample| {
                    let sample = samples.keep(value);
                    match job.filter {
                        PixelFilter::Box if has_outline => pieces.push(PlacedPiece::new(piece, sample)),
                        PixelFilter::Box => samples.add(sample, &shares.by_chord(piece)),
                        PixelFilter::BlackmanHarris => {
                            shares.by_window(piece).for_each(|splat| samples.add(sample, &splat));
                        }
                    }
                };
                outline.start(round.region_side());
                let outlined = has_outline.then_some(&mut *outline);
                if let Some(segments) = solve(&slice_job, &placed.slice, chords, outlined, scratch, add) {
                    tally.add(segments);
                    if has_outline {
                        shares.by_swath(&own, pieces, outline, |sample, splat| samples.add(sample, splat));
                    }
                }
            },
        );
        film.add_all(&solved);
        watch.tell(count.min(first + batch) as f64 / count as f64);
    }
}
