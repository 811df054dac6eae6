//! Guiding of random walks by earlier ones. In go sunlit points that first walks met, out come beams of suns
//! that later walks sample. Invariant: beams depend on the walks alone.

use super::sun_beams::{MetPoint, SunBeams};
use crate::snapshot::{FrozenLight, Snapshot};

/// Points that walks met.
#[derive(Debug, Default)]
pub struct Noted {
    pub(super) on_surfaces: Vec<MetPoint>,
    pub(super) in_fog: Vec<MetPoint>,
}

impl Noted {
    /// Adds the points of another walk.
    pub fn extend(&mut self, other: Self) {
        self.on_surfaces.extend(other.on_surfaces);
        self.in_fog.extend(other.in_fog);
    }
}

/// Beams that guide walks to light.
#[derive(Debug, Default)]
pub struct Learned {
    /// Beams that light surfaces.
    pub(super) on_surfaces: SunBeams,
    /// Beams through fog.
    pub(super) in_fog: SunBeams,
}

impl Learned {
    /// Beams through the points that first walks met.
    pub fn of(noted: &Noted, snapshot: &Snapshot) -> Self {
        let beams = |met: &[MetPoint]| {
            SunBeams::learned(met, |light| match snapshot.lights[light].centre() {
                FrozenLight::Sun { to_light, .. } => Some(to_light),
                FrozenLight::Point { .. } => None,
            })
        };
        Self { on_surfaces: beams(&noted.on_surfaces), in_fog: beams(&noted.in_fog) }
    }
}
