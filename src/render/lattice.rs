//! Lattice of a picture's slices, and the places of samples on them. In go the fan of the light's centre and
//! the deviation of fans by light, lens and shutter. Out come slices by number. Invariant: a sample has the
//! weight of the picture area that it represents, for any fan.
//!
//! Slices lie at equal angles, and a slice has a chord in each pixel that it crosses. With a light, a lens or
//! a shutter that has an extent, each slice has a fan of its own. The axes of these fans differ, so a slice
//! would leave its place in the lattice. So each slice is rotated until it passes through its place half way
//! across its ring (`rings.rs`). It is not rotated near the axis and near the opposite direction, where fans
//! deviate too far.
//!
//! Where draws are in strata, a stratum recurs after a period of places. Each stratum then has slices over
//! all of the picture, a pixel apart, whose swaths touch.

use super::bearings::Bearings;
use super::layout::{Facts, Layout};
use super::places::{Places, per_row, phase};
use super::rings::RingFacts;
use super::rounds::{Round, Schedule};
use crate::film::Mask;
use crate::scene::Size;
use crate::transport::slices::{Chord, Crossing, Fan, Ring, Slice};
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Samples that a slice is worth in a pixel that it crosses: its chord is cut at edges, and where all slices
/// see the same it is well placed between its neighbours.
const SAMPLES_PER_SLICE: f64 = 4.0;

/// Samples that a slice is worth where slices have draws of their own, which differ more.
const SAMPLES_PER_DRAW: f64 = 2.0;

/// Minimum number of slices to a pixel's width: their swaths still cover every pixel.
const FEWEST_SLICES_PER_PX: f64 = 0.5;

/// Minimum number of slices to a pixel's width where they have draws of their own.
const FEWEST_DRAWS_PER_PX: f64 = 1.0;

/// Width in pixels from which a swath is sampled by two lines on either side of its slice, rather than one.
const WIDE_SWATH_PX: f64 = 0.8;

/// Maximum width of the swaths of strata: samples that count in a pixel must lie within the margin of a crop
/// (`rounds.rs`).
const WIDEST_SWATH_PX: f64 = 2.0;

/// Differences between slices with draws of their own.
#[derive(Clone, Copy, Default)]
pub(super) struct Differing {
    /// Maximum deviation of the axis.
    pub(super) deviation_rad: f64,
    /// Whether they have different moments.
    pub(super) in_time: bool,
    /// Whether their points of the light differ in brightness, as those of a lamp do by their distances.
    pub(super) in_brightness: bool,
}

/// The places of all slices over one light's component.
pub(super) struct Lattice {
    /// Fan of the middle draw.
    base: Fan,
    pub(super) layout: Layout,
    rings: Vec<RingLattice>,
    /// Number of places after which the strata of draws recur; `None` without strata.
    period: Option<usize>,
    per_row: usize,
    deviation_rad: f64,
}

struct RingLattice {
    ring: Ring,
    /// Angle from the axis at which slices pass through their places; `None` if they are not rotated.
    anchor: Option<f64>,
    /// Angle to either side of the base's range in which there are slices, too.
    margin_rad: f64,
    /// Angle of the ring's first place, and radians between places.
    first_rad: f64,
    place_rad: f64,
    /// Number of its first place, and of the one after its last.
    from: usize,
    to: usize,
    /// Weight of a sample for each unit of area per radian.
    weight_per_area: f64,
    shift_along: f64,
}

