//! Boxes of homogeneous fog. Invariant: `density_per_m >= 0`, albedo in `0..=1`, `|anisotropy| < 1`.

use super::{NodeIndex, Track};
use crate::color::Rgb;

/// More boxes of fog than this are refused: sets of boxes are bit masks in the inner loops.
pub const MOST_FOGS: usize = 64;

/// Homogeneous fog in the image of the cube `[-1, 1]^3` under its node's transform.
#[derive(Clone, Debug)]
pub struct Fog {
    /// The author's name.
    pub name: String,
    /// World from the cube `[-1, 1]^3`; may be rotated, scaled and sheared, and may move.
    pub node: NodeIndex,
    /// Extinction sigma_t per channel, 1/m: scattering plus absorption.
    pub density_per_m: Track<Rgb>,
    /// Single-scattering albedo sigma_s / sigma_t per channel, `0..=1`.
    pub albedo: Track<Rgb>,
    /// Henyey-Greenstein g, `-1 < g < 1`; forward for `g > 0`.
    pub anisotropy: Track<f64>,
}
