//! A block of leaves: one line for hundreds. Invariant: leaf number `i` depends on the block's
//! seed and on `i`, not on how many there are.

use super::defaults::{one, yes};
use super::number::{Degrees, Point, Positive, Span, Triple, UnitInterval, Whole};
use serde::{Deserialize, Serialize};

/// Maximum number of leaves in one scene: each takes a kilobyte, and a file of one line may ask for them.
pub const MAX_LEAVES: u32 = 1_000_000;

/// Seeded copies of meshes, scattered over a box or a surface.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Leaves {
    /// Number of leaves.
    pub count: Whole<1, MAX_LEAVES>,
    /// Seed of the leaves.
    #[serde(default)]
    pub seed: u32,
    /// Names of meshes; each leaf is one of them.
    pub meshes: Vec<String>,
    /// Names of materials; each leaf is made of one of them. If empty, of the mesh's own.
    #[serde(default)]
    pub materials: Vec<String>,
    /// Colours of which each leaf has one in between, as a factor on its material; needs `materials`.
    #[serde(default)]
    pub tint: Vec<Triple<UnitInterval>>,
    /// Name of the object that the leaves follow.
    pub parent: Option<String>,
    /// Smallest coordinates of the box in which the leaves are.
    pub min_m: Option<Point>,
    /// Largest coordinates of that box.
    pub max_m: Option<Point>,
    /// Name of the object on whose surface the leaves sit instead.
    pub on: Option<String>,
    /// Angle at which tips hang below level; any attitude is as likely without.
    pub droop_deg: Option<Span<Degrees>>,
    /// Turn about the leaf's length, beside `droop_deg`.
    pub roll_deg: Option<Span<Degrees>>,
    /// Factor on the mesh's size.
    #[serde(default = "one")]
    pub scale: Span<Positive>,
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

impl Default for Leaves {
    /// One leaf that nobody has named a mesh for.
    fn default() -> Self {
        Self {
            count: Whole(1),
            seed: 0,
            meshes: Vec::new(),
            materials: Vec::new(),
            tint: Vec::new(),
            parent: None,
            min_m: None,
            max_m: None,
            on: None,
            droop_deg: None,
            roll_deg: None,
            scale: one(),
            visible_to_camera: true,
            casts_shadow: true,
            holdout: false,
        }
    }
}
