//! Radiance of the sky as ordinates see it. In go means over cells of the sphere, out comes incident radiance
//! by ordinate. Invariant: an isotropic sky stays so to the last digit.

use super::quadrature::{Ordinate, Quadrature};
use crate::color::Rgb;
use glam::DVec3;

/// Deviation from the mean below which a sky is isotropic.
const EVEN: f64 = 1e-6;

/// Radiance from outside all matter.
pub(crate) struct Sky {
    /// Mean radiances of cells that share out the sphere evenly, with the directions towards their middles.
    pub(crate) cells: Vec<(DVec3, Rgb)>,
    /// Whether all of the medium scatters it, or what is oriented and walls alone.
    pub(crate) lights_medium: bool,
    /// Whether its own light is part of the solution, or only what becomes of it.
    pub(crate) is_part: bool,
}

impl Sky {
    /// Radiance along each ordinate: the mean of the cells that are nearest to it, or the nearest cell.
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
