//! Which slices a picture is made of, and where on them its samples lie. In go the fan of the
//! light's centre and how far the light, the lens and the shutter make it wander, out come slices by
//! number. Invariant: a sample counts as much as the area of the picture that it stands for, wherever its own fan is.
//!
//! Slices lie at equal angles, and in each pixel that it crosses a slice has a chord. With a light, a lens or a shutter that has an extent,
//! each slice has a fan of its own, whose axis is not quite that of the others, and would wander off
//! its place in the lattice. So each slice is turned so that it passes through its lattice place half way across its ring
//! (`rings.rs`); but about the axis, and about its far side, where they wander too far for that.
//!
//! Where they wander too far to be kept in order, but are many, slices share draws: every so many places a draw comes again, so that each has slices over all of the
//! picture, a pixel apart, whose swaths reach to each other. Then pixels side by side have seen the same points of light and lens, and what these have wrong is as smooth as what
//! they light.

use super::bearings::Bearings;
use super::places::Places;
use super::rings::{Layout, Rings};
use super::rounds::Round;
use crate::film::Mask;
use crate::scene::{Size, Window};
use crate::transport::slices::{Chord, Crossing, Fan, Ring, Slice};
use std::f64::consts::{PI, TAU};
use std::sync::OnceLock;

/// How many samples a slice is worth in a pixel that it crosses: its chord is cut at what it sees, and where all slices see the same it lies
/// as evenly between its neighbours as can be.
const SAMPLES_PER_SLICE: f64 = 4.0;

/// The same where slices have draws of their own, of which one tells little.
const SAMPLES_PER_DRAW: f64 = 2.0;

/// Slices to a pixel's width, at least: their swaths still leave no pixel out.
const FEWEST_SLICES_PER_PX: f64 = 0.5;

/// The same where slices have draws of their own: those that take turns stand for no more than the pixels that they cross.
const FEWEST_DRAWS_PER_PX: f64 = 1.0;

/// A swath counts by its slice and one line on either side of it, or two where it is wider than so many pixels.
const WIDE_SWATH_PX: f64 = 0.8;

/// What one draw has wrong shows as a line along its slice: as long as a leaf that flies, and as half shadows if rings do not cut it short.
/// So a few slices with draws of their own take turns: of this many, side by side, each has samples only in pixels of its own, and neighbouring pixels
/// mostly belong to different ones.
const TURNS: usize = 2;

/// From so many samples a pixel on such lines are too faint to pay for: slices that take turns gather what they cut twice as often.
const NO_TURNS_FROM: f64 = 64.0;

/// With so many samples a pixel in all, or more, slices share draws in place of taking turns: what few points of a light tell would show as so many shadows.
const SHARED_DRAWS_FROM: u32 = 16;

/// With more than so many every slice has a draw of its own: what swaths of a pixel's width blur would be most of the error.
const SHARED_DRAWS_TO: u32 = 128;

/// Swaths of shared draws are no wider: what counts in a pixel must not lie farther away than a crop looks (`rounds.rs`).
const WIDEST_SWATH_PX: f64 = 2.0;

/// In what slices with draws of their own differ.
#[derive(Clone, Copy, Default)]
pub(super) struct Differing {
    /// How far the axis wanders at most.
    pub(super) deviation_rad: f64,
    /// Whether they have moments of their own.
    pub(super) in_time: bool,
    /// Whether their points of the light are not all as bright as each other: those of a lamp lie nearer or farther.
    pub(super) in_brightness: bool,
}

/// The slices of one round over one light's part of the picture.
pub(super) struct Lattice {
    rings: Vec<RingLattice>,
    /// After so many places draws come again, if slices share them.
    draws: Option<usize>,
    /// Every so many slices are a lattice for their part of the pixels.
    turns: usize,
    places: Places,
}

struct RingLattice {
    ring: Ring,
    /// The angle from the axis at which slices pass through their places; without one they go by their own angles.
    anchor: Option<f64>,
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
    turns: usize,
    turn: usize,
    /// Where in their pieces its samples lie, but for the dither of pixels.
    phase: f64,
    /// What a sample counts for each unit of area per radian that it stands for.
    pub(super) weight_per_area: f64,
    /// By how much the next slices of its round, or of its draw, are turned, if all of them have samples in the same pixels.
    turned_rad: Option<f64>,
}

