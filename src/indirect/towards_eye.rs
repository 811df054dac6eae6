//! What fog that scatters ahead sends to the eye beyond what nine harmonics tell. In go nodes and a camera,
//! out come moments of radiance about the way to the eye. Invariant: they are of degrees that no harmonic of
//! the field has.
//!
//! From order to order harmonics up to l = 2 are enough, with delta-M. The last scattering, the one that is
//! seen, is of light as it comes along each ordinate, by the fog's own phase function: source function
//! integration (Stamnes & Swanson 1981, "A new look at the discrete ordinate method", section 4). Degrees 3
//! and 4 are known of all directions, the next ones of the way to the eye alone. That way is another from
//! node to node next to the eye, so there they fade.

use super::grid::{Corners, Grid};
use crate::color::Rgb;
use crate::fog::Medium;
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::f64::consts::PI;

/// Degrees of Legendre polynomials beyond the harmonics, up to that for which the ordinates' rule is exact
/// with light of degree 5.
pub(super) const EYE_DEGREES: [i32; 2] = [5, 6];

/// The first degree that light from order to order is not told of.
const FIRST_UNTOLD: i32 = 3;

/// Within so many cells of the eye nothing of them is told, and from so many on all.
const FADES: std::ops::Range<f64> = 1.0..4.0;

/// All degrees that the last scattering in fog knows.
pub(super) const SEEN_DEGREES: usize = 7;

/// The share `g^3` that fog sends on of the first of them, from which on they count.
const LEAST: f64 = 0.02;

/// Moments of radiance about the way to the eye, by node.
pub(super) struct TowardsEye(Vec<[f32; 3 * EYE_DEGREES.len()]>);

impl TowardsEye {
    /// Whether a medium scatters so that they matter.
    pub(super) fn matters(medium: &Medium) -> bool {
        medium.banks().iter().any(|bank| bank.g.abs().powi(FIRST_UNTOLD) > LEAST)
    }

    /// The way to the eye from each node: unit vectors, by axis.
    pub(super) fn ways(grid: &Grid, snapshot: &Snapshot) -> [Vec<f32>; 3] {
        let way = |node: usize| snapshot.view.towards_eye(grid.position(node) - snapshot.view.eye);
        let ways: Vec<DVec3> = (0..grid.count()).map(way).collect();
        [0, 1, 2].map(|axis| ways.iter().map(|way| way[axis] as f32).collect())
    }

    pub(super) fn of(moments: &[[Vec<f32>; EYE_DEGREES.len()]; 3], grid: &Grid, eye: DVec3) -> Self {
        let of_channels = moments.as_flattened();
        let told = |node: usize| {
            let cells = (grid.position(node) - eye).length() / grid.cell_m;
            ((cells - FADES.start) / (FADES.end - FADES.start)).clamp(0.0, 1.0) as f32
        };
        let node = |node: usize| {
            let told = told(node);
            std::array::from_fn(|place| told * of_channels[place][node])
        };
        Self((0..of_channels[0].len()).map(node).collect())
    }

    /// What fog adds that scatters so much of each degree, from 0 on; W m^-3 sr^-1 of 1/m.
    pub(super) fn scattered(&self, corners: &Corners, scattering: &[Rgb; SEEN_DEGREES]) -> Rgb {
        let mut sums = [0.0; 3 * EYE_DEGREES.len()];
        for (&node, &weight) in corners.nodes.iter().zip(&corners.weights) {
            for (sum, value) in sums.iter_mut().zip(&self.0[node]) {
                *sum += weight as f32 * value;
            }
        }
        let mut radiance = Rgb::ZERO;
        for (place, degree) in EYE_DEGREES.into_iter().enumerate() {
            let moment = [0, 1, 2].map(|channel| f64::from(sums[channel * EYE_DEGREES.len() + place]));
            let factor = f64::from(2 * degree + 1) / (4.0 * PI);
            radiance += factor * scattering[degree as usize] * Rgb::from_array(moment);
        }
        radiance
    }
}
