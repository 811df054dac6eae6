//! Fog as ordinates see it. In goes a medium, out come what dims light and what is scattered. Invariant: what
//! is not scattered is not lost either.
//!
//! Harmonics up to l = 2 cannot tell light that is scattered nearly straight ahead from light that is not
//! scattered. Where all orders are wanted, such light counts as not scattered (delta-M, Wiscombe 1977). A
//! sun's light has a direction, so that what fog makes of it first is told up to l = 5; the rest still goes
//! as the sun's own light does. Where orders are counted, every scattering counts.

use crate::color::Rgb;
use crate::fog::{BEAM_DEGREES, Medium};
use crate::scene::Bounces;
use glam::DVec3;

/// Degrees that orders of scattering go on with.
const DEGREES: i32 = 3;

pub(super) struct SweptFog<'a> {
    medium: &'a Medium,
    /// What light loses on its way from order to order.
    pub(super) dimming: Medium,
    /// What a sun's light loses on its way to where it is scattered first.
    dimming_of_suns: Medium,
    has_peaks: bool,
}

impl<'a> SweptFog<'a> {
    pub(super) fn new(medium: &'a Medium, bounces: Bounces) -> Self {
        let has_peaks = bounces != Bounces::All;
        let without = |degrees: i32| if has_peaks { medium.clone() } else { medium.without_peaks(degrees) };
        Self { medium, dimming: without(DEGREES), dimming_of_suns: without(BEAM_DEGREES), has_peaks }
    }

    /// What light of a sun or of a lamp loses before it is scattered.
    pub(super) fn dimming_of(&self, is_of_sun: bool) -> &Medium {
        if is_of_sun { &self.dimming_of_suns } else { self.medium }
    }

    /// What harmonics of each degree get back at a point, 1/m.
    pub(super) fn scattering_at(&self, point: DVec3) -> [Rgb; 3] {
        let peak = self.peak_at(point, DEGREES);
        [0, 1, 2].map(|degree| self.medium.scattering_by_degree_at(point, degree) - peak)
    }

    /// What each degree of a sun's light gets back at a point, 1/m.
    pub(super) fn scattering_of_suns_at(&self, point: DVec3) -> [Rgb; BEAM_DEGREES as usize] {
        let peak = self.peak_of_suns_at(point);
        std::array::from_fn(|degree| self.medium.scattering_by_degree_at(point, degree as i32) - peak)
    }

    /// What counts as not scattered of a sun's light, 1/m.
    pub(super) fn peak_of_suns_at(&self, point: DVec3) -> Rgb {
        self.peak_at(point, BEAM_DEGREES)
    }

    fn peak_at(&self, point: DVec3, degrees: i32) -> Rgb {
        if self.has_peaks { Rgb::ZERO } else { self.medium.peak_at(point, degrees) }
    }
}
