//! Falling leaves: species, emitter and air. In goes RON, out come blocks of leaves. Invariant: lengths,
//! masses and speeds are those of leaves, so that the simulation is stable.

use super::animated::Animated;
use super::defaults::{one, yes};
use super::number::{
    AirSpeed, AirVelocity, ArealMass, Degrees, Finite, GustScale, LeafLength, NonNegative, Number, Point,
    Positive, Span, SpeedGain, Triple, UnitInterval, Vector, Whole,
};
use serde::{Deserialize, Serialize};

/// Maximum number of leaves in all blocks of a scene: each has keys of its own, some 12 kilobytes.
pub const MOST_FALLING: u32 = 50_000;

/// Falling leaves.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Fall {
    /// Number of leaves.
    pub count: Whole<1, MOST_FALLING>,
    /// Seed of the leaves.
    #[serde(default)]
    pub seed: u32,
    /// Kinds of leaves.
    pub species: Vec<Species>,
    /// Region from which they fall.
    pub emitter: Emitter,
    /// Wind.
    #[serde(default)]
    pub wind: Wind,
    /// Weights of their modes of motion; by default each leaf's size and mass decide.
    pub motion: Option<FallMotion>,
    /// Ground on which they come to rest.
    #[serde(default)]
    pub ground: FallGround,
    /// Names of objects that they hit.
    #[serde(default)]
    pub obstacles: Vec<String>,
    /// Range of times of their release.
    #[serde(default)]
    pub release_s: Span<Finite>,
    /// Whether they hang in place before their release; else they are absent.
    #[serde(default = "yes")]
    pub attached: bool,
    /// Factor on the speed of translation and rotation.
    #[serde(default = "one")]
    pub speed: Animated<Number<SpeedGain>>,
    /// Whether the camera sees them; mirrors always do.
    #[serde(default = "yes")]
    pub visible_to_camera: bool,
    /// Whether they cast shadows.
    #[serde(default = "yes")]
    pub casts_shadow: bool,
    /// Whether they are holdouts: black, with alpha 0.
    #[serde(default)]
    pub holdout: bool,
}

/// Kind of leaves.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Species {
    /// Names of meshes, one of which each leaf has.
    pub meshes: Vec<String>,
    /// Names of materials, one of which each leaf has; if empty, the mesh's own.
    #[serde(default)]
    pub materials: Vec<String>,
    /// Colours between which each leaf's factor on its material lies; needs `materials`.
    #[serde(default)]
    pub tint: Vec<Triple<UnitInterval>>,
    /// Weight of this kind among the leaves.
    #[serde(default = "one")]
    pub share: Number<Positive>,
    /// Length from stalk to tip, to which the mesh is scaled.
    pub length_m: Span<LeafLength>,
    /// Width for aerodynamics; the mesh's by default.
    pub width_m: Option<Span<LeafLength>>,
    /// Mass per area.
    #[serde(default = "of_a_leaf")]
    pub areal_mass_kg_per_m2: Span<ArealMass>,
    /// Arch across the leaf, for aerodynamics.
    #[serde(default)]
    pub curl_deg: Span<Degrees>,
}

/// Region from which leaves fall.
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
        /// Half extents.
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
    /// Mean velocity, along the ground.
    pub mean_m_per_s: Animated<Vector<AirVelocity>>,
    /// Velocity that the strongest gust adds.
    pub gust_m_per_s: Animated<Vector<AirVelocity>>,
    /// Time scale of gusts.
    pub gust_s: Number<GustScale>,
    /// Speed of eddies.
    pub eddy_m_per_s: Animated<Number<AirSpeed>>,
    /// Size of eddies.
    pub eddy_m: Number<GustScale>,
    /// Seed of gusts and eddies.
    pub seed: u32,
}

/// Weights of the modes in which leaves fall.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct FallMotion {
    /// Level descent with little rocking.
    pub steady: Number<NonNegative>,
    /// Swinging from side to side.
    pub flutter: Number<NonNegative>,
    /// Tumbling over and over.
    pub tumble: Number<NonNegative>,
    /// Fluttering and tumbling in turn.
    pub chaotic: Number<NonNegative>,
    /// Tumbling along a helix.
    pub helical: Number<NonNegative>,
    /// Circling in a widening spiral.
    pub spiral: Number<NonNegative>,
}

/// Ground on which leaves come to rest.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct FallGround {
    /// Height of level ground.
    pub height_m: Number<Finite>,
    /// Name of an object whose upper side is the ground where it exists.
    pub object: Option<String>,
}

impl Fall {
    /// Creates leaves of one kind, all released at once in calm air.
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
    /// Creates a kind of half-dry, flat leaves of a broadleaved tree, with one mesh and its own material.
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
    /// Calm air.
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

/// Areal mass of half-dry autumn leaves of broadleaved trees.
fn of_a_leaf() -> Span<ArealMass> {
    Span::new(0.08, 0.14)
}
