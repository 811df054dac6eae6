//! Delta-scaled fog, for discrete ordinates. In goes a medium, out come extinction and scattering
//! coefficients. Invariant: scaling removes as much extinction as scattering.
//!
//! Harmonics up to l = 2 cannot separate light scattered nearly straight ahead from unscattered light. Where
//! all orders are computed, such light counts as unscattered (delta-M, Wiscombe 1977). A sun's light has a
//! direction, so its first scattering has degrees up to l = 5; light within its forward peak still travels as
//! the sun's own. Where orders are counted, every scattering counts.

use crate::color::Rgb;
use crate::fog::{BEAM_DEGREES, FogBank, Medium};
use crate::ordinates::first_collision_source::FIRST_DEGREES;
use crate::scene::Bounces;
use glam::DVec3;

/// Number of degrees between orders of scattering.
const DEGREES: i32 = 3;

/// Coefficients of fog at a point, or their mean over a cell; all in 1/m.
#[derive(Default)]
pub(crate) struct FogCoefficients {
    pub(crate) extinction: Rgb,
    /// Scattering coefficient of each degree.
    pub(crate) scattering: [Rgb; DEGREES as usize],
    /// Coefficients for the first scattering of a sun's light, and those of its forward peak.
    pub(crate) first_scattering: [Rgb; FIRST_DEGREES],
    pub(crate) first_peak: Rgb,
    /// Emission in each direction, W m^-3 sr^-1.
    pub(crate) emission: Rgb,
}

impl FogCoefficients {
    /// Adds a share of other fog.
    pub(crate) fn add(&mut self, other: &Self, share: f64) {
        self.extinction += share * other.extinction;
        let sums = self.scattering.iter_mut().chain(&mut self.first_scattering);
        for (sum, value) in sums.zip(other.scattering.iter().chain(&other.first_scattering)) {
            *sum += share * *value;
        }
        self.first_peak += share * other.first_peak;
        self.emission += share * other.emission;
    }
}

/// Whether a bank scatters forward so strongly that degrees beyond those of the orders matter.
pub(crate) fn scatters_ahead(bank: &FogBank) -> bool {
    /// Minimum coefficient `g^3` of the first of those degrees.
    const LEAST: f64 = 0.02;
    bank.g.abs().powi(DEGREES) > LEAST
}

pub(crate) struct DeltaScaledFog<'a> {
    medium: &'a Medium,
    /// Origin in world space.
    pub(crate) eye: DVec3,
    /// Medium with the extinction of light between orders.
    pub(crate) dimming: Medium,
    /// Medium with the extinction of a sun's light before its first collision.
    dimming_of_suns: Medium,
    is_delta_scaled: bool,
}

impl<'a> DeltaScaledFog<'a> {
    pub(crate) fn new(medium: &'a Medium, eye: DVec3, bounces: Bounces) -> Self {
        let is_delta_scaled = bounces == Bounces::All;
        let without =
            |degrees: i32| if is_delta_scaled { medium.without_peaks(degrees) } else { medium.clone() };
        Self {
            medium,
            eye,
            dimming: without(DEGREES),
            dimming_of_suns: without(BEAM_DEGREES),
            is_delta_scaled,
        }
    }

    /// Medium with the extinction of a sun's or of a lamp's light before its first collision.
    pub(crate) fn dimming_of(&self, is_of_sun: bool) -> &Medium {
        if is_of_sun { &self.dimming_of_suns } else { self.medium }
    }

    /// Whether some fog emits.
    pub(crate) fn emits(&self) -> bool {
        self.medium.emits()
    }

    pub(crate) fn at(&self, point: DVec3) -> FogCoefficients {
        let (_, of_degrees) = self.medium.coefficients_at::<FIRST_DEGREES>(point);
        let peak =
            |degrees: i32| if self.is_delta_scaled { self.medium.peak_at(point, degrees) } else { Rgb::ZERO };
        let (of_orders, first_peak) = (peak(DEGREES), peak(BEAM_DEGREES));
        FogCoefficients {
            extinction: self.dimming.extinction_at(point),
            scattering: std::array::from_fn(|degree| of_degrees[degree] - of_orders),
            first_scattering: of_degrees.map(|of_degree| of_degree - first_peak),
            first_peak,
            emission: self.medium.emission_at(point),
        }
    }
}

const _: () = assert!(FIRST_DEGREES == BEAM_DEGREES as usize, "both tell as much of a sun's light");
