//! Leaves that fall, for programs that make scenes. In go numbers, out come the fields of a file. Invariant:
//! names, units, ranges and defaults are those of docs/scene-format.md. Ranges are `[low, high]`.

use super::animated::Animated;
use serde::Serialize;

/// Leaves that fall as leaves fall.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fall {
    /// How many; at most 50,000 in all blocks.
    pub count: u32,
    /// Another seed, other leaves.
    pub seed: u32,
    /// Who falls; at least one kind.
    pub species: Vec<Species>,
    /// Where they hang before.
    pub emitter: Emitter,
    /// What the air does.
    pub wind: Wind,
    /// In which ways they fall; without, as their own size and mass have it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<FallMotion>,
    /// What they come to rest on.
    pub ground: FallGround,
    /// Names of objects that stop them.
    pub obstacles: Vec<String>,
    /// When they are let go.
    pub release_s: [f64; 2],
    /// Whether they hang there before they are let go; else they are not there yet.
    pub attached: bool,
    /// Factor on the speed of falling and turning.
    pub speed: Animated<f64>,
    /// Whether the camera sees them; mirrors do in any case.
    pub visible_to_camera: bool,
    /// Whether they keep light from what lies behind them.
    pub casts_shadow: bool,
    /// Whether they are holes in the picture: black, with alpha 0.
    pub holdout: bool,
}

/// One kind of leaf.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Species {
    /// Names of meshes; each leaf is one of them.
    pub meshes: Vec<String>,
    /// Names of materials; each leaf is made of one of them. If empty, of the mesh's own.
    pub materials: Vec<String>,
    /// Colours of which each leaf has one in between, as a factor on its material; needs `materials`.
    pub tint: Vec<[f64; 3]>,
    /// How many of the leaves are of this kind, in proportion to the others.
    pub share: f64,
    /// From stalk to tip: the mesh is scaled to it.
    pub length_m: [f64; 2],
    /// Across, as the air feels it; without, as the mesh has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_m: Option<[f64; 2]>,
    /// Mass over area.
    pub areal_mass_kg_per_m2: [f64; 2],
    /// How far it is arched across, as the air feels it.
    pub curl_deg: [f64; 2],
}

/// Where leaves hang.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Emitter {
    /// Anywhere in a box.
    Box {
        /// Smallest coordinates.
        min_m: [f64; 3],
        /// Largest coordinates.
        max_m: [f64; 3],
    },
    /// Anywhere in an ellipsoid.
    Ellipsoid {
        /// Its middle.
        center_m: [f64; 3],
        /// Half its size.
        radii_m: [f64; 3],
    },
    /// On the surface of an object's mesh.
    Surface {
        /// Name of the object.
        object: String,
    },
}

/// What the air does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wind {
    /// Along the ground.
    pub mean_m_per_s: Animated<[f64; 3]>,
    /// What the strongest gust adds.
    pub gust_m_per_s: Animated<[f64; 3]>,
    /// From gust to gust.
    pub gust_s: f64,
    /// Speed of the air in eddies.
    pub eddy_m_per_s: Animated<f64>,
    /// Their size.
    pub eddy_m: f64,
    /// Another seed, other gusts and eddies.
    pub seed: u32,
}

/// In which proportion leaves fall in which way.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FallMotion {
    /// Level, rocking a little.
    pub steady: f64,
    /// From side to side.
    pub flutter: f64,
    /// Over and over.
    pub tumble: f64,
    /// Now the one, now the other.
    pub chaotic: f64,
    /// Over and over down a helix.
    pub helical: f64,
    /// In circles that widen.
    pub spiral: f64,
}

/// What leaves come to rest on.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FallGround {
    /// Height of level ground.
    pub height_m: f64,
    /// Name of an object whose upper side is the ground wherever it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub object: Option<String>,
}

impl Fall {
    /// So many leaves of one kind, let go at once in calm air.
    pub fn new(count: u32, species: Species, emitter: Emitter) -> Self {
        Self {
            count,
            seed: 0,
            species: vec![species],
            emitter,
            wind: Wind::default(),
            motion: None,
            ground: FallGround::default(),
            obstacles: Vec::new(),
            release_s: [0.0; 2],
            attached: true,
            speed: 1.0.into(),
            visible_to_camera: true,
            casts_shadow: true,
            holdout: false,
        }
    }
}

impl Species {
    /// Half-dry leaves of a broadleaved tree, flat, of one mesh and its own material.
    pub fn new(mesh: &str, length_m: [f64; 2]) -> Self {
        Self {
            meshes: vec![mesh.to_owned()],
            materials: Vec::new(),
            tint: Vec::new(),
            share: 1.0,
            length_m,
            width_m: None,
            areal_mass_kg_per_m2: [0.08, 0.14],
            curl_deg: [0.0; 2],
        }
    }
}

impl Default for Wind {
    /// Calm.
    fn default() -> Self {
        Self {
            mean_m_per_s: [0.0; 3].into(),
            gust_m_per_s: [0.0; 3].into(),
            gust_s: 4.0,
            eddy_m_per_s: 0.0.into(),
            eddy_m: 2.0,
            seed: 0,
        }
    }
}
