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

/// Fog at a point, or of a cell on the mean; all 1/m.
#[derive(Default)]
pub(super) struct FogHere {
    pub(super) extinction: Rgb,
    /// What harmonics of each degree get back.
    pub(super) scattering: [Rgb; DEGREES as usize],
    /// The same of a sun's light as it is scattered first, and what of it counts as not scattered.
    pub(super) first_scattering: [Rgb; BEAM_DEGREES as usize],
    pub(super) first_peak: Rgb,
}

impl FogHere {
    /// Adds a share of other fog.
    pub(super) fn add(&mut self, other: &Self, share: f64) {
        self.extinction += share * other.extinction;
        let sums = self.scattering.iter_mut().chain(&mut self.first_scattering);
        for (sum, value) in sums.zip(other.scattering.iter().chain(&other.first_scattering)) {
            *sum += share * *value;
        }
        self.first_peak += share * other.first_peak;
    }
}

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

    /// What it is at a point.
    pub(super) fn at(&self, point: DVec3) -> FogHere {
        let (_, of_degrees) = self.medium.coefficients_at::<{ BEAM_DEGREES as usize }>(point);
        let peak = |degrees: i32| match self.has_peaks {
            true => Rgb::ZERO,
            false => self.medium.peak_at(point, degrees),
        };
        let (of_orders, first_peak) = (peak(DEGREES), peak(BEAM_DEGREES));
        FogHere {
            extinction: self.dimming.extinction_at(point),
            scattering: std::array::from_fn(|degree| of_degrees[degree] - of_orders),
            first_scattering: of_degrees.map(|of_degree| of_degree - first_peak),
            first_peak,
        }
    }
}
