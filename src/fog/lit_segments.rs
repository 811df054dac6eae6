//! Parts of a ray that a light reaches. In go intervals in shadow and dimmed intervals (*veils*), out come
//! the lit parts in order, each with its share of the light. Invariant: the result does not depend on the
//! order in which they are added, to the last bit.

use crate::color::Rgb;
use crate::light::FrozenLight;
use crate::math::{IntervalSet, Ray, RunningProduct};
use std::ops::Range;

/// The parts of a ray that one light reaches.
#[derive(Clone, Debug, Default)]
pub struct LitSegments {
    shadows: IntervalSet,
    range: (f64, f64),
    /// Veils, which dim the lit parts.
    veils: Vec<Veil>,
    /// Start of each piece between the ends of veils, and its transmittance; before the first it is 1.
    pieces: Vec<(f64, Rgb)>,
    /// Product of the veils that cover a piece.
    product: RunningProduct,
}

#[derive(Clone, Copy, Debug)]
struct Veil {
    start: f64,
    end: f64,
    transmittance: Rgb,
}

impl LitSegments {
    /// Parts of `range` outside `shadows`.
    pub fn from_shadows(shadows: IntervalSet, range: (f64, f64)) -> Self {
        Self { shadows, range, ..Self::default() }
    }

    /// Starts anew with a range of a ray that is lit wherever the light emits.
    pub fn start(&mut self, ray: &Ray, light: &FrozenLight, range: (f64, f64)) {
        self.shadows.clear();
        self.veils.clear();
        self.pieces.clear();
        self.range = range;
        // Outside a spot's cone, or behind a flat light, the range counts as shadowed.
        let FrozenLight::Point { position, emission, .. } = light else { return };
        let mut start = range.0;
        for end in emission.borders(ray, *position).into_iter().flatten().chain([range.1]) {
            let end = end.clamp(start, range.1);
            if !emission.reaches(ray.at(0.5 * (start + end)) - *position) {
                self.shadows.insert(start, end);
            }
            start = end;
        }
    }

    /// Range of the ray, metres.
    pub fn range(&self) -> (f64, f64) {
        self.range
    }

    /// Shadows, to which more can be added.
    pub fn shadows_mut(&mut self) -> &mut IntervalSet {
        &mut self.shadows
    }

    /// Dims the light between two places, from the next call of [`LitSegments::resolve`] on.
    pub fn dim(&mut self, start: f64, end: f64, transmittance: Rgb) {
        if transmittance != Rgb::ONE && start < end {
            self.veils.push(Veil { start, end, transmittance });
        }
    }

    /// Multiplies the veils that overlap.
    pub fn resolve(&mut self) {
        let Self { veils, pieces, product, .. } = self;
        let key = |veil: &Veil| {
            let [red, green, blue] = veil.transmittance.to_array();
            [veil.start, veil.end, red, green, blue]
        };
        // A fixed order of factors: rounding must not depend on the tree's order.
        veils.sort_unstable_by(|a, b| {
            let order = key(a).into_iter().zip(key(b)).map(|(a, b)| a.total_cmp(&b));
            order.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        });
        let starts = veils.iter().zip(0..).map(|(veil, index)| (veil.start, index, veil.transmittance));
        let ends = veils.iter().zip(0..).map(|(veil, index)| (veil.end, index, Rgb::ONE));
        let mut changes: Vec<(f64, usize, Rgb)> = starts.chain(ends).collect();
        changes.sort_by(|a, b| a.0.total_cmp(&b.0));
        product.start(veils.len());
        for at_one_place in changes.chunk_by(|a, b| a.0 == b.0) {
            for &(_, veil, factor) in at_one_place {
                product.set(veil, factor);
            }
            pieces.extend(at_one_place.first().map(|(start, ..)| (*start, product.get())));
        }
    }

    /// Calls `lit(start, end, share)` for the lit parts of a range, in order, with the share of the light
    /// there.
    pub fn for_each_part(&self, range: &Range<f64>, mut lit: impl FnMut(f64, f64, Rgb)) {
        self.shadows.for_each_gap(range.start, range.end, |start, end| {
            self.for_each_piece(start, end, &mut lit);
        });
    }

    /// Calls back with the pieces of a part without shadow.
    fn for_each_piece(&self, start: f64, end: f64, mut piece: impl FnMut(f64, f64, Rgb)) {
        let mut next = self.pieces.partition_point(|(from, _)| *from <= start);
        let mut transmittance = if next == 0 { Rgb::ONE } else { self.pieces[next - 1].1 };
        let mut from = start;
        while let Some(&(to, then)) = self.pieces.get(next).filter(|(to, _)| *to < end) {
            piece(from, to, transmittance);
            (from, transmittance) = (to, then);
            next += 1;
        }
        piece(from, end, transmittance);
    }

    /// Intersection of the range with a part of the ray; the end may come before the start.
    pub fn within(&self, start: f64, end: f64) -> Range<f64> {
        start.max(self.range.0)..end.min(self.range.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn overlapping_veils_multiply_in_any_order() {
        let list = [(1.0, 3.0, 0.3), (2.0, 5.0, 0.7), (2.0, f64::INFINITY, 0.9), (0.5, 0.5, 0.1)];
        let pieces = |order: &[usize]| {
            let mut lit = LitSegments::default();
            for &index in order {
                let (start, end, through) = list[index];
                lit.dim(start, end, Rgb::splat(through));
            }
            lit.resolve();
            let mut pieces = Vec::new();
            lit.for_each_piece(0.0, 9.0, |start, end, through| pieces.push((start, end, through.x)));
            pieces
        };
        let found = pieces(&[0, 1, 2, 3]);
        let expected = [
            (0.0, 1.0, 1.0),
            (1.0, 2.0, 0.3),
            (2.0, 3.0, 0.3 * 0.7 * 0.9),
            (3.0, 5.0, 0.7 * 0.9),
            (5.0, 9.0, 0.9),
        ];
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found.0, found.1) == (expected.0, expected.1) && (found.2 - expected.2).abs() < 1e-15);
        }
        assert_eq!(found, pieces(&[3, 2, 1, 0]));
        assert_eq!(found, pieces(&[1, 3, 0, 2]));
    }
}
