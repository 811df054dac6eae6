//! What slices are seen with: a moment of the shutter, a point of the lens and a point of the
//! light. In goes a number, out comes a draw. Invariant: the first draws, however many, are
//! spread evenly over all that there is, and what has no extent is not drawn at all.
//!
//! Each draw has a fan of slices of its own over all of the picture, and a picture is the mean of theirs. So pixels side by side have seen the same points of
//! the light, and what these have wrong is as smooth as what they light: no grain, and the same in every frame.

use crate::color::Rgb;
use crate::math::SobolPoint;
use crate::snapshot::{Exposure, FrozenLight, Snapshot};
use glam::DVec2;

/// The draws for one light's part of the picture.
pub(super) struct Draws<'a, 'scene> {
    exposure: &'a Exposure<'scene>,
    /// The light, as its index in the snapshots.
    light: usize,
    seed: u32,
}

/// What the slices of a fan are seen with.
pub(super) struct Draw<'a, 'scene> {
    pub(super) snapshot: &'a Snapshot<'scene>,
    /// Metres to the right and up from the middle of the lens.
    pub(super) lens_point: DVec2,
    pub(super) light: FrozenLight,
    /// What its light is to be multiplied by.
    pub(super) hue: Rgb,
    /// By which part of the way to the next one its slices are shifted, and the samples in each of their pieces.
    pub(super) shift: [f64; 2],
}

impl<'a, 'scene> Draws<'a, 'scene> {
    /// The draws for a light.
    pub(super) fn new(exposure: &'a Exposure<'scene>, light: usize, seed: u32) -> Self {
        Self { exposure, light, seed }
    }

    /// Whether there is nothing to draw: all draws are the same but for their shifts.
    pub(super) fn is_single(&self) -> bool {
        let Snapshot { view, lights, .. } = self.exposure.middle();
        self.exposure.is_instant() && !view.has_lens() && lights[self.light].is_delta()
    }

    /// Draw number so many.
    pub(super) fn get(&self, number: usize) -> Draw<'a, 'scene> {
        let Snapshot { view, lights, .. } = self.exposure.middle();
        let mut point = SobolPoint::new(self.seed, self.light as u32, number);
        // What there is not to draw takes no coordinates: the first are the most even.
        let of_light = if lights[self.light].is_delta() { [0.5; 3] } else { point.take() };
        let of_lens = if view.has_lens() { point.take() } else { [0.5; 2] };
        let [time] = if self.exposure.is_instant() { [0.5] } else { point.take() };
        let snapshot = self.exposure.at(time);
        let view = &snapshot.view;
        let lens_point = if view.has_lens() { view.lens_point(of_lens) } else { DVec2::ZERO };
        let (light, hue) = snapshot.lights[self.light].hued_point(of_light);
        Draw { snapshot, lens_point, light, hue, shift: point.take() }
    }
}
