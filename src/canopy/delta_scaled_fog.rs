//! Delta-scaled fog, as ordinates see it. In goes a medium, out come extinction and scattering coefficients.
//! Invariant: what is not scattered is not lost either.
//!
//! Harmonics up to l = 2 cannot tell light that is scattered nearly straight ahead from light that is not
//! scattered. Where all orders are wanted, such light counts as not scattered (delta-M, Wiscombe 1977). A
//! sun's light has a direction, so that what fog makes of it first is told up to l = 5; the rest still goes
//! as the sun's own light does. Where orders are counted, every scattering counts.

use crate::color::Rgb;
use crate::fog::{BEAM_DEGREES, Medium};
use crate::ordinates::first_collision_source::FIRST_DEGREES;
use crate::scene::Bounces;
use glam::DVec3;

/// Degrees that orders of scattering go on with.
const DEGREES: i32 = 3;

/// Fog at a point, or of a cell on the mean; all 1/m.
#[derive(Default)]
pub(crate) struct FogCoefficients {
    pub(crate) extinction: Rgb,
    /// Scattering coefficient of each degree.
    pub(crate) scattering: [Rgb; DEGREES as usize],
    /// Scattering coefficients of a sun's light as it is scattered first, and its forward peak.
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

/// Whether fog scatters ahead so strongly that degrees of light beyond those of the orders matter.
pub(crate) fn scatters_ahead(medium: &Medium) -> bool {
    /// The share `g^3` that it sends on of the first of those degrees.
    const LEAST: f64 = 0.02;
    medium.banks().iter().any(|bank| bank.g.abs().powi(DEGREES) > LEAST)
}

pub(crate) struct DeltaScaledFog<'a> {
    medium: &'a Medium,
    /// Origin in world space.
    pub(crate) eye: DVec3,
    /// Extinction of light on its way from order to order.
    pub(crate) dimming: Medium,
    /// Extinction of a sun's light on its way to its first collision.
    dimming_of_suns: Medium,
    has_peaks: bool,
}

impl<'a> DeltaScaledFog<'a> {
    pub(crate) fn new(medium: &'a Medium, eye: DVec3, bounces: Bounces) -> Self {
        let has_peaks = bounces != Bounces::All;
        let without = |degrees: i32| if has_peaks { medium.clone() } else { medium.without_peaks(degrees) };
        Self { medium, eye, dimming: without(DEGREES), dimming_of_suns: without(BEAM_DEGREES), has_peaks }
    }

    /// Extinction of light of a sun or of a lamp before its first collision.
    pub(crate) fn dimming_of(&self, is_of_sun: bool) -> &Medium {
        if is_of_sun { &self.dimming_of_suns } else { self.medium }
    }

    /// Whether something in it shines.
    pub(crate) fn shines(&self) -> bool {
        self.medium.shines()
    }

    /// Coefficients at a point.
    pub(crate) fn at(&self, point: DVec3) -> FogCoefficients {
        let (_, of_degrees) = self.medium.coefficients_at::<FIRST_DEGREES>(point);
        let peak = |degrees: i32| match self.has_peaks {
            true => Rgb::ZERO,
            false => self.medium.peak_at(point, degrees),
        };
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