impl Lattice {
    /// The slices of a round, of `base`, which all are the same or differ by their draws. A round that is not the first is for few pixels, and its slices
    /// gather all that they cut all the same: they take no turns. `chosen` are the picture's rings once they are chosen.
    /// `seen` are the pixels in which chords are wanted, `segments` tells how many a slice gathers, and `shift` gives the random shifts of ring after ring, across the slices and along them: the same for
    /// all rounds of a picture.
    pub(super) fn new(
        base: &Fan,
        differing: Option<Differing>,
        round: &Round,
        seen: &Mask,
        segments: &dyn Fn(&Slice) -> usize,
        chosen: &OnceLock<Rings>,
        mut shift: impl FnMut() -> (f64, f64),
    ) -> Self {
        let extent = base.extent();
        let is_drawn = differing.is_some();
        let Differing { deviation_rad, in_time, in_brightness } = differing.unwrap_or_default();
        let samples = f64::from(round.first_samples());
        let (samples_per_slice, fewest) = if is_drawn {
            (SAMPLES_PER_DRAW, FEWEST_DRAWS_PER_PX)
        } else {
            (SAMPLES_PER_SLICE, FEWEST_SLICES_PER_PX)
        };
        let slices_per_px = (samples / samples_per_slice).max(fewest);
        let layout = Layout { is_drawn, deviation_rad, samples, slices_per_px, segments };
        let Rings { count, are_ordered } = *chosen.get_or_init(|| layout.choose(base));
        let in_all = round.first_samples() << round.doublings;
        let are_shared = is_drawn
            && count == 1
            && !(are_ordered || in_time || in_brightness)
            && (SHARED_DRAWS_FROM..=SHARED_DRAWS_TO).contains(&in_all);
        let is_streaky = is_drawn && !are_shared && (count == 1 || in_time) && samples < NO_TURNS_FROM;
        let first_turns = if is_streaky { TURNS } else { 1 };
        let turns = if round.is_first() { first_turns } else { 1 };
        let places = Places::new(round, first_turns);
        // Each draw has a slice to a pixel's width, when all rounds are done.
        let rows_per_px = slices_per_px.round() as usize;
        let draws = are_shared.then_some(rows_per_px * places.per_row);
        let first_shift = shift();
        let mut from = 0;
        let rings = layout.cut(base, count).into_iter().map(|ring| {
            let (low, high) = (ring.0.max(extent.0), ring.1.min(extent.1));
            let anchor = 0.5 * (low + high);
            let turn = (deviation_rad.sin() / low.sin().min(high.sin()).max(0.0)).min(1.0).asin();
            let is_anchored = deviation_rad > 0.0 && turn < 0.25 * PI;
            // Fans that wander show more than the base's angles.
            let margin = match deviation_rad {
                0.0 => 0.0,
                _ if is_anchored => 1.5 * turn,
                _ => PI,
            };
            let width = (base.angles.1 + 2.0 * margin).min(TAU);
            let rows = (width * layout.slices_per_rad(base, ring)).ceil().max(1.0);
            // All the way round the last slice of a draw lies as far from its first one as from the one before.
            let rows = if are_shared { (rows as usize).next_multiple_of(rows_per_px) as f64 } else { rows };
            let row_rad = width / rows;
            let turn_rad = row_rad / first_turns as f64;
            // Rings of one fan share them, so that a crowd about the axis changes nothing elsewhere.
            let (across, along) = if is_drawn && from > 0 { shift() } else { first_shift };
            // The cell of the slice before the first reaches into the picture, unless that is the last one again.
            let first_rad = base.angles.0 - 0.5 * (width - base.angles.1) + (across - 1.0) * turn_rad;
            let rows = rows as usize + usize::from(width < TAU);
            let to = from + rows * places.per_row;
            let ring = RingLattice {
                ring,
                anchor: is_anchored.then_some(anchor),
                first_rad,
                place_rad: row_rad / places.per_row as f64,
                from,
                to,
                weight_per_area: samples * row_rad,
                shift_along: along,
                bearings: (!round.is_first())
                    .then(|| Bearings::new(base, ring, 1.5 * deviation_rad, seen, margin)),
            };
            from = to;
            ring
        });
        Self { rings: rings.collect(), draws, turns, places }
    }

