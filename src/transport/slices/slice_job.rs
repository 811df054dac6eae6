//! Input of slices, shared by all slices of a draw. Invariant: the fan's eye and axis are those of the
//! snapshot's view and of the light.

use super::fan::Fan;
use crate::color::Rgb;
use crate::snapshot::{FrozenLight, Snapshot};
use crate::transport::path::Transport;

/// Common input of the slices to solve.
#[derive(Clone, Copy)]
pub struct SliceJob<'a> {
    /// The frame.
    pub snapshot: &'a Snapshot<'a>,
    /// Settings for rays that are traced beyond the slices.
    pub transport: &'a Transport<'a>,
    /// The slices' light: a light of the snapshot, or a point of one.
    pub light: &'a FrozenLight,
    /// Factor of its light, see [`Sample::hue`](crate::transport::Sample::hue).
    pub hue: Rgb,
    /// Whether this light includes the rest: emission, the background and indirect light.
    pub has_rest: bool,
    /// All slices of the light, from a point of the lens.
    pub fan: &'a Fan,
}
