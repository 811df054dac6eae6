//! Places of leaves before they fall. In go random numbers, out come points. Invariant: points lie on a grid.
//! It is finer than one can see, and coarse enough to absorb the last bits of a scene's transforms, which
//! machines may round differently.

use crate::math::Chance;
use glam::DVec3;
use std::f64::consts::TAU;

/// Grid points per metre, a power of two. Without the grid a chaotic fall would amplify last bits within
/// seconds.
pub(super) const GRID_PER_M: f64 = 1_048_576.0;

/// Region of a tree's crown.
#[derive(Clone, Debug)]
pub(crate) enum Emitter {
    /// A box by its smallest and largest coordinates.
    Box(DVec3, DVec3),
    Ellipsoid(DVec3, DVec3),
    Surface(Surface),
}

/// Triangles with their cumulative areas.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    triangles: Vec<[DVec3; 3]>,
    areas: Vec<f64>,
}

impl Surface {
    /// Surface of triangles; `None` without area.
    pub(crate) fn new(triangles: Vec<[DVec3; 3]>) -> Option<Self> {
        let mut sum = 0.0;
        let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
        let areas: Vec<f64> = triangles
            .iter()
            .map(|triangle| {
                sum += area(triangle);
                sum
            })
            .collect();
        (sum > 0.0).then_some(Self { triangles, areas })
    }

    /// Point of the surface for three numbers in `[0, 1)`, uniform by area.
    pub(crate) fn place(&self, [u1, u2, u3]: [f64; 3]) -> DVec3 {
        let last = self.areas.len() - 1;
        let at = u1 * self.areas[last];
        let [a, b, c] = self.triangles[self.areas.partition_point(|&area| area <= at).min(last)];
        // Uniform over a triangle (Turk, Graphics Gems, 1990).
        let root = u2.sqrt();
        a * (1.0 - root) + b * (root * (1.0 - u3)) + c * (root * u3)
    }
}

impl Emitter {
    /// Height that no leaf exceeds.
    pub(crate) fn highest_m(&self) -> f64 {
        match self {
            Self::Box(_, high) => high.y,
            Self::Ellipsoid(center, radii) => center.y + radii.y,
            Self::Surface(surface) => {
                surface.triangles.iter().flatten().map(|corner| corner.y).fold(f64::NEG_INFINITY, f64::max)
            }
        }
    }

    /// Place of a leaf, uniform, from three draws.
    pub(crate) fn place(&self, chance: Chance, draw: u64) -> DVec3 {
        let numbers = [chance.at(draw), chance.at(draw + 1), chance.at(draw + 2)];
        let place = match self {
            Self::Box(low, high) => *low + (*high - *low) * DVec3::from_array(numbers),
            Self::Ellipsoid(center, radii) => {
                let [u1, u2, u3] = numbers;
                let y = 1.0 - 2.0 * u1;
                let (sin, cos) = libm::sincos(TAU * u2);
                let around = (1.0 - y * y).max(0.0).sqrt();
                *center + *radii * DVec3::new(around * cos, y, around * sin) * libm::cbrt(u3)
            }
            Self::Surface(surface) => surface.place(numbers),
        };
        (place * GRID_PER_M).round() / GRID_PER_M
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn places(emitter: &Emitter) -> Vec<DVec3> {
        (0..20_000).map(|leaf| emitter.place(Chance::of(4, leaf), 3)).collect()
    }

    fn mean(places: &[DVec3]) -> DVec3 {
        places.iter().sum::<DVec3>() / places.len() as f64
    }

    #[test]
    fn crowns_are_filled_evenly() {
        let (center, radii) = (DVec3::new(1.0, 5.0, -2.0), DVec3::new(3.0, 1.0, 2.0));
        let inside: Vec<DVec3> = places(&Emitter::Ellipsoid(center, radii))
            .iter()
            .map(|place| (*place - center) / radii)
            .collect();
        assert!(inside.iter().all(|place| place.length() < 1.0 + 1e-5));
        assert!(mean(&inside).length() < 0.01);
        // Half the volume lies within the cube root of a half.
        let near = inside.iter().filter(|place| place.length_squared() < 0.5_f64.powf(2.0 / 3.0)).count();
        assert!((near as f64 / 20_000.0 - 0.5).abs() < 0.01, "{near}");
        let boxed = places(&Emitter::Box(center - radii, center + radii));
        assert!(boxed.iter().all(|place| ((*place - center) / radii).abs().max_element() < 1.0 + 1e-5));
        assert!((mean(&boxed) - center).length() < 0.05);
    }

    #[test]
    fn surfaces_are_covered_by_area() {
        let triangle = |size: f64, x: f64| {
            [DVec3::new(x, 0.0, 0.0), DVec3::new(x + size, 0.0, 0.0), DVec3::new(x, 0.0, size)]
        };
        let surface = Surface::new(vec![triangle(1.0, 0.0), triangle(0.0, 9.0), triangle(2.0, 5.0)]).unwrap();
        let places = places(&Emitter::Surface(surface));
        let on_the_large = places.iter().filter(|place| place.x >= 5.0).count() as f64;
        assert!((on_the_large / 20_000.0 - 0.8).abs() < 0.01);
        assert!(places.iter().all(|place| place.y == 0.0 && place.z >= 0.0));
        assert!(Surface::new(vec![triangle(0.0, 1.0)]).is_none());
    }
}
