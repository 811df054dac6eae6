//! Pictures from slices: for each light lattices of its slices. Invariant: samples reach
//! the film in the order of their slices, whatever thread solved them, and weigh as much as the area of the pixel that they stand for, so
//! a pixel is the mean over what its slices see of it.

use super::draws::{Draw, Draws};
use super::lattice::{Density, Lattice};
use super::passes::{Picture, SamplePass};
use super::places::Places;
use super::refine::{DRAWN, ORDERED};
use super::rings::PerPixel;
use super::shares::{PlacedPiece, Shares};
use super::{Job, Watch, camera_ray};
use crate::film::{Film, Mask, Splats};
use crate::math::Sampler;
use crate::scene::{PixelFilter, Window};
use crate::snapshot::Exposure;
use crate::transport::slices::{Fan, Outline, Piece, SliceJob, SliceScratch, solve};
use crate::transport::{Part, Sample, Scratch, radiance_of_part};
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// How many samples a slice is worth in a pixel that it crosses: its chord is cut at what it sees, and where all slices share a fan it lies
/// as evenly between its neighbours as can be.
const SAMPLES_PER_SLICE: f64 = 4.0;

/// Slices to a pixel's width, at least: their swaths still leave no pixel out.
const FEWEST_SLICES_PER_PX: f64 = 0.5;

/// The same where each draw has a fan of its own, with fewer slices.
const SAMPLES_PER_SLICE_OF_DRAW: f64 = 2.0;

/// Slices of each draw to a pixel's width. With fewer, and more draws, what is not known to go on between slices is blurred; with more, and fewer
/// draws, light and lens are told by few points.
const SLICES_PER_PX_OF_DRAW: f64 = 1.25;

/// From so many samples on draws have more slices, too: what is blurred is to end like all other errors.
const MANY_SAMPLES: f64 = 64.0;

/// Fans that are solved together: enough for many threads, few enough not to fill the memory.
const FANS_AT_ONCE: usize = 32;

/// Slices that a thread solves before its samples go to the film: enough for threads to end together, few enough for the caches.
const BATCH_PER_THREAD: usize = 16;

/// One light's part of a picture, in passes of a lattice each.
pub(super) struct LightPicture<'a> {
    pub(super) exposure: &'a Exposure<'a>,
    pub(super) job: &'a Job,
    /// The light, as its index in the snapshot.
    pub(super) light: usize,
    pub(super) tally: &'a Tally,
}

/// What a thread keeps from slice to slice.
#[derive(Default)]
struct SolveScratch {
    slices: SliceScratch,
    outline: Outline,
    pieces: Vec<PlacedPiece>,
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
        if self.draws().is_single() { ORDERED } else { DRAWN }
    }

    fn add_pass(&self, pass: &SamplePass, film: &mut Film, watch: &Watch) {
        let draws = self.draws();
        let numbers = if draws.is_single() { 0..1 } else { draws_of(pass) };
        let count = numbers.len();
        let numbers: Vec<usize> = numbers.collect();
        let seen = pass.seen(self.job.size, self.job.filter);
        for (group, numbers) in numbers.chunks(FANS_AT_ONCE).enumerate() {
            let fan = |&number: &usize| DrawnFan::new(self, &draws, number, count, pass, &seen);
            let fans: Vec<DrawnFan> = numbers.par_iter().filter_map(fan).collect();
            let done = group * FANS_AT_ONCE;
            let part = [done, done + numbers.len()].map(|fans| fans as f64 / count as f64);
            watch.part(part.into(), None, |watch| self.add_fans(&fans, pass, &seen, film, watch));
        }
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
            let part = Part::Light(light);
            let value = radiance_of_part(part, snapshot, &job.transport, &ray, &mut sampler, &mut scratch);
            film.add(x, y, 1.0, 0.0, &value);
        }
    }
}

/// The draws that a pass adds to those before it.
fn draws_of(pass: &SamplePass) -> Range<usize> {
    let count = |samples: u32| {
        let slices_per_px = f64::from(samples) / SAMPLES_PER_SLICE_OF_DRAW;
        (slices_per_px / slices_per_px_of_draw(samples)).ceil() as usize
    };
    count(pass.before())..count(pass.before() + pass.samples)
}

/// How many slices to a pixel's width each draw has that comes to so many samples a pixel.
fn slices_per_px_of_draw(samples: u32) -> f64 {
    SLICES_PER_PX_OF_DRAW * (f64::from(samples) / MANY_SAMPLES).max(1.0).cbrt()
}

/// One draw's part of a pass.
struct DrawnFan<'a> {
    number: usize,
    /// Whether it is the only one, and later passes come back to it.
    is_single: bool,
    draw: Draw<'a, 'a>,
    lattice: Lattice,
}

