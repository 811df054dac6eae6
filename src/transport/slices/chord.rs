//! Chord: the part of a slice in one pixel. In go a slice and the wanted pixels, out come its chords in
//! order. Invariant: the chords of all pixels are the whole slice, without gap or overlap.

use super::slice::Slice;
use crate::scene::Size;
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

    /// Pixels of a picture that the slice crosses, of those that are wanted.
    pub fn crossings(
        &self,
        size: Size,
        is_wanted: impl Fn(usize, usize) -> bool,
    ) -> impl Iterator<Item = Crossing> {
        let (start_px, along_px) = self.line_px();
        // Steps from border to border by counting (Amanatides & Woo 1987): rounding must not stop a line that
        // is almost parallel to a border between two pixels.
        let mut column = Steps::new(start_px.x, along_px.x, size.width);
        let mut row = Steps::new(start_px.y, along_px.y, size.height);
        let mut at = 0.0_f64;
        let all = iter::from_fn(move || {
            if at >= self.length {
                return None;
            }
            let (pixel, enter) = ((column.at, row.at), at);
            let next = if column.until <= row.until { &mut column } else { &mut row };
            at = next.until.max(at);
            next.step();
            Some(Crossing { pixel, lengths: [enter, at.min(self.length)] })
        });
        all.filter(move |crossing| is_wanted(crossing.pixel.0, crossing.pixel.1))
    }
}

/// A line through the columns of a picture, or through the rows.
struct Steps {
    /// Start, and the step for each unit of length, pixels.
    start_px: f64,
    along_px: f64,
    count: usize,
    /// Current column or row, and the length at which the line leaves it: infinite at the picture's borders,
    /// where the slice ends anyway.
    at: usize,
    until: f64,
}

impl Steps {
    fn new(start_px: f64, along_px: f64, count: usize) -> Self {
        let mut steps = Self { start_px, along_px, count, at: 0, until: 0.0 };
        steps.enter((start_px.max(0.0) as usize).min(count - 1));
        steps
    }

    fn step(&mut self) {
        self.enter(if self.along_px > 0.0 { self.at + 1 } else { self.at.saturating_sub(1) });
    }

    fn enter(&mut self, at: usize) {
        self.at = at;
        self.until = if self.along_px > 0.0 && at + 1 < self.count {
            ((at + 1) as f64 - self.start_px) / self.along_px
        } else if self.along_px < 0.0 && at > 0 {
            (at as f64 - self.start_px) / self.along_px
        } else {
            f64::INFINITY
        };
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
                for crossing in slice.crossings(size, |_, _| true) {
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
    }
}