    /// How many slices there are.
    pub(super) fn count(&self) -> usize {
        self.rings.last().map_or(0, |ring| ring.to / self.places.step)
    }

    /// Whether slice `number` may meet pixels that are wanted, whatever it is seen with.
    pub(super) fn is_wanted(&self, number: usize) -> bool {
        let place = self.places.of(number);
        let Some(ring) = self.ring(place) else { return false };
        ring.bearings.as_ref().is_none_or(|bearings| bearings.hold(ring.angle(place)))
    }

    fn ring(&self, place: usize) -> Option<&RingLattice> {
        self.rings.iter().find(|ring| place < ring.to)
    }

    /// Slice `number`, in a fan of its own; `None` if it misses the picture.
    pub(super) fn slice(&self, base: &Fan, own: &Fan, number: usize) -> Option<PlacedSlice> {
        let turns = self.turns;
        let place = self.places.of(number);
        let ring = self.ring(place)?;
        let angle = ring.angle(place);
        // Where slices are turned their angles crowd or thin out, and so must their samples.
        let (angle, crowding) =
            ring.anchor.map_or((angle, 1.0), |anchor| own.angle_through(base, angle, anchor));
        let slice = own.slice(angle, ring.ring)?;
        let phase = (ring.shift_along + self.places.phase(place)).fract();
        let weight_per_area = ring.weight_per_area * crowding;
        let place_rad = crowding * ring.place_rad;
        let turned_rad = match self.draws {
            // To the next slice of the same draw.
            Some(draws) => {
                let widest_rad = WIDEST_SWATH_PX / slice.greatest_separation_px_per_rad();
                Some((place_rad * draws as f64).min(widest_rad))
            }
            None => (turns == 1).then_some(place_rad * self.places.step as f64),
        };
        Some(PlacedSlice {
            slice,
            angle,
            ring: ring.ring,
            turns,
            turn: number % turns,
            phase,
            weight_per_area,
            turned_rad,
        })
    }

    /// The number of a slice among those of its turn.
    pub(super) fn row(&self, number: usize) -> usize {
        number / self.turns
    }

    /// Which draw slice `number` is seen with.
    pub(super) fn draw(&self, number: usize) -> usize {
        let place = self.places.of(number);
        self.draws.map_or(place, |draws| place % draws)
    }
}

impl RingLattice {
    /// At which angle of the base fan a place lies.
    fn angle(&self, place: usize) -> f64 {
        self.first_rad + (place - self.from) as f64 * self.place_rad
    }
}

impl PlacedSlice {
    /// How far the swath that it stands for reaches to either side, pixels, where it has passed so much of its area per radian; 0 without one.
    pub(super) fn half_swath_px(&self, area_per_rad: f64) -> f64 {
        let turned_rad = self.turned_rad.unwrap_or(0.0);
        // No filter sees farther.
        (0.5 * turned_rad * self.slice.separation_px_per_rad_at(area_per_rad)).min(1.0)
    }

    /// Whether it stands for what lies between it and the next slices.
    pub(super) fn has_swath(&self) -> bool {
        self.turned_rad.is_some()
    }

    /// By how many lines its swath counts, of which it is the middle one.
    pub(super) fn swath_lines(&self) -> i32 {
        let width_px = self.turned_rad.unwrap_or(0.0) * self.slice.greatest_separation_px_per_rad();
        if width_px < WIDE_SWATH_PX { 3 } else { 5 }
    }

