//! What each slice is seen with: a moment of the shutter, a point of the lens and a point of the
//! light. In goes a slice's number, out comes its draw. Invariant: draws of neighbouring slices are
//! spread evenly over all that there is, and what has no extent is not drawn at all.

use crate::math::{Sampler, kronecker};
use crate::snapshot::{Exposure, FrozenLight, Snapshot};
use glam::DVec2;

/// How many draws show how far the fans wander.
const PROBES: usize = 64;

/// The draws of one pass over one light's part of the picture.
pub(super) struct Draws<'a, 'scene> {
    exposure: &'a Exposure<'scene>,
    /// The light, as its index in the snapshots.
    light: usize,
    shifts: [f64; 6],
}

/// A slice's own.
pub(super) struct Draw<'a, 'scene> {
    pub(super) snapshot: &'a Snapshot<'scene>,
    /// Metres to the right and up from the middle of the lens.
    pub(super) lens_point: DVec2,
    pub(super) light: FrozenLight,
}

impl<'a, 'scene> Draws<'a, 'scene> {
    /// The draws for a light, shifted at random.
    pub(super) fn new(exposure: &'a Exposure<'scene>, light: usize, sampler: &mut Sampler) -> Self {
        let pairs = [(); 3].map(|()| sampler.next_2d());
        let [(a, b), (c, d), (e, f)] = pairs;
        Self { exposure, light, shifts: [a, b, c, d, e, f] }
    }

    /// The draw in the middle of everything.
    pub(super) fn middle(&self) -> Draw<'a, 'scene> {
        let snapshot = self.exposure.middle();
        Draw { snapshot, lens_point: DVec2::ZERO, light: snapshot.lights[self.light].centre() }
    }

    /// Slice `number`'s draw.
    pub(super) fn get(&self, number: usize) -> Draw<'a, 'scene> {
        let middle = self.middle();
        let has_lens = middle.snapshot.view.has_lens();
        let [u, v, w, lens_u, lens_v, time] = if has_lens || !self.exposure.is_instant() {
            kronecker(self.shifts, number)
        } else if !middle.snapshot.lights[self.light].is_delta() {
            let [u, v, w, ..] = self.shifts;
            let [u, v, w] = kronecker([u, v, w], number);
            [u, v, w, 0.0, 0.0, 0.0]
        } else {
            return middle;
        };
        let snapshot = self.exposure.at(time);
        let view = &snapshot.view;
        let lens_point = if view.has_lens() { view.lens_point([lens_u, lens_v]) } else { DVec2::ZERO };
        Draw { snapshot, lens_point, light: snapshot.lights[self.light].point([u, v, w]) }
    }

    /// Some draws, to see how far they are spread; none if there is nothing to draw.
    pub(super) fn probes(&self) -> impl Iterator<Item = Draw<'a, 'scene>> {
        let snapshot = self.exposure.middle();
        let is_single =
            self.exposure.is_instant() && !snapshot.view.has_lens() && snapshot.lights[self.light].is_delta();
        (0..if is_single { 0 } else { PROBES }).map(|number| self.get(number))
    }
}
