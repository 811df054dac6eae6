//! The component of one light, from slices. In go a picture's lattice and a round, out come samples on a
//! film. Invariants: samples reach the film in the order of their slices, for any number of threads. Their
//! weight is the area of the pixel that they represent, so a pixel is the mean over its slices.

use super::correction::Correction;
use super::draws::{Draw, Draws};
use super::lattice::{Differing, Lattice, PlacedSlice};
use super::layout::Layout;
use super::refine::{DRAWN, ORDERED};
use super::rounds::{Picture, Round, Schedule};
use super::shares::{PlacedPiece, Shares};
use super::{Job, Light, Watch, camera_ray};
use crate::film::{Film, Mask, Splat, Splats};
use crate::light::LightPlace;
use crate::math::Sampler;
use crate::scene::{PixelFilter, Window};
use crate::snapshot::Exposure;
use crate::transport::slices::{Fan, Outline, Piece, SliceJob, SliceScratch, count_segments};
use crate::transport::{Component, OneLight, Sample, Scratch, Transport};
use glam::DVec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Slices that a thread solves before its samples go to the film: enough for threads to end together, few
/// enough for the caches.
const BATCH_PER_THREAD: usize = 16;

/// Minimum samples a pixel before slices with draws of their own are judged. A few points of a light cast a
/// few shadows, each as sharp as that of a point, and between these all halves agree
/// (docs/decisions/tolerance.md).
const FEWEST_DRAWN_SAMPLES: u32 = 16;

/// One light's component of a picture.
pub(super) struct LightPicture<'a, 'scene> {
    exposure: &'a Exposure<'scene>,
    job: &'a Job,
    transport: Transport<'a>,
    correction: Option<&'a Correction>,
    light: OneLight,
    tally: &'a Tally,
    draws: Draws<'a, 'scene>,
    /// Lattice of slices; `None` if the light is where the camera is.
    lattice: Option<Lattice>,
}

/// Counts of a picture's slices, over all threads.
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

    /// Numbers of slices and of their segments.
    pub(super) fn totals(&self) -> (u64, u64) {
        (self.slices.load(Ordering::Relaxed), self.segments.load(Ordering::Relaxed))
    }
}

/// Memory that a thread reuses from slice to slice.
#[derive(Default)]
struct SlicesScratch {
    slices: SliceScratch,
    outline: Outline,
    pieces: Vec<PlacedPiece>,
}

impl<'a, 'scene> LightPicture<'a, 'scene> {
    /// Lays out the slices.
    pub(super) fn new(
        exposure: &'a Exposure<'scene>,
        job: &'a Job,
        found: &Light<'a>,
        light: OneLight,
        tally: &'a Tally,
    ) -> Self {
        let draws = Draws::new(exposure, light.number, job.seed);
        let lattice = lattice(exposure, job, light.number, &draws);
        let (transport, correction) = (job.transport(found.indirect), found.correction());
        Self { exposure, job, transport, correction, light, tally, draws, lattice }
    }

    fn draws_in_strata(&self) -> bool {
        self.lattice.as_ref().is_some_and(|lattice| lattice.layout == Layout::InStrata)
    }

    /// Solves a slice and stores its samples.
    fn solve(
        &self,
        round: &Round,
        seen: &Mask,
        placed: &Placed,
        scratch: &mut SlicesScratch,
        samples: &mut Splats,
    ) {
        let Self { job, light, correction, .. } = *self;
        let Placed { draw, fan, slice } = placed;
        let SlicesScratch { slices, outline, pieces } = scratch;
        let slice_job = SliceJob {
            snapshot: draw.snapshot,
            transport: &self.transport,
            light: &draw.light,
            hue: draw.hue,
            has_rest: light.with_rest,
            fan,
        };
        let shares = Shares { round, size: job.size, placed: slice };
        let chords = slice.chords(job.size, seen);
        pieces.clear();
        let has_outline = job.filter == PixelFilter::Box;
        let add = |piece: &Piece, value: &mut Sample| {
            if let Some(correction) = correction {
                correction.apply(value, piece.place.film_px);
            }
            let sample = samples.keep(value);
            match job.filter {
                PixelFilter::Box => pieces.push(PlacedPiece::new(piece, sample)),
                PixelFilter::BlackmanHarris => {
                    shares.by_window(piece).for_each(|splat| samples.add(sample, &splat));
                }
            }
        };
        outline.start(round.region_side());
        let outlined = has_outline.then_some(&mut *outline);
        if let Some(segments) = slice_job.solve(&slice.slice, chords, outlined, slices, add) {
            self.tally.add(segments);
            if has_outline {
                shares.by_swath(fan, pieces, outline, |sample, splat| samples.add(sample, splat));
            }
        }
    }
}

