//! Blocks of scattered leaves. In goes RON, out come counts, choices and ranges. Invariant: leaf `i` depends
//! on the block's seed and on `i`, and not on the number of leaves.

use super::defaults::{one, yes};
use super::number::{Degrees, Point, Positive, Span, Triple, UnitInterval, Whole};
use serde::{Deserialize, Serialize};

/// Maximum number of leaves in one scene: each takes a kilobyte, and one line of a file may request them.
pub const MAX_LEAVES: u32 = 1_000_000;

/// Randomly placed copies of meshes, in a box or on a surface.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Leaves {
    /// Number of leaves.
    pub count: Whole<1, MAX_LEAVES>,
    /// Seed of the leaves.
    #[serde(default)]
    pub seed: u32,
    /// Names of meshes, one of which each leaf has.
    pub meshes: Vec<String>,
    /// Names of materials, one of which each leaf has; if empty, the mesh's own.
    #[serde(default)]
    pub materials: Vec<String>,
    /// Colours between which each leaf's factor on its material lies; needs `materials`.
    #[serde(default)]
    pub tint: Vec<Triple<UnitInterval>>,
    /// Name of the object that the leaves follow.
    pub parent: Option<String>,
    /// Smallest coordinates of the box with the leaves.
    pub min_m: Option<Point>,
    /// Largest coordinates of that box.
    pub max_m: Option<Point>,
    /// Name of the object that carries the leaves on its surface, in place of a box.
    pub on: Option<String>,
    /// Range of angles at which tips hang below level; random rotations by default.
    pub droop_deg: Option<Span<Degrees>>,
    /// Range of rotations about the leaf's length, with `droop_deg`.
    pub roll_deg: Option<Span<Degrees>>,
    /// Factor on the mesh's size.
    #[serde(default = "one")]
    pub scale: Span<Positive>,
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

impl Default for Leaves {
    /// One leaf, without a mesh.
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
