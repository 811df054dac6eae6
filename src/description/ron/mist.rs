//! Mist that drifts, as a scene file says it. Invariant: what cannot be is refused where it is read.

use super::defaults::zero;
use super::keyed::Keyed;
use super::number::{AirVelocity, Finite, NonNegative, Number, Positive, UnitInterval, Vector, Whole};
use glam::DVec3;
use serde::Deserialize;

/// Billows of mist that drift.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mist {
    /// How wide the largest are.
    pub size_m: Number<Positive>,
    /// Sizes of billows: each half of the one before.
    #[serde(default = "four")]
    pub octaves: Whole<1, 8>,
    /// The share of the box that they fill.
    #[serde(default = "half")]
    pub cover: Keyed<Number<UnitInterval>>,
    /// What carries them.
    #[serde(default = "still_air")]
    pub wind_m_per_s: Keyed<Vector<AirVelocity>>,
    /// How often they have turned over.
    #[serde(default = "zero")]
    pub evolution_turns: Keyed<Number<Finite>>,
    /// Their form as a whole.
    #[serde(default)]
    pub shape: MistShape,
    /// Over how far that fades.
    pub edge_m: Option<Number<NonNegative>>,
    /// Name of an object that heights count from.
    pub ground: Option<String>,
    /// Another seed, other billows.
    #[serde(default)]
    pub seed: u32,
    /// How far apart density is computed.
    pub voxel_m: Option<Number<Positive>>,
}

/// The form of mist in its box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum MistShape {
    /// All of it, faded at the sides and at the top.
    #[default]
    Box,
    /// What touches all of its sides, faded all around.
    Ellipsoid,
}

fn four() -> Whole<1, 8> {
    Whole(4)
}

fn half() -> Keyed<Number<UnitInterval>> {
    Keyed::Plain(Number::new(0.5))
}

fn still_air() -> Keyed<Vector<AirVelocity>> {
    Keyed::Plain(Vector::new(DVec3::ZERO))
}