impl Lattice {
    /// The slices of all rounds. All have the fan `base`, or fans that differ by their draws. `segments`
    /// returns the number of segments of a slice; `shift` returns the random shifts of one ring after
    /// another, across the slices and along them.
    pub(super) fn new(
        base: Fan,
        differing: Option<Differing>,
        schedule: Schedule,
        segments: &dyn Fn(&Slice) -> usize,
        mut shift: impl FnMut() -> (f64, f64),
    ) -> Self {
        let is_drawn = differing.is_some();
        let Differing { deviation_rad, in_time, in_brightness } = differing.unwrap_or_default();
        let samples = f64::from(schedule.first);
        let (samples_per_slice, fewest) = if is_drawn {
            (SAMPLES_PER_DRAW, FEWEST_DRAWS_PER_PX)
        } else {
            (SAMPLES_PER_SLICE, FEWEST_SLICES_PER_PX)
        };
        let slices_per_px = (samples / samples_per_slice).max(fewest);
        let ring_facts = RingFacts { is_drawn, deviation_rad, samples, slices_per_px, segments };
        let (count, are_ordered) = ring_facts.choose(&base);
        let samples = schedule.in_all();
        // Rings are those of the first round. Slices of later rounds lie too close to be kept in order.
        let rings = if schedule.doublings > 0 { 1 } else { count };
        let facts = Facts { is_drawn, are_ordered, rings, in_time, in_brightness, samples };
        let layout = Layout::choose(&facts);
        // Slices of one stratum are in order without rings.
        let count = if layout == Layout::InStrata { 1 } else { count };
        let per_row = per_row(schedule);
        // Each stratum has one slice to a pixel's width after all rounds.
        let rows_per_px = slices_per_px.round() as usize;
        let period = (layout == Layout::InStrata).then_some(rows_per_px * per_row);
        let first_shift = shift();
        let mut rings: Vec<RingLattice> = Vec::new();
        for ring in ring_facts.cut(&base, count) {
            let from = rings.last().map_or(0, |ring| ring.to);
            let rows = Rows {
                per_rad: ring_facts.slices_per_rad(&base, ring),
                multiple: if period.is_some() { rows_per_px } else { 1 },
                per_row,
                from,
            };
            // Rings of one fan share their shifts, so many slices near the epipole change nothing elsewhere.
            let shifts = if is_drawn && from > 0 { shift() } else { first_shift };
            let ring = RingLattice::new(&base, ring, deviation_rad, &rows, DVec2::from(shifts));
            let weight_per_area = f64::from(schedule.first) * ring.weight_per_area;
            rings.push(RingLattice { weight_per_area, ..ring });
        }
        Self { base, layout, rings, period, per_row, deviation_rad }
    }

    /// The slices of a round that may cross pixels of `seen`.
    pub(super) fn of_round(&self, round: &Round, seen: &Mask) -> RoundLattice<'_> {
        let Self { base, deviation_rad, .. } = self;
        let bearings =
            |ring: &RingLattice| Bearings::new(base, ring.ring, 1.5 * deviation_rad, seen, ring.margin_rad);
        let bearings = if round.is_first() { Vec::new() } else { self.rings.iter().map(bearings).collect() };
        RoundLattice { lattice: self, places: Places::of_round(round), bearings }
    }

    fn ring(&self, place: usize) -> Option<usize> {
        self.rings.iter().position(|ring| place < ring.to)
    }
}

/// Rows of places of a ring.
struct Rows {
    per_rad: f64,
    /// Divisor of their number around the whole circle.
    multiple: usize,
    per_row: usize,
    /// Number of the ring's first place.
    from: usize,
}

impl RingLattice {
    /// Lattice of one ring, with weights for one sample a pixel.
    fn new(base: &Fan, ring: Ring, deviation_rad: f64, rows: &Rows, shift: DVec2) -> Self {
        let extent = base.extent();
        let (low, high) = (ring.0.max(extent.0), ring.1.min(extent.1));
        let rotation = (deviation_rad.sin() / low.sin().min(high.sin()).max(0.0)).min(1.0).asin();
        let is_anchored = deviation_rad > 0.0 && rotation < 0.25 * PI;
        // Fans that deviate cover more than the base's angles.
        let margin_rad = match deviation_rad {
            0.0 => 0.0,
            _ if is_anchored => 1.5 * rotation,
            _ => PI,
        };
        let width = (base.angles.1 + 2.0 * margin_rad).min(TAU);
        let Rows { per_rad, multiple, per_row, from } = *rows;
        // Around the whole circle a stratum's last slice is as far from its first as from the one before.
        let count = ((width * per_rad).ceil().max(1.0) as usize).next_multiple_of(multiple);
        let row_rad = width / count as f64;
        Self {
            ring,
            anchor: is_anchored.then_some(0.5 * (low + high)),
            margin_rad,
            // The cell of the slice before the first reaches into the picture, unless that slice is the last
            // one.
            first_rad: base.angles.0 - 0.5 * (width - base.angles.1) + (shift.x - 1.0) * row_rad,
            place_rad: row_rad / per_row as f64,
            from,
            to: from + (count + usize::from(width < TAU)) * per_row,
            weight_per_area: row_rad,
            shift_along: shift.y,
        }
    }

