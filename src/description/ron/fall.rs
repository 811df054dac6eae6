//! A block of leaves that fall: who they are, where they hang, and what the air does. Invariant: its
//! lengths, masses and speeds are those of leaves, so that a fall can be followed in steps.

use super::defaults::{one, yes, zero};
use super::keyed::Keyed;
use super::number::{
    AirSpeed, AirVelocity, ArealMass, Degrees, Finite, GustScale, LeafLength, NonNegative, Number, Point,
    Positive, Span, SpeedGain, Triple, UnitInterval, Vector, Whole,
};
use glam::DVec3;
use serde::Deserialize;

/// More leaves than this in all blocks of a scene are refused: each has keys of its own, some 24 kilobytes.
pub const MOST_FALLING: u32 = 50_000;

/// Leaves that fall as leaves fall.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fall {
    /// How many.
    pub count: Whole<1, MOST_FALLING>,
    /// Another seed, other leaves.
    #[serde(default)]
    pub seed: u32,
    /// Who falls.
    pub species: Vec<Species>,
    /// Where they hang before.
    pub emitter: Emitter,
    /// What the air does.
    #[serde(default)]
    pub wind: Wind,
    /// In which ways they fall; without, as their own size and mass have it.
    pub motion: Option<Motion>,
    /// What they come to rest on.
    #[serde(default)]
    pub ground: FallGround,
    /// Names of objects that stop them.
    #[serde(default)]
    pub obstacles: Vec<String>,
    /// When they are let go.
    #[serde(default = "zero")]
    pub release_s: Span<Finite>,
    /// Whether they hang there before they are let go; else they are not there yet.
    #[serde(default = "yes")]
    pub attached: bool,
    /// Factor on the speed of falling and turning.
    #[serde(default = "own_speed")]
    pub speed: Keyed<Number<SpeedGain>>,
    /// Whether the camera sees them.
    #[serde(default = "yes")]
    pub visible_to_camera: bool,
    /// Whether they keep light from what lies behind them.
    #[serde(default = "yes")]
    pub casts_shadow: bool,
    /// Whether they are holes in the picture.
    #[serde(default)]
    pub holdout: bool,
}

/// One kind of leaf.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Species {
    /// Names of meshes; each leaf is one of them.
    pub meshes: Vec<String>,
    /// Names of materials; each leaf is made of one of them. If empty, of the mesh's own.
    #[serde(default)]
    pub materials: Vec<String>,
    /// Colours of which each leaf has one in between, as a factor on its material.
    #[serde(default)]
    pub tint: Vec<Triple<UnitInterval>>,
    /// How many of the leaves are of this kind, in proportion to the others.
    #[serde(default = "one")]
    pub share: Number<Positive>,
    /// From stalk to tip: the mesh is scaled to it.
    pub length_m: Span<LeafLength>,
    /// Across, as the air feels it; without, as the mesh has it.
    pub width_m: Option<Span<LeafLength>>,
    /// Mass over area.
    #[serde(default = "of_a_leaf")]
    pub areal_mass_kg_per_m2: Span<ArealMass>,
    /// How far it is arched across, as the air feels it.
    #[serde(default = "zero")]
    pub curl_deg: Span<Degrees>,
}

/// Where leaves hang.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Emitter {
    /// Anywhere in a box.
    Box {
        /// Smallest coordinates.
        min_m: Point,
        /// Largest coordinates.
        max_m: Point,
    },
    /// Anywhere in an ellipsoid.
    Ellipsoid {
        /// Its middle.
        center_m: Point,
        /// Half its size.
        radii_m: Vector<Positive>,
    },
    /// On the surface of an object's mesh.
    Surface {
        /// Name of the object.
        object: String,
    },
}

/// What the air does.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Wind {
    /// Along the ground.
    pub mean_m_per_s: Keyed<Vector<AirVelocity>>,
    /// What the strongest gust adds.
    pub gust_m_per_s: Keyed<Vector<AirVelocity>>,
    /// From gust to gust.
    pub gust_s: Number<GustScale>,
    /// Speed of the air in eddies.
    pub eddy_m_per_s: Keyed<Number<AirSpeed>>,
    /// Their size.
    pub eddy_m: Number<GustScale>,
    /// Another seed, other gusts and eddies.
    pub seed: u32,
}

/// In which proportion leaves fall in which way.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Motion {
    /// Level, rocking a little.
    pub steady: Number<NonNegative>,
    /// From side to side.
    pub flutter: Number<NonNegative>,
    /// Over and over.
    pub tumble: Number<NonNegative>,
    /// Now the one, now the other.
    pub chaotic: Number<NonNegative>,
    /// Over and over down a helix.
    pub helical: Number<NonNegative>,
    /// In circles that widen.
    pub spiral: Number<NonNegative>,
}

/// What leaves come to rest on.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FallGround {
    /// Height of level ground.
    pub height_m: Number<Finite>,
    /// Name of an object whose upper side is the ground wherever it is.
    pub object: Option<String>,
}

impl Default for Wind {
    fn default() -> Self {
        Self {
            mean_m_per_s: Keyed::Plain(Vector::new(DVec3::ZERO)),
            gust_m_per_s: Keyed::Plain(Vector::new(DVec3::ZERO)),
            gust_s: Number::new(4.0),
            eddy_m_per_s: Keyed::Plain(Number::new(0.0)),
            eddy_m: Number::new(2.0),
            seed: 0,
        }
    }
}

impl Default for FallGround {
    fn default() -> Self {
        Self { height_m: Number::new(0.0), object: None }
    }
}

fn own_speed() -> Keyed<Number<SpeedGain>> {
    Keyed::Plain(Number::new(1.0))
}

/// Autumn leaves of broadleaved trees, half dry.
fn of_a_leaf() -> Span<ArealMass> {
    Span::new(0.08, 0.14)
}
