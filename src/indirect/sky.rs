//! The sky as a boundary of the solver. In goes a snapshot's sky, out come its means. Invariant: what part of
//! the sky is as bright as a sun is no part of the field, as its shadows have borders.

use crate::ordinates::sky::Sky;
use crate::snapshot::FrozenSky;

/// Whether the sky's own light is part of the field.
pub(super) fn has_sky(sky: Option<FrozenSky>) -> bool {
    sky.is_some_and(|sky| !sky.has_sun())
}

/// Sky that lights anything at all.
pub(super) fn sky_of(sky: Option<FrozenSky>) -> Option<Sky> {
    let sky = sky.filter(FrozenSky::lights_surfaces)?;
    Some(Sky { cells: sky.means().collect(), lights_medium: sky.lights_fog(), is_part: !sky.has_sun() })
}
