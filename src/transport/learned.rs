//! What first walks learn of a scene, so that later ones find its light. In goes sunlit matter that they met,
//! out come beams of suns. Invariant: it depends on the walks alone.

use super::sun_beams::{MetPoint, SunBeams};
use crate::snapshot::{FrozenLight, Snapshot};

/// Points that walks met.
#[derive(Debug, Default)]
pub struct Noted {
    pub(super) on_surfaces: Vec<MetPoint>,
    pub(super) in_fog: Vec<MetPoint>,
}

impl Noted {
    /// Adds those of another walk.
    pub fn extend(&mut self, other: Self) {
        self.on_surfaces.extend(other.on_surfaces);
        self.in_fog.extend(other.in_fog);
    }
}

/// Where walks look for light.
#[derive(Debug, Default)]
pub struct Learned {
    /// Beams that light surfaces.
    pub(super) on_surfaces: SunBeams,
    /// Beams through fog.
    pub(super) in_fog: SunBeams,
}

impl Learned {
    /// By first walks through a scene.
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