    /// The others: slices of its fan `own`, and by how much they are turned, radians.
    pub(super) fn swath_beside(&self, own: &Fan) -> impl Iterator<Item = (Slice, f64)> {
        let lines = self.swath_lines();
        let line_rad = self.turned_rad.unwrap_or(0.0) / f64::from(lines);
        let beside = (0..lines).map(move |line| line - lines / 2).filter(|line| *line != 0);
        beside.filter_map(move |line| {
            let turn = line_rad * f64::from(line);
            Some((own.slice(self.angle + turn, self.ring)?, turn))
        })
    }

    /// Its chords in those pixels that are to be seen.
    pub(super) fn chords(&self, size: Size, seen: &Mask) -> impl Iterator<Item = Chord> {
        let unwanted_around = move |x: usize, y: usize| {
            if self.turns > 1 && turn_of(x, y, self.turns) != self.turn {
                return Some(Window { x, y, width: 1, height: 1 });
            }
            seen.unwanted_around(x, y)
        };
        let weight_per_area = self.weight_per_area;
        self.slice.crossings(size, unwanted_around).map(move |crossing| {
            let Crossing { pixel, .. } = crossing;
            let ([start, end], slopes) = (self.slice.areas(&crossing), self.slice.slopes(&crossing));
            let phase = (self.phase + dither(pixel.0, pixel.1)).fract();
            Chord { pixel, start, end, slopes, phase, weight_per_area }
        })
    }
}

/// Whose turn it is in a pixel.
fn turn_of(x: usize, y: usize, turns: usize) -> usize {
    (dither(x, y) * turns as f64) as usize
}

/// A dither mask, `0..1`, by an additive recurrence in two dimensions (Roberts 2018, "The unreasonable effectiveness of quasirandom
/// sequences").
fn dither(x: usize, y: usize) -> f64 {
    (x as f64 * 0.754_877_666_246_692_7 + y as f64 * 0.569_840_290_998_053_2).fract()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use std::collections::BTreeSet;

    const SIZE: Size = Size { width: 480, height: 270 };

    /// The draws and the widest swaths, pixels, of rounds of 6, 6 and 12 samples under a light that wanders far, where gathering is dear.
    fn drawn(differing: Differing) -> (BTreeSet<usize>, Vec<f64>) {
        let base = Fan::of_pinhole(
            0.7,
            SIZE,
            DVec3::new(0.0, 50_f64.to_radians().sin(), -50_f64.to_radians().cos()),
        );
        let wanted = Mask::all(Window::whole(SIZE));
        let (rings, mut draws, mut swaths) = (OnceLock::new(), BTreeSet::new(), Vec::new());
        for number in 0..3 {
            let round = Round::of_doublings(number, 6, 24, &wanted).expect("not the last");
            let dear = |_: &Slice| 1_000_000;
            let lattice = Lattice::new(&base, Some(differing), &round, &wanted, &dear, &rings, || (0.3, 0.6));
            draws.extend((0..lattice.count()).map(|number| lattice.draw(number)));
            let slices = (0..lattice.count()).filter_map(|number| lattice.slice(&base, &base, number));
            let width_px = |placed: PlacedSlice| {
                Some(placed.turned_rad? * placed.slice.greatest_separation_px_per_rad())
            };
            swaths.extend(slices.map(width_px).map(|width| width.unwrap_or(0.0)).reduce(f64::max));
        }
        (draws, swaths)
    }

    /// The rounds together have 12 slices to a pixel's width, and each of 12 draws has one.
    #[test]
    fn far_wanderers_share_draws_a_pixel_apart() {
        let (draws, swaths) = drawn(Differing { deviation_rad: 0.016, ..Differing::default() });
        assert!(draws.into_iter().eq(0..12));
        // By the mean one, at the widest place somewhat more.
        assert!(swaths.iter().all(|width| (1.0..=2.000001).contains(width)), "{swaths:?}");
    }

    #[test]
    fn lamps_and_open_shutters_have_a_draw_for_each_slice() {
        for (in_time, in_brightness) in [(true, false), (false, true)] {
            let (draws, swaths) = drawn(Differing { deviation_rad: 0.016, in_time, in_brightness });
            assert!(draws.len() > 1000 && swaths[0] == 0.0, "{} {swaths:?}", draws.len());
        }
    }
}
