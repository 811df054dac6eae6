//! Which slices of a fan a pass is made of, and where on them its samples lie. In go the fan and the pass, out come slices by
//! number. Invariant: a sample counts as much as the area of the picture that it stands for.
//!
//! Slices lie at equal angles, fewer about the axis (`rings.rs`), and in each pixel that it crosses a slice has a chord.

use super::bearings::Bearings;
use super::passes::SamplePass;
use super::places::Places;
use super::rings::{PerPixel, rings, slices_per_rad};
use crate::film::Mask;
use crate::scene::Size;
use crate::transport::slices::{Chord, Crossing, Fan, Ring, Slice};
use std::f64::consts::TAU;

/// A swath counts by its slice and one line on either side of it, or two where it is wider than so many pixels.
const WIDE_SWATH_PX: f64 = 0.8;

/// How densely the slices of a fan lie.
#[derive(Clone, Copy)]
pub(super) struct Density {
    /// Of the first pass alone.
    pub(super) slices: PerPixel,
    /// Samples a pixel that these are worth.
    pub(super) samples: f64,
    pub(super) places: Places,
}

/// The slices of one pass over one fan.
pub(super) struct Lattice {
    fan: Fan,
    rings: Vec<RingLattice>,
    places: Places,
}

struct RingLattice {
    ring: Ring,
    /// The angle of the ring's first place, and how many radians between places.
    first_rad: f64,
    place_rad: f64,
    /// The numbers of its first place, and of the one after its last.
    from: usize,
    to: usize,
    /// What a sample counts for each unit of area per radian.
    weight_per_area: f64,
    shift_along: f64,
    /// Where its slices may meet pixels that are wanted; none if all do.
    bearings: Option<Bearings>,
}

/// A slice that is to be solved.
pub(super) struct PlacedSlice {
    pub(super) slice: Slice,
    /// Of the slice in its fan.
    angle: f64,
    ring: Ring,
    /// Where in their pieces its samples lie, but for the dither of pixels.
    phase: f64,
    /// What a sample counts for each unit of area per radian that it stands for.
    pub(super) weight_per_area: f64,
    /// By how much the next slices of its pass are turned.
    turned_rad: f64,
}

impl Lattice {
    /// The slices of a pass over a fan, shifted across and along themselves by parts of the way to the next ones. `seen` are the pixels in which chords are wanted.
    pub(super) fn new(
        fan: Fan,
        density: Density,
        pass: &SamplePass,
        seen: &Mask,
        [across, along]: [f64; 2],
    ) -> Self {
        let Density { slices, samples, places } = density;
        let width = fan.angles.1;
        let mut from = 0;
        let rings = rings(&fan).into_iter().map(|ring| {
            let rows = (width * slices_per_rad(&fan, ring, slices)).ceil().max(1.0);
            let row_rad = width / rows;
            // The cell of the slice before the first reaches into the picture, unless that is the last one again.
            let first_rad = fan.angles.0 + (across - 1.0) * row_rad;
            let rows = rows as usize + usize::from(width < TAU);
            let to = from + rows * places.per_row;
            let ring = RingLattice {
                ring,
                first_rad,
                place_rad: row_rad / places.per_row as f64,
                from,
                to,
                weight_per_area: samples * row_rad,
                shift_along: along,
                bearings: (!pass.is_first()).then(|| Bearings::new(&fan, ring, seen)),
            };
            from = to;
            ring
        });
        Self { rings: rings.collect(), places, fan }
    }

    /// How many slices there are.
    pub(super) fn count(&self) -> usize {
        self.rings.last().map_or(0, |ring| ring.to / self.places.step)
    }

    /// Slice `number`; `None` if it misses the picture, or all pixels that are wanted.
    pub(super) fn slice(&self, number: usize) -> Option<PlacedSlice> {
        let place = self.places.of(number);
        let ring = self.rings.iter().find(|ring| place < ring.to)?;
        let angle = ring.first_rad + (place - ring.from) as f64 * ring.place_rad;
        if ring.bearings.as_ref().is_some_and(|bearings| !bearings.hold(angle)) {
            return None;
        }
        Some(PlacedSlice {
            slice: self.fan.slice(angle, ring.ring)?,
            angle,
            ring: ring.ring,
            phase: (ring.shift_along + self.places.phase(place)).fract(),
            weight_per_area: ring.weight_per_area,
            turned_rad: ring.place_rad * self.places.step as f64,
        })
    }

    /// That of all its slices.
    pub(super) fn fan(&self) -> &Fan {
        &self.fan
    }
}

impl PlacedSlice {
    /// How far the swath that it stands for reaches to either side, pixels, where it has passed so much of its area per radian; 0 without one.
    pub(super) fn half_swath_px(&self, area_per_rad: f64) -> f64 {
        // No filter sees farther.
        (0.5 * self.turned_rad * self.slice.separation_px_per_rad_at(area_per_rad)).min(1.0)
    }

    /// By how many lines its swath counts, of which it is the middle one.
    pub(super) fn swath_lines(&self) -> i32 {
        let width_px = self.turned_rad * self.slice.greatest_separation_px_per_rad();
        if width_px < WIDE_SWATH_PX { 3 } else { 5 }
    }

    /// The others: slices of its fan `own`, and by how much they are turned, radians.
    pub(super) fn swath_beside(&self, own: &Fan) -> impl Iterator<Item = (Slice, f64)> {
        let lines = self.swath_lines();
        let line_rad = self.turned_rad / f64::from(lines);
        let beside = (0..lines).map(move |line| line - lines / 2).filter(|line| *line != 0);
        beside.filter_map(move |line| {
            let turn = line_rad * f64::from(line);
            Some((own.slice(self.angle + turn, self.ring)?, turn))
        })
    }

    /// Its chords in those pixels that are to be seen.
    pub(super) fn chords(&self, size: Size, seen: &Mask) -> impl Iterator<Item = Chord> {
        let unwanted_around = move |x: usize, y: usize| seen.unwanted_around(x, y);
        let weight_per_area = self.weight_per_area;
        self.slice.crossings(size, unwanted_around).map(move |crossing| {
            let Crossing { pixel, .. } = crossing;
            let ([start, end], slopes) = (self.slice.areas(&crossing), self.slice.slopes(&crossing));
            let phase = (self.phase + dither(pixel.0, pixel.1)).fract();
            Chord { pixel, start, end, slopes, phase, weight_per_area }
        })
    }
}

/// A dither mask, `0..1`, by an additive recurrence in two dimensions (Roberts 2018, "The unreasonable effectiveness of quasirandom
/// sequences").
fn dither(x: usize, y: usize) -> f64 {
    (x as f64 * 0.754_877_666_246_692_7 + y as f64 * 0.569_840_290_998_053_2).fract()
}