    /// Angle of a place in the base fan.
    fn angle(&self, place: usize) -> f64 {
        self.first_rad + (place - self.from) as f64 * self.place_rad
    }
}

pub(super) struct RoundLattice<'a> {
    lattice: &'a Lattice,
    places: Places,
    /// Bearings at which a ring's slices may cross wanted pixels, for each ring; none if all may.
    bearings: Vec<Bearings>,
}

impl RoundLattice<'_> {
    /// Number of slices.
    pub(super) fn count(&self) -> usize {
        self.lattice.rings.last().map_or(0, |ring| ring.to / self.places.step)
    }

    /// Whether slice `number` may cross wanted pixels, with any draw.
    pub(super) fn is_wanted(&self, number: usize) -> bool {
        let place = self.places.of(number);
        let Some(ring) = self.lattice.ring(place) else { return false };
        let bearings = self.bearings.get(ring);
        bearings.is_none_or(|bearings| bearings.hold(self.lattice.rings[ring].angle(place)))
    }

    /// Place of slice `number`.
    pub(super) fn place(&self, number: usize) -> usize {
        self.places.of(number)
    }

    /// Number of places after which the strata of draws recur; `None` without strata.
    pub(super) fn period(&self) -> Option<usize> {
        self.lattice.period
    }

    /// Slice `number`, in the fan of its draw; `None` if it misses the picture.
    pub(super) fn slice(&self, drawn: &Fan, number: usize) -> Option<PlacedSlice> {
        let Lattice { base, period, per_row, .. } = self.lattice;
        let place = self.places.of(number);
        let ring = &self.lattice.rings[self.lattice.ring(place)?];
        let angle = ring.angle(place);
        // Rotation makes the angles of slices closer or wider, and with them the distances of their samples.
        let (angle, spread) =
            ring.anchor.map_or((angle, 1.0), |anchor| drawn.angle_through(base, angle, anchor));
        let slice = drawn.slice(angle, ring.ring)?;
        let place_rad = spread * ring.place_rad;
        let swath_rad = match period {
            // Up to the next slice of the same stratum.
            Some(period) => {
                let widest_rad = WIDEST_SWATH_PX / slice.greatest_separation_px_per_rad();
                (place_rad * *period as f64).min(widest_rad)
            }
            None => place_rad * self.places.step as f64,
        };
        Some(PlacedSlice {
            slice,
            angle,
            ring: ring.ring,
            phase: (ring.shift_along + phase(place, *per_row)).fract(),
            weight_per_area: ring.weight_per_area * spread,
            swath_rad,
            // One seed for each round and ring; a shift has few bits.
            random: (
                (ring.shift_along * f64::from(u32::MAX)) as u32 ^ self.places.step as u32,
                number as u32,
            ),
        })
    }
}

/// A slice to be solved, with its swath.
pub(super) struct PlacedSlice {
    pub(super) slice: Slice,
    /// Angle of the slice in its fan.
    angle: f64,
    ring: Ring,
    /// Phase of its samples in their pieces, without the dither of pixels.
    phase: f64,
    /// Weight of a sample for each unit of area per radian that it represents.
    pub(super) weight_per_area: f64,
    /// Angle of its swath: half way to the slice before it in its round or stratum, and half way to the next.
    swath_rad: f64,
    /// See [`Chord::random`].
    random: (u32, u32),
}

impl PlacedSlice {
    /// Half width of its swath, pixels, where the slice has passed an area per radian.
    pub(super) fn half_swath_px(&self, area_per_rad: f64) -> f64 {
        // No filter is wider.
        (0.5 * self.swath_rad * self.slice.separation_px_per_rad_at(area_per_rad)).min(1.0)
    }

