//! Basis functions of one direction of scattered light. In goes a direction of travel, out come those of all
//! harmonics of fog's last scattering. Invariant: none of them depends on the place.

use crate::ordinates::Harmonics;
use crate::ordinates::harmonics::{COUNT, basis, fourth_basis, third_basis};
use crate::ordinates::high_degrees::{HIGH, high_basis};
use glam::DVec3;

/// Basis functions of one direction of travel.
pub(super) struct Towards {
    /// Basis functions of degrees up to 2, of 3, of 4, and of 5 and 6.
    pub(super) low: [f64; COUNT],
    pub(super) third: [f64; COUNT],
    pub(super) fourth: [f64; COUNT],
    pub(super) high: [f64; HIGH],
    /// Harmonics in the layers' coordinates, where there are layers.
    pub(super) in_layers: Option<Box<Harmonics>>,
}

impl Towards {
    /// Basis functions of `travel`, a unit vector in world space; `in_layers` has its harmonics in the
    /// layers' coordinates, if there are any.
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
