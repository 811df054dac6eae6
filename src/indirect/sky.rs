//! The sky as a boundary of the solver. In goes a snapshot's sky, out come its means. Invariant: a sky with a
//! part as bright as a sun is not part of the solution, as its shadows have edges.

use crate::ordinates::sky::Sky;
use crate::snapshot::FrozenSky;

/// Whether light straight from the sky is part of the solution.
pub(super) fn has_sky(sky: Option<FrozenSky>) -> bool {
    sky.is_some_and(|sky| !sky.has_sun())
}

/// Sky for the solver; `None` if it lights nothing.
pub(super) fn sky_of(sky: Option<FrozenSky>) -> Option<Sky> {
    let sky = sky.filter(FrozenSky::lights_surfaces)?;
    Some(Sky { cells: sky.means().collect(), lights_medium: sky.lights_fog(), is_part: !sky.has_sun() })
}