    /// Number of lines that sample its swath, with the slice in the middle.
    pub(super) fn swath_lines(&self) -> i32 {
        let width_px = self.swath_rad * self.slice.greatest_separation_px_per_rad();
        if width_px < WIDE_SWATH_PX { 3 } else { 5 }
    }

    /// The other lines: slices of its fan, and their rotations, radians.
    pub(super) fn swath_beside(&self, drawn: &Fan) -> impl Iterator<Item = (Slice, f64)> {
        let lines = self.swath_lines();
        let line_rad = self.swath_rad / f64::from(lines);
        let beside = (0..lines).map(move |line| line - lines / 2).filter(|line| *line != 0);
        beside.filter_map(move |line| {
            let rotated_rad = line_rad * f64::from(line);
            Some((drawn.slice(self.angle + rotated_rad, self.ring)?, rotated_rad))
        })
    }

    /// Chords in visible pixels.
    pub(super) fn chords(&self, size: Size, seen: &Mask) -> impl Iterator<Item = Chord> {
        let (weight_per_area, random) = (self.weight_per_area, self.random);
        self.slice.crossings(size, |x, y| seen.contains(x, y)).map(move |crossing| {
            let Crossing { pixel, .. } = crossing;
            let ([start, end], slopes) = (self.slice.areas(&crossing), self.slice.slopes(&crossing));
            let phase = (self.phase + dither(pixel.0, pixel.1)).fract();
            Chord { pixel, start, end, slopes, phase, weight_per_area, random }
        })
    }
}

/// A dither mask, `0..1`, by an additive recurrence in two dimensions (Roberts 2018, "The unreasonable
/// effectiveness of quasirandom sequences").
fn dither(x: usize, y: usize) -> f64 {
    (x as f64 * 0.754_877_666_246_692_7 + y as f64 * 0.569_840_290_998_053_2).fract()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Window;
    use glam::DVec3;
    use std::collections::BTreeSet;

    const SIZE: Size = Size { width: 480, height: 270 };

    /// Strata of draws, and the widest swaths, pixels, in rounds of 6, 6 and 12 samples. The light deviates
    /// far, and gathering is expensive.
    fn drawn(differing: Differing) -> (BTreeSet<usize>, Vec<f64>) {
        let (sin, cos) = 50_f64.to_radians().sin_cos();
        let base = Fan::of_pinhole(0.7, SIZE, DVec3::new(0.0, sin, -cos));
        let wanted = Mask::all(Window::whole(SIZE));
        let schedule = Schedule { first: 6, doublings: 2 };
        let lattice = Lattice::new(base, Some(differing), schedule, &|_| 1_000_000, || (0.3, 0.6));
        let (mut draws, mut swaths) = (BTreeSet::new(), Vec::new());
        for number in 0..3 {
            let lattice = lattice.of_round(&schedule.round(number, &wanted).expect("not the last"), &wanted);
            let stratum = |place: usize| lattice.period().map_or(place, |period| place % period);
            draws.extend((0..lattice.count()).map(|number| stratum(lattice.place(number))));
            let slices = (0..lattice.count()).filter_map(|number| lattice.slice(&base, number));
            let width_px =
                |placed: PlacedSlice| placed.swath_rad * placed.slice.greatest_separation_px_per_rad();
            swaths.extend(slices.map(width_px).reduce(f64::max));
        }
        (draws, swaths)
    }

    /// The rounds together have 12 slices to a pixel's width, and each of 12 strata has one.
    #[test]
    fn slices_that_deviate_far_share_strata_a_pixel_apart() {
        let (draws, swaths) = drawn(Differing { deviation_rad: 0.016, ..Differing::default() });
        assert!(draws.into_iter().eq(0..12));
        // One pixel in the mean, and somewhat more at the widest place.
        assert!(swaths.iter().all(|width| (1.0..=2.000001).contains(width)), "{swaths:?}");
    }

    #[test]
    fn lamps_and_open_shutters_have_a_draw_for_each_slice() {
        for (in_time, in_brightness) in [(true, false), (false, true)] {
            let (draws, swaths) = drawn(Differing { deviation_rad: 0.016, in_time, in_brightness });
            assert!(draws.len() > 1000 && swaths[0] < 1.0, "{} {swaths:?}", draws.len());
        }
    }
}
