//! Request for slices, shared by all of a draw. It is data alone. Invariant: the fan's eye and axis are
//! those of the snapshot's view and of the light.

use super::fan::Fan;
use crate::color::Rgb;
use crate::snapshot::{FrozenLight, Snapshot};
use crate::transport::path::Transport;

/// Slices to solve, with all that they share.
#[derive(Clone, Copy)]
pub struct SliceJob<'a> {
    /// The frame.
    pub snapshot: &'a Snapshot<'a>,
    /// Settings by which rays that leave the slices are followed.
    pub transport: &'a Transport<'a>,
    /// The slices' light: a light of the snapshot, or a point of one.
    pub light: &'a FrozenLight,
    /// Factor of its light, see [`Sample::hue`](crate::transport::Sample::hue).
    pub hue: Rgb,
    /// Whether emission, the background and indirect light go with this light.
    pub has_rest: bool,
    /// All slices of the light, from where they are seen.
    pub fan: &'a Fan,
}
