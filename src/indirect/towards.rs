//! Basis functions of a direction that scattered light is asked for along. In goes a direction of travel,
//! out come those of all harmonics that fog's last scattering knows. Invariant: none of them depends on the
//! place.

use crate::ordinates::Harmonics;
use crate::ordinates::harmonics::{COUNT, basis, fourth_basis, third_basis};
use crate::ordinates::high_degrees::{HIGH, high_basis};
use glam::DVec3;

/// Basis functions of one direction of travel.
pub(super) struct Towards {
    /// Basis of degrees up to 2, of 3, of 4, and of 5 and 6.
    pub(super) low: [f64; COUNT],
    pub(super) third: [f64; COUNT],
    pub(super) fourth: [f64; COUNT],
    pub(super) high: [f64; HIGH],
    /// Harmonics as layers turn them, where there are layers.
    pub(super) in_layers: Option<Box<Harmonics>>,
}

impl Towards {
    /// `travel` is a unit vector of world space; where there are layers, `in_layers` has its harmonics there.
    pub(super) fn new(travel: DVec3, in_layers: Option<Harmonics>) -> Self {
        Self {
            low: basis(travel),
            third: third_basis(travel),
            fourth: fourth_basis(travel),
            high: high_basis(travel),
            in_layers: in_layers.map(Box::new),
        }
    }
}
