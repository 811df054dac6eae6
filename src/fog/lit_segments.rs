//! The parts of a ray that a light reaches. In go intervals in shadow and intervals that are dimmed, out come the lit parts in order, each
//! with the share of the light that is left there. Invariant: what they come from does not matter, a tree of triangles or a sweep.

use super::veils::Veils;
use crate::color::Rgb;
use crate::light::FrozenLight;
use crate::math::{IntervalSet, Ray};
use std::ops::Range;

/// The parts of a ray that one light reaches.
#[derive(Clone, Debug, Default)]
pub struct LitSegments {
    shadows: IntervalSet,
    range: (f64, f64),
    /// What dims the rest of it.
    veils: Veils,
}

impl LitSegments {
    /// What `shadows` leave of `range`.
    pub fn from_shadows(shadows: IntervalSet, range: (f64, f64)) -> Self {
        Self { shadows, range, veils: Veils::default() }
    }

    /// Starts over with a range of a ray that is lit, but for where the light does not shine.
    pub fn start(&mut self, ray: &Ray, light: &FrozenLight, range: (f64, f64)) {
        self.shadows.clear();
        self.veils.clear();
        self.range = range;
        // What lies outside a spot's cone, or behind a flat light, counts as shadow.
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

    /// The range, metres.
    pub fn range(&self) -> (f64, f64) {
        self.range
    }

    /// What lies in shadow, to be added to.
    pub fn shadows_mut(&mut self) -> &mut IntervalSet {
        &mut self.shadows
    }

    /// Dims the light between two places, with [`LitSegments::resolve`] to follow.
    pub fn dim(&mut self, start: f64, end: f64, transmittance: Rgb) {
        self.veils.add(start, end, transmittance);
    }

    /// Multiplies what dims the same parts.
    pub fn resolve(&mut self) {
        self.veils.resolve();
    }

    /// Calls `lit(start, end, share)` for the lit parts of a range, in order, with the share of the light that is left there.
    pub(super) fn for_each_part(&self, range: &Range<f64>, mut lit: impl FnMut(f64, f64, Rgb)) {
        self.shadows.for_each_gap(range.start, range.end, |start, end| {
            self.veils.for_each_piece(start, end, &mut lit);
        });
    }

    /// What the range has of a part of the ray; the end may come before the start.
    pub(super) fn within(&self, start: f64, end: f64) -> Range<f64> {
        start.max(self.range.0)..end.min(self.range.1)
    }
}