impl<'a> DrawnFan<'a> {
    /// That of draw `number`, one of so many; `None` if its light is at its point of the lens.
    fn new(
        picture: &LightPicture<'a>,
        draws: &Draws<'a, 'a>,
        number: usize,
        count: usize,
        pass: &SamplePass,
        seen: &Mask,
    ) -> Option<Self> {
        let LightPicture { job, light, .. } = *picture;
        let draw = draws.get(number);
        let fan = Fan::new(&draw.snapshot.view, job.size, draw.lens_point, draw.light.source())?;
        let (density, shift) = if draws.is_single() {
            let samples = f64::from(pass.first_samples());
            let slices_per_px = (samples / SAMPLES_PER_SLICE).max(FEWEST_SLICES_PER_PX);
            // The same for all passes: they are one lattice.
            let shift = Sampler::new(job.seed, light as u32, 0, 0).next_2d();
            (
                Density { slices: PerPixel::Least(slices_per_px), samples, places: Places::of_pass(pass) },
                shift.into(),
            )
        } else {
            let samples = f64::from(pass.samples) / count as f64;
            (
                Density {
                    slices: PerPixel::Mean(slices_per_px_of_draw(pass.before() + pass.samples)),
                    samples,
                    places: Places::ALL,
                },
                draw.shift,
            )
        };
        let lattice = Lattice::new(fan, density, pass, seen, shift);
        Some(Self { number, is_single: draws.is_single(), draw, lattice })
    }
}

impl<'a> LightPicture<'a> {
    fn draws(&self) -> Draws<'a, 'a> {
        Draws::new(self.exposure, self.light, self.job.seed)
    }

    /// Adds the samples of all slices of some fans to the film.
    fn add_fans(&self, fans: &[DrawnFan], pass: &SamplePass, seen: &Mask, film: &mut Film, watch: &Watch) {
        // The numbers of all slices, fan after fan: where each fan's begin.
        let mut count = 0;
        let starts: Vec<usize> = fans
            .iter()
            .map(|fan| {
                let start = count;
                count += fan.lattice.count();
                start
            })
            .collect();
        // Kept from batch to batch: giving so much memory back and asking for it again costs a tenth of the time.
        let batch = BATCH_PER_THREAD * rayon::current_num_threads();
        let mut solved: Vec<Splats> = vec![film.splats(); batch];
        for first in (0..count).step_by(batch) {
            if (watch.cancelled)() {
                break;
            }
            solved.par_iter_mut().enumerate().for_each_init(
                SolveScratch::default,
                |scratch, (index, samples)| {
                    let number = first + index;
                    let of_fan = starts.partition_point(|&start| start <= number) - 1;
                    self.solve(&fans[of_fan], number - starts[of_fan], pass, seen, scratch, samples);
                },
            );
            film.add_all(&solved);
            watch.tell(count.min(first + batch) as f64 / count as f64);
        }
    }

    /// The samples of a fan's slice; none if it has no slice of that number.
    fn solve(
        &self,
        fan: &DrawnFan,
        number: usize,
        pass: &SamplePass,
        seen: &Mask,
        scratch: &mut SolveScratch,
        samples: &mut Splats,
    ) {
        let Self { job, light, tally, .. } = *self;
        let DrawnFan { draw, lattice, .. } = fan;
        // Of a first pass every other draw judges the rest, or if all slices share one every other slice; what nobody judges has no halves.
        let judges = !pass.is_first() || (if fan.is_single { number } else { fan.number }) % 2 == 1;
        samples.start(job.is_judged() && judges);
        let Some(placed) = lattice.slice(number) else { return };
        let slice_job = SliceJob {
            snapshot: draw.snapshot,
            transport: &job.transport,
            light: &draw.light,
            hue: draw.hue,
            self_luminous: light == 0,
            fan: lattice.fan(),
        };
        let shares = Shares { pass, size: job.size, placed: &placed };
        let chords = placed.chords(job.size, seen);
        let SolveScratch { slices, outline, pieces } = scratch;
        pieces.clear();
        let has_outline = job.filter == PixelFilter::Box;
        let add = |piece: &Piece, value: &Sample| {
            let sample = samples.keep(value);
            match job.filter {
                PixelFilter::Box => pieces.push(PlacedPiece::new(piece, sample)),
                PixelFilter::BlackmanHarris => {
                    shares.by_window(piece).for_each(|splat| samples.add(sample, &splat));
                }
            }
        };
        let outlined = has_outline.then_some(&mut *outline);
        if let Some(segments) = solve(&slice_job, &placed.slice, chords, outlined, slices, add) {
            tally.add(segments);
            if has_outline {
                shares.by_swath(lattice.fan(), pieces, outline, |sample, splat| samples.add(sample, splat));
            }
        }
    }
}
