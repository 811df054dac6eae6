//! Radiance of the sky by ordinate. In go means over cells of the sphere, out comes incident radiance.
//! Invariant: an isotropic sky stays isotropic to the last digit.

use super::quadrature::{Ordinate, Quadrature};
use crate::color::Rgb;
use glam::DVec3;

/// Relative deviation below which a sky is isotropic.
const EVEN: f64 = 1e-6;

/// Radiance from outside all matter.
pub(crate) struct Sky {
    /// Mean radiances of cells of equal solid angle, with the directions towards their centres.
    pub(crate) cells: Vec<(DVec3, Rgb)>,
    /// Whether the whole medium scatters it, or oriented scatterers and walls alone.
    pub(crate) lights_medium: bool,
    /// Whether light straight from the sky is part of the solution, or only its scattered light.
    pub(crate) is_part: bool,
}

impl Sky {
    /// Radiance along each ordinate: the mean of the cells nearest to it, or the nearest cell if there are
    /// none.
    pub(crate) fn incident(&self, quadrature: &Quadrature) -> Vec<Rgb> {
        let mut sums = vec![(Rgb::ZERO, 0.0); quadrature.as_slice().len()];
        for (direction, radiance) in &self.cells {
            let (sum, count) = &mut sums[quadrature.nearest(-*direction)];
            *sum += *radiance;
            *count += 1.0;
        }
        let nearest = |travel: DVec3| {
            let closer = |a: &&(DVec3, Rgb), b: &&(DVec3, Rgb)| b.0.dot(travel).total_cmp(&a.0.dot(travel));
            self.cells.iter().max_by(closer).map_or(Rgb::ZERO, |(_, radiance)| *radiance)
        };
        let mean = |((sum, count), ordinate): ((Rgb, f64), &Ordinate)| {
            if count > 0.0 { sum / count } else { nearest(ordinate.direction) }
        };
        sums.into_iter().zip(quadrature.iter()).map(mean).collect()
    }
}

/// Whether radiance is the same along all ordinates.
pub(crate) fn is_isotropic(radiances: &[Rgb]) -> bool {
    radiances.iter().all(|radiance| (*radiance - radiances[0]).abs().cmple(EVEN * radiances[0]).all())
}
