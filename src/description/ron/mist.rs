//! Mist that drifts, as a scene file says it. Invariant: what cannot be is refused where it is read.

use super::animated::Animated;
use super::number::{AirVelocity, Finite, NonNegative, Number, Positive, UnitInterval, Vector, Whole};
use serde::{Deserialize, Serialize};

/// Billows of mist that drift.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Mist {
    /// Width of the largest.
    pub size_m: Number<Positive>,
    /// Sizes of billows: each half of the one before.
    #[serde(default = "four")]
    pub octaves: Whole<1, 8>,
    /// The share of the box that they fill.
    #[serde(default = "half")]
    pub cover: Animated<Number<UnitInterval>>,
    /// Wind that carries them.
    #[serde(default)]
    pub wind_m_per_s: Animated<Vector<AirVelocity>>,
    /// Turns that they have made.
    #[serde(default)]
    pub evolution_turns: Animated<Number<Finite>>,
    /// Their form as a whole.
    #[serde(default)]
    pub shape: MistShape,
    /// Distance over which that fades; half of `size_m` without.
    pub edge_m: Option<Number<NonNegative>>,
    /// Name of an object that heights count from.
    pub ground: Option<String>,
    /// Seed of the billows.
    #[serde(default)]
    pub seed: u32,
    /// Distance between places at which density is computed.
    pub voxel_m: Option<Number<Positive>>,
}

impl Mist {
    /// Four sizes of billows in still air, which fill half of a box.
    pub fn new(size_m: f64) -> Self {
        Self {
            size_m: size_m.into(),
            octaves: four(),
            cover: half(),
            wind_m_per_s: Animated::default(),
            evolution_turns: Animated::default(),
            shape: MistShape::default(),
            edge_m: None,
            ground: None,
            seed: 0,
            voxel_m: None,
        }
    }
}

/// The form of mist in its box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[non_exhaustive]
pub enum MistShape {
    /// All of it, faded at the sides and at the top.
    #[default]
    Box,
    /// An ellipsoid that touches all of its sides, faded all around.
    Ellipsoid,
}

fn four() -> Whole<1, 8> {
    Whole(4)
}

fn half() -> Animated<Number<UnitInterval>> {
    0.5.into()
}
