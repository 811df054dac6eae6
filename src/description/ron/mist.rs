//! Drifting mist of a scene file. In goes RON, out comes its description. Invariant: values out of range are
//! refused on reading.

use super::animated::Animated;
use super::number::{AirVelocity, Finite, NonNegative, Number, Positive, UnitInterval, Vector, Whole};
use serde::{Deserialize, Serialize};

/// Drifting mist of noise.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Mist {
    /// Width of the largest billows.
    pub size_m: Number<Positive>,
    /// Number of octaves, each with billows half as wide.
    #[serde(default = "four")]
    pub octaves: Whole<1, 8>,
    /// Fraction of the box that billows fill.
    #[serde(default = "half")]
    pub cover: Animated<Number<UnitInterval>>,
    /// Velocity of the wind that carries them.
    #[serde(default)]
    pub wind_m_per_s: Animated<Vector<AirVelocity>>,
    /// Turns of their evolution.
    #[serde(default)]
    pub evolution_turns: Animated<Number<Finite>>,
    /// Shape of the mist as a whole.
    #[serde(default)]
    pub shape: MistShape,
    /// Distance over which the shape fades; half of `size_m` by default.
    pub edge_m: Option<Number<NonNegative>>,
    /// Name of an object from which heights count.
    pub ground: Option<String>,
    /// Seed of the billows.
    #[serde(default)]
    pub seed: u32,
    /// Size of voxels.
    pub voxel_m: Option<Number<Positive>>,
}

impl Mist {
    /// Creates four octaves of billows in still air, which fill half of a box.
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

/// Shape of mist in its box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[non_exhaustive]
pub enum MistShape {
    /// The whole box, fading at the sides and at the top.
    #[default]
    Box,
    /// The inscribed ellipsoid, fading all around.
    Ellipsoid,
}

fn four() -> Whole<1, 8> {
    Whole(4)
}

fn half() -> Animated<Number<UnitInterval>> {
    0.5.into()
}
