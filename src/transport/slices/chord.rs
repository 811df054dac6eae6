//! Chord: the part of a slice in one pixel. In go a slice and the wanted pixels, out come its chords in
//! order. Invariant: the chords of all pixels are the whole slice, without gap or overlap.

use super::slice::Slice;
use crate::scene::{Size, Window};
use std::iter;

/// Crossing of a slice and a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chord {
    /// Column and row of the full picture.
    pub pixel: (usize, usize),
    /// Area per radian of the slice up to the chord's start.
    pub start: f64,
    /// As `start`, up to the chord's end. A chord that ends where it starts is a single ray.
    pub end: f64,
    /// The slopes of the rays at the start and at the end.
    pub slopes: [f64; 2],
    /// Place of each piece's sample within it, `0..1`.
    pub phase: f64,
    /// Weight of a sample for each unit of area per radian that it represents.
    pub weight_per_area: f64,
    /// Random stream for choices beyond its surfaces: a seed, and the number of its slice for that seed.
    /// Neighbouring slices have successive numbers.
    pub random: (u32, u32),
}

/// A pixel that a slice crosses, with the lengths at which it enters and leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Column and row of the full picture.
    pub pixel: (usize, usize),
    /// Lengths along the slice at which it enters and leaves, in the image plane at distance 1.
    pub lengths: [f64; 2],
}

impl Slice {
    /// A single ray as a chord, in any pixel, where the slice has passed so much of its area per radian.
    pub fn ray(&self, area_per_rad: f64) -> Chord {
        let slope = self.slope_at(self.length_at(area_per_rad));
        Chord {
            pixel: (0, 0),
            start: area_per_rad,
            end: area_per_rad,
            slopes: [slope; 2],
            phase: 0.0,
            weight_per_area: 1.0,
            random: (0, 0),
        }
    }

    /// Area per radian of the slice up to where it enters and leaves a pixel.
    pub fn areas(&self, crossing: &Crossing) -> [f64; 2] {
        let [start, end] = crossing.lengths.map(|length| self.area_at(length));
        [start, end.max(start)]
    }

    /// Slopes of the rays where it enters and leaves.
    pub fn slopes(&self, crossing: &Crossing) -> [f64; 2] {
        crossing.lengths.map(|length| self.slope_at(length))
    }

    /// Pixels of a picture that the slice crosses. `unwanted_around` returns a window of unwanted pixels
    /// around a pixel, which is skipped as a whole.
    pub fn crossings(
        &self,
        size: Size,
        unwanted_around: impl Fn(usize, usize) -> Option<Window>,
    ) -> impl Iterator<Item = Crossing> {
        let (start_px, along_px) = self.line_px();
        // Steps from border to border by counting (Amanatides & Woo 1987): rounding must not stop a line that
        // is almost parallel to a border between two pixels.
        let mut column = Steps::new(start_px.x, along_px.x, size.width);
        let mut row = Steps::new(start_px.y, along_px.y, size.height);
        let mut at = 0.0_f64;
        iter::from_fn(move || {
            while at < self.length {
                let (x, y) = (column.at, row.at);
                let enter = at;
                let Some(passed) = unwanted_around(x, y) else {
                    at = column.until.min(row.until).max(at);
                    if column.until <= row.until {
                        column.step(x, 1);
                    } else {
                        row.step(y, 1);
                    }
                    return Some(Crossing { pixel: (x, y), lengths: [enter, at.min(self.length)] });
                };
                let across = column.exit(passed.x, passed.width);
                let down = row.exit(passed.y, passed.height);
                at = across.min(down).max(at);
                if across <= down {
                    column.step(passed.x, passed.width);
                    row.look(at, passed.y, passed.height);
                } else {
                    row.step(passed.y, passed.height);
                    column.look(at, passed.x, passed.width);
                }
            }
            None
        })
    }
}

/// A line through the columns of a picture, or through the rows.
struct Steps {
    /// Start, and the step for each unit of length, pixels.
    start_px: f64,
    along_px: f64,
    count: usize,
    /// Current column or row, and the length at which the line leaves it.
    at: usize,
    until: f64,
}

impl Steps {
    fn new(start_px: f64, along_px: f64, count: usize) -> Self {
        let mut steps = Self { start_px, along_px, count, at: 0, until: 0.0 };
        steps.look(0.0, 0, count);
        steps
    }

