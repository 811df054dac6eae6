//! Angular quadrature: the ordinates along which light is swept. Out come unit vectors and their solid
//! angles. Invariant: each direction has its opposite, and polynomials of the direction up to
//! degree 11 are integrated exactly.

use crate::math::gauss_legendre;
use glam::{DQuat, DVec3};
use std::f64::consts::{PI, TAU};

/// A direction of travel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ordinate {
    pub(crate) direction: DVec3,
    /// Solid angle of the ordinate, sr.
    pub(crate) weight: f64,
}

/// All ordinates of a rule.
pub(crate) struct Quadrature(Vec<Ordinate>);

/// Number of rings of the fine rule, and of directions of each.
const HEIGHTS: usize = 12;
const STEPS: usize = 16;

impl Quadrature {
    pub(crate) const FINE: usize = HEIGHTS * STEPS;

    /// The 50 points of Lebedev's rule of order 11 (Lebedev 1976, "Quadratures on a
    /// sphere", table 1), turned.
    pub(crate) fn new() -> Self {
        const AXES: f64 = 4.0 / 315.0;
        const EDGES: f64 = 64.0 / 2835.0;
        const CORNERS: f64 = 27.0 / 1280.0;
        const FACES: f64 = 14641.0 / 725_760.0;
        let mut points = Vec::with_capacity(50);
        let signs = [-1.0, 0.0, 1.0];
        for x in signs {
            for y in signs {
                for z in signs {
                    let direction = DVec3::new(x, y, z);
                    let share = match direction.abs().element_sum() {
                        1.0 => AXES,
                        2.0 => EDGES,
                        3.0 => CORNERS,
                        _ => continue,
                    };
                    points.push(Ordinate { direction: direction.normalize(), weight: 4.0 * PI * share });
                    if share == CORNERS {
                        for long in 0..3 {
                            let mut direction = direction;
                            direction[long] *= 3.0;
                            points.push(Ordinate {
                                direction: direction.normalize(),
                                weight: 4.0 * PI * FACES,
                            });
                        }
                    }
                }
            }
        }
        points.iter_mut().for_each(|ordinate| ordinate.direction = turned(ordinate.direction));
        Self(points)
    }

    /// Fine rule of 192 ordinates, for light straight from the sky: leaves give it sharp edges. Gauss' rule
    /// in height, equal steps of azimuth.
    pub(crate) fn fine() -> Self {
        let ring = |&(height, weight): &(f64, f64)| {
            let across = (1.0 - height * height).sqrt();
            (0..STEPS).map(move |step| {
                let (sin, cos) = (TAU * (step as f64 + 0.5) / STEPS as f64).sin_cos();
                let direction = DVec3::new(across * cos, height, across * sin);
                Ordinate { direction, weight: weight * TAU / STEPS as f64 }
            })
        };
        Self(gauss_legendre(HEIGHTS).iter().flat_map(ring).collect())
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &Ordinate> {
        self.0.iter()
    }

    pub(crate) fn as_slice(&self) -> &[Ordinate] {
        &self.0
    }

    /// Number of the ordinate nearest to a direction.
    pub(crate) fn nearest(&self, direction: DVec3) -> usize {
        let cosine = |index: &usize| self.0[*index].direction.dot(direction);
        (0..self.0.len()).max_by(|a, b| cosine(a).total_cmp(&cosine(b))).expect("there are 50")
    }
}

/// Rotation after which no ordinate is parallel to the ground, nor to walls at right angles or at 45 degrees.
/// Without it 8 of them are, and integrals over a half sphere are wrong by a fiftieth; with it, by a
/// thousandth.
fn turned(direction: DVec3) -> DVec3 {
    DQuat::from_xyzw(-4.0, 5.0, -6.0, 8.0).normalize() * direction
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_share_out_the_sphere() {
        let quadrature = Quadrature::new();
        assert_eq!(quadrature.as_slice().len(), 50);
        let all: f64 = quadrature.iter().map(|ordinate| ordinate.weight).sum();
        assert!((all - 4.0 * PI).abs() < 1e-12);
        // Mean of x^4 y^4 z^2 over the sphere: 3!! 3!! 1!! / 11!!.
        let mean = |ordinate: &Ordinate| {
            let DVec3 { x, y, z } = ordinate.direction;
            ordinate.weight / (4.0 * PI) * x.powi(4) * y.powi(4) * z.powi(2)
        };
        let mean: f64 = quadrature.iter().map(mean).sum();
        assert!((mean - 9.0 / 10395.0).abs() < 1e-12, "{mean}");
    }
}
