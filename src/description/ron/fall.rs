//! A block of leaves that fall: who they are, where they hang, and what the air does. Invariant: its
//! lengths, masses and speeds are those of leaves, so that a fall can be followed in steps.

use super::animated::Animated;
use super::defaults::{one, yes};
use super::number::{
    AirSpeed, AirVelocity, ArealMass, Degrees, Finite, GustScale, LeafLength, NonNegative, Number, Point,
    Positive, Span, SpeedGain, Triple, UnitInterval, Vector, Whole,
};
use serde::{Deserialize, Serialize};

/// Maximum number of leaves in all blocks of a scene: each has keys of its own, some 12 kilobytes.
pub const MOST_FALLING: u32 = 50_000;

/// Leaves that fall as leaves fall.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Fall {
    /// Number of leaves.
    pub count: Whole<1, MOST_FALLING>,
    /// Seed of the leaves.
    #[serde(default)]
    pub seed: u32,
    /// Who falls.
    pub species: Vec<Species>,
    /// Region that they hang in before.
    pub emitter: Emitter,
    /// Wind.
    #[serde(default)]
    pub wind: Wind,
    /// Ways in which they fall; without, as their own size and mass have it.
    pub motion: Option<FallMotion>,
    /// Ground that they come to rest on.
    #[serde(default)]
    pub ground: FallGround,
    /// Names of objects that stop them.
    #[serde(default)]
    pub obstacles: Vec<String>,
    /// Times at which they are let go.
    #[serde(default)]
    pub release_s: Span<Finite>,
    /// Whether they hang there before they are let go; else they are not there yet.
    #[serde(default = "yes")]
    pub attached: bool,
    /// Factor on the speed of falling and turning.
    #[serde(default = "one")]
    pub speed: Animated<Number<SpeedGain>>,
    /// Whether the camera sees them; mirrors do in any case.
    #[serde(default = "yes")]
    pub visible_to_camera: bool,
    /// Whether they keep light from what lies behind them.
    #[serde(default = "yes")]
    pub casts_shadow: bool,
    /// Whether they are holes in the picture: black, with alpha 0.
    #[serde(default)]
    pub holdout: bool,
}

/// One kind of leaf.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Species {
    /// Names of meshes; each leaf is one of them.
    pub meshes: Vec<String>,
    /// Names of materials; each leaf is made of one of them. If empty, of the mesh's own.
    #[serde(default)]
    pub materials: Vec<String>,
    /// Colours of which each leaf has one in between, as a factor on its material; needs `materials`.
    #[serde(default)]
    pub tint: Vec<Triple<UnitInterval>>,
    /// Share of the leaves that are of this kind, in proportion to the others.
    #[serde(default = "one")]
    pub share: Number<Positive>,
    /// Length from stalk to tip: the mesh is scaled to it.
    pub length_m: Span<LeafLength>,
    /// Across, as the air feels it; without, as the mesh has it.
    pub width_m: Option<Span<LeafLength>>,
    /// Mass over area.
    #[serde(default = "of_a_leaf")]
    pub areal_mass_kg_per_m2: Span<ArealMass>,
    /// Arch across the leaf, as the air feels it.
    #[serde(default)]
    pub curl_deg: Span<Degrees>,
}

/// Region that leaves hang in.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
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
        /// Middle.
        center_m: Point,
        /// Half its size.
        radii_m: Vector<Positive>,
    },
    /// Surface of an object's mesh.
    Surface {
        /// Name of the object.
        object: String,
    },
}

/// Motion of the air.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Wind {
    /// Along the ground.
    pub mean_m_per_s: Animated<Vector<AirVelocity>>,
    /// Velocity that the strongest gust adds.
    pub gust_m_per_s: Animated<Vector<AirVelocity>>,
    /// Time from gust to gust.
    pub gust_s: Number<GustScale>,
    /// Speed of the air in eddies.
    pub eddy_m_per_s: Animated<Number<AirSpeed>>,
    /// Their size.
    pub eddy_m: Number<GustScale>,
    /// Seed of gusts and eddies.
    pub seed: u32,
}

/// Shares of the ways in which leaves fall.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct FallMotion {
    /// Level, rocking a little.
    pub steady: Number<NonNegative>,
    /// Swinging from side to side.
    pub flutter: Number<NonNegative>,
    /// Tumbling over and over.
    pub tumble: Number<NonNegative>,
    /// Now the one, now the other.
    pub chaotic: Number<NonNegative>,
    /// Tumbling down a helix.
    pub helical: Number<NonNegative>,
    /// Circling ever wider.
    pub spiral: Number<NonNegative>,
}

/// Ground that leaves come to rest on.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct FallGround {
    /// Height of level ground.
    pub height_m: Number<Finite>,
    /// Name of an object whose upper side is the ground wherever it is.
    pub object: Option<String>,
}

impl Fall {
    /// Leaves of one kind, let go at once in calm air.
    pub fn new(count: u32, species: Species, emitter: Emitter) -> Self {
        Self {
            count: Whole(count),
            seed: 0,
            species: vec![species],
            emitter,
            wind: Wind::default(),
            motion: None,
            ground: FallGround::default(),
            obstacles: Vec::new(),
            release_s: Span::default(),
            attached: true,
            speed: one(),
            visible_to_camera: true,
            casts_shadow: true,
            holdout: false,
        }
    }
}

impl Species {
    /// Half-dry leaves of a broadleaved tree, flat, of one mesh and its own material.
    pub fn new(mesh: &str, length_m: impl Into<Span<LeafLength>>) -> Self {
        Self {
            meshes: vec![mesh.to_owned()],
            materials: Vec::new(),
            tint: Vec::new(),
            share: one(),
            length_m: length_m.into(),
            width_m: None,
            areal_mass_kg_per_m2: of_a_leaf(),
            curl_deg: Span::default(),
        }
    }
}

impl Default for Wind {
    /// Calm.
    fn default() -> Self {
        Self {
            mean_m_per_s: Animated::default(),
            gust_m_per_s: Animated::default(),
            gust_s: 4.0.into(),
            eddy_m_per_s: Animated::default(),
            eddy_m: 2.0.into(),
            seed: 0,
        }
    }
}

/// Autumn leaves of broadleaved trees, half dry.
fn of_a_leaf() -> Span<ArealMass> {
    Span::new(0.08, 0.14)
}