    /// Length at which the line leaves a range; infinite at the picture's borders, where the slice ends
    /// anyway.
    fn exit(&self, low: usize, width: usize) -> f64 {
        if self.along_px > 0.0 && low + width < self.count {
            ((low + width) as f64 - self.start_px) / self.along_px
        } else if self.along_px < 0.0 && low > 0 {
            (low as f64 - self.start_px) / self.along_px
        } else {
            f64::INFINITY
        }
    }

    /// Moves to the first beyond a range.
    fn step(&mut self, low: usize, width: usize) {
        self.enter(if self.along_px > 0.0 { low + width } else { low.saturating_sub(1) });
    }

    /// Moves to the one of a range in which the line is after a length.
    fn look(&mut self, length: f64, low: usize, width: usize) {
        let place = self.start_px + if self.along_px == 0.0 { 0.0 } else { length * self.along_px };
        self.enter((place.max(0.0) as usize).clamp(low, (low + width).min(self.count) - 1));
    }

    fn enter(&mut self, at: usize) {
        self.at = at;
        self.until = self.exit(at, 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::slices::{Fan, Ring};
    use glam::{DVec2, DVec3};
    use proptest::prelude::*;

    /// All slices of a light in a direction, for a camera that looks along -Z.
    fn slices(size: Size, to_light: DVec3, count: u32) -> Vec<Slice> {
        let fan = Fan::of_pinhole(1.0, size, to_light);
        let angle = |number: u32| fan.angles.0 + fan.angles.1 * (f64::from(number) + 0.5) / f64::from(count);
        (0..count).filter_map(|number| fan.slice(angle(number), Ring::WHOLE)).collect()
    }

    fn direction() -> impl Strategy<Value = DVec3> {
        let any = prop::array::uniform3(-1.0..1.0_f64).prop_map(DVec3::from);
        // Also where slices run along the rows, along the columns, and from the picture's middle.
        let special = prop::sample::select(vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Z]);
        prop_oneof![4 => any, 1 => special].prop_filter_map("a direction", |v| v.try_normalize())
    }

    proptest! {
        #[test]
        fn chords_are_the_whole_slice_and_lie_in_their_pixels(
            (width, height) in (1..20_usize, 1..20_usize),
            to_light in direction(),
        ) {
            let size = Size { width, height };
            for slice in slices(size, to_light, 9) {
                let mut at = 0.0;
                for crossing in slice.crossings(size, |_, _| None) {
                    let ((x, y), [start, end]) = (crossing.pixel, slice.areas(&crossing));
                    prop_assert!(start == at && end >= start, "{at} {start} {end}");
                    let middle = slice.place(0.5 * (start + end)).film_px;
                    let from_pixel = (middle - DVec2::new(x as f64 + 0.5, y as f64 + 0.5)).abs().max_element();
                    prop_assert!(from_pixel < 0.5 + 1e-6, "{middle} is not in {x}, {y}");
                    at = end;
                }
                prop_assert!((at / slice.area_per_rad - 1.0).abs() < 1e-9, "{at} {}", slice.area_per_rad);
            }
        }

        #[test]
        fn what_nobody_wants_is_passed_over_and_nothing_else(to_light in direction()) {
            let size = Size { width: 17, height: 13 };
            let rectangle = Window { x: 4, y: 0, width: 8, height: 8 };
            let hole = |x: usize, y: usize| rectangle.index(x, y).map(|_| rectangle);
            for slice in slices(size, to_light, 9) {
                let inside = |(x, y): (usize, usize)| rectangle.index(x, y).is_some();
                let is_long = |crossing: &Crossing| {
                    let [start, end] = slice.areas(crossing);
                    end - start > 1e-6 * slice.area_per_rad
                };
                let wanted = slice.crossings(size, |_, _| None).filter(|crossing| !inside(crossing.pixel));
                let found: Vec<_> = slice.crossings(size, hole).collect();
                let expected: Vec<_> = wanted.filter(is_long).collect();
                let found_long: Vec<_> =
                    found.iter().copied().filter(is_long).collect();
                prop_assert_eq!(found_long.len(), expected.len());
                for (a, b) in found_long.iter().zip(&expected) {
                    let is_same = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()) < 1e-6;
                    prop_assert!(a.pixel == b.pixel && is_same(slice.areas(a), slice.areas(b)), "{a:?} {b:?}");
                }
            }
        }
    }
}