/// A slice in the fan of its draw.
struct Placed<'a, 'scene> {
    draw: Draw<'a, 'scene>,
    fan: Fan,
    slice: PlacedSlice,
}

fn lattice(exposure: &Exposure, job: &Job, light: usize, draws: &Draws) -> Option<Lattice> {
    let middle = draws.middle();
    let base = middle.fan(job.size)?;
    let deviation_rad = draws.deviation_rad(job.size)?;
    let differing = (!draws.is_single()).then(|| Differing {
        deviation_rad,
        in_time: !exposure.is_instant(),
        in_brightness: matches!(middle.light.place(), LightPlace::At(_)),
    });
    let segments = |slice: &_| count_segments(exposure.middle(), &base, slice);
    let mut sampler = Sampler::new(job.seed, light as u32, 0, 0);
    Some(Lattice::new(base, differing, Schedule::of(job.sampling), &segments, || sampler.next_2d()))
}

impl Picture for LightPicture<'_, '_> {
    fn film(&self, job: &Job, window: Window) -> Film {
        let has_hues = self.exposure.middle().lights[self.light.number].has_hues();
        if self.draws_in_strata() {
            return Film::with_smooth_shafts(job.size, window, &job.passes, has_hues);
        }
        let new = if has_hues { Film::with_hues } else { Film::new };
        new(job.size, window, &job.passes)
    }

    fn convergence(&self) -> f64 {
        let are_ordered = self
            .lattice
            .as_ref()
            .is_some_and(|lattice| matches!(lattice.layout, Layout::Common | Layout::InRings));
        if are_ordered && self.exposure.is_instant() { ORDERED } else { DRAWN }
    }

    fn fewest_samples(&self) -> u32 {
        if self.convergence() == ORDERED { 1 } else { FEWEST_DRAWN_SAMPLES }
    }

    fn add_round(&self, round: &Round, film: &mut Film, watch: &Watch) {
        let Self { job, ref draws, ref lattice, .. } = *self;
        let Some(lattice) = lattice else { return };
        let seen = round.seen(job.size, job.filter);
        let lattice = lattice.of_round(round, &seen);
        let placed = |number: usize| {
            let draw = draws.get(lattice.place(number), lattice.period());
            let fan = draw.fan(job.size)?;
            let slice = lattice.slice(&fan, number)?;
            Some(Placed { draw, fan, slice })
        };
        let has_halves = job.is_judged() || self.draws_in_strata();
        let count = lattice.count();
        // Reused by all batches: freeing so much memory and allocating it again costs a tenth of the time.
        let batch = BATCH_PER_THREAD * rayon::current_num_threads();
        let mut solved: Vec<Splats> = vec![film.splats(); batch];
        for first in (0..count).step_by(batch) {
            if (watch.cancelled)() {
                break;
            }
            solved.par_iter_mut().enumerate().for_each_init(
                SlicesScratch::default,
                |scratch, (index, samples)| {
                    let number = first + index;
                    // Every other slice of a lattice makes a lattice, too; unused halves are not stored.
                    samples.start(has_halves && (!round.is_first() || number % 2 == 1));
                    let is_wanted = lattice.is_wanted(number) && !(watch.cancelled)();
                    if let Some(placed) = is_wanted.then(|| placed(number)).flatten() {
                        self.solve(round, &seen, &placed, scratch, samples);
                    }
                },
            );
            film.add_all(&solved);
            watch.tell(count.min(first + batch) as f64 / count as f64);
        }
    }

    /// One ray through the centre of each such pixel.
    fn fill_holes(&self, film: &mut Film, watch: &Watch) {
        let Self { exposure, job, light, correction, .. } = *self;
        let mut scratch = Scratch::default();
        for (x, y) in film.holes() {
            if (watch.cancelled)() {
                break;
            }
            let mut sampler = Sampler::new(job.seed, x as u32, y as u32, 0);
            let centre = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
            let (snapshot, ray) = camera_ray(exposure, job.size, centre, &mut sampler);
            let component = Component::Light(light);
            let mut value = self.transport.radiance_of(component, snapshot, &ray, &mut sampler, &mut scratch);
            if let Some(correction) = correction {
                correction.apply(&mut value, centre);
            }
            film.add(&Splat { pixel: (x, y), weight: 1.0, from_centre_px: 0.0 }, &value);
        }
    }
}
