//! Draw of each slice: a moment of the shutter, a point of the lens and a point of the light. In goes a
//! slice's place, out comes its draw. Invariants: after each round, draws of neighbouring slices are well
//! distributed over moments and points. Without an extent nothing is drawn.
//!
//! A pixel has as many slices as samples, side by side. So every short run of draws must be well distributed.
//! A Sobol sequence by place stratifies each aligned run of `2^k`, in one dimension and in two, after any
//! number of rounds. Owen's scrambling leaves no pattern from one run to the next. Additive recurrences have
//! one: it showed as hatching.

use crate::color::Rgb;
use crate::math::PlacedPoints;
use crate::scene::Size;
use crate::snapshot::{Exposure, FrozenLight, Snapshot};
use crate::transport::slices::Fan;
use glam::DVec2;

/// Number of draws by which the deviation of fans is estimated.
const PROBES: usize = 64;

/// The draws for one light's part of the picture.
pub(super) struct Draws<'a, 'scene> {
    exposure: &'a Exposure<'scene>,
    /// The light, as its index in the snapshots.
    light: usize,
    seed: u32,
}

/// Draw of one slice.
pub(super) struct Draw<'a, 'scene> {
    pub(super) snapshot: &'a Snapshot<'scene>,
    /// Metres to the right and up from the middle of the lens.
    pub(super) lens_point: DVec2,
    pub(super) light: FrozenLight,
    /// Hue of the light's point, a factor of its light.
    pub(super) hue: Rgb,
}

impl Draw<'_, '_> {
    /// Fan of the slices that it sees; `None` if the light is where the camera is.
    pub(super) fn fan(&self, size: Size) -> Option<Fan> {
        Fan::new(&self.snapshot.view, size, self.lens_point, self.light.place())
    }
}

impl<'a, 'scene> Draws<'a, 'scene> {
    pub(super) fn new(exposure: &'a Exposure<'scene>, light: usize, seed: u32) -> Self {
        Self { exposure, light, seed }
    }

    /// Whether all draws are the same, as light, lens and shutter have no extent.
    pub(super) fn is_single(&self) -> bool {
        let Snapshot { view, lights, .. } = self.exposure.middle();
        self.exposure.is_instant() && !view.has_lens() && lights[self.light].is_delta()
    }

    /// The draw in the middle of shutter, lens and light.
    pub(super) fn middle(&self) -> Draw<'a, 'scene> {
        let snapshot = self.exposure.middle();
        Draw { snapshot, lens_point: DVec2::ZERO, light: snapshot.lights[self.light].centre(), hue: Rgb::ONE }
    }

    /// The draw of a place. With a period, places that far apart have theirs in the same strata.
    pub(super) fn get(&self, place: usize, period: Option<usize>) -> Draw<'a, 'scene> {
        if self.is_single() {
            return self.middle();
        }
        let Snapshot { view, lights, .. } = self.exposure.middle();
        // Dimensions without an extent take no coordinates: the first coordinates are the best distributed.
        let (seed, light) = (self.seed, self.light as u32);
        let mut points = match period {
            Some(period) => PlacedPoints::in_strata(seed, light, place, period),
            None => PlacedPoints::new(seed, light, place),
        };
        let [time] = if self.exposure.is_instant() { [0.5] } else { points.take() };
        let of_lens = if view.has_lens() { points.take() } else { [0.5; 2] };
        let of_light = if lights[self.light].is_delta() { [0.5; 3] } else { points.take() };
        let snapshot = self.exposure.at(time);
        let view = &snapshot.view;
        let lens_point = if view.has_lens() { view.lens_point(of_lens) } else { DVec2::ZERO };
        let (light, hue) = snapshot.lights[self.light].hued_point(of_light);
        Draw { snapshot, lens_point, light, hue }
    }

    /// Maximum deviation of the draws' fans from the middle one's, radians; 0 if all draws are the same,
    /// `None` if the light is where the camera is.
    pub(super) fn deviation_rad(&self, size: Size) -> Option<f64> {
        let base = self.middle().fan(size)?;
        let probes = (0..if self.is_single() { 0 } else { PROBES })
            .filter_map(|place| self.get(place, None).fan(size));
        Some(probes.map(|fan| base.deviation(&fan)).fold(0.0, f64::max))
    }
}
