//! OpenVDB files. In go bytes, out come grids of numbers with their transforms. Invariant: memory is bounded
//! by the file's size, and every number is finite.

mod blosc;
mod bytes;
mod compression;
mod frames;
mod header;
mod transform;
mod tree;

use super::{Files, LoadError};
use crate::diagnostic::{Diagnostic, Place};
use crate::math::{bounds, corners};
use bytes::{Bytes, Fault, Number, Read};
use glam::{DAffine3, DVec3};
use std::path::Path;

pub use bytes::Value;
pub use frames::{GridFile, GridFiles, load_files};
pub use tree::{Leaf, Tile, Tree};

/// Trees that are read: OpenVDB's name of the type, whether it holds vectors, and how it writes a number.
const READ: [(&str, bool, Number); 6] = [
    ("Tree_float_5_4_3", false, Number::Float),
    ("Tree_double_5_4_3", false, Number::Double),
    ("Tree_int32_5_4_3", false, Number::Int32),
    ("Tree_int64_5_4_3", false, Number::Int64),
    ("Tree_vec3s_5_4_3", true, Number::Float),
    ("Tree_vec3d_5_4_3", true, Number::Double),
];

/// Grid of a file.
#[derive(Debug)]
pub struct Grid {
    /// Name, such as `density`.
    pub name: String,
    /// OpenVDB's type of its tree, such as `Tree_float_5_4_3`.
    pub kind: String,
    /// Scalar values, if it has them.
    pub floats: Option<Floats>,
    /// Vector values, if it has them.
    pub vectors: Option<Vectors>,
    /// Whether each component of a vector belongs to the lower face of its voxel.
    pub is_staggered: bool,
}

/// Values of a grid.
#[derive(Debug)]
pub struct Values<V> {
    /// Transform from voxel coordinates, which are integers at centres, to the grid's own space.
    pub transform: DAffine3,
    /// The values.
    pub tree: Tree<V>,
}

/// Scalar grid.
pub type Floats = Values<f32>;
/// Grid of velocities or colours.
pub type Vectors = Values<[f32; 3]>;

/// Extent of a grid's active values.
#[derive(Debug)]
pub struct Extent {
    /// Number of voxels.
    pub voxels: u64,
    /// Corners of the box around their outer faces, in the grid's own space.
    pub bounds: [DVec3; 2],
    /// Smallest value.
    pub least: f32,
    /// Largest value.
    pub most: f32,
    /// Mean value.
    pub mean: f64,
}

/// Loads all grids of a file, in its order.
///
/// # Errors
/// If the file cannot be read, or is damaged, with the offset of the damage.
pub fn load(path: &Path) -> Result<Vec<Grid>, LoadError> {
    parse(&Files::default().read(path, None)?, path)
}

/// Parses the grids of a file's bytes.
pub fn parse(bytes: &[u8], path: &Path) -> Result<Vec<Grid>, LoadError> {
    let again = "write it again: Blender, Houdini and OpenVDB 3 or later write such files";
    grids(bytes).map_err(|Fault { at, what, remedy }| {
        let found = format!("{what} (byte {at})");
        Diagnostic::error(Place::File(path.to_owned()), found)
            .expected("an OpenVDB file of version 222 to 225, whole, with finite numbers")
            .remedy(remedy.unwrap_or(again))
            .into()
    })
}

fn grids(bytes: &[u8]) -> Read<Vec<Grid>> {
    let bytes = Bytes::new(bytes);
    let entries = header::read(&mut bytes.clone())?;
    let mut grids = Vec::new();
    // Trees must not overlap, as a damaged file may name one many times.
    let mut behind = 0;
    for entry in entries {
        let (mut floats, mut vectors, mut is_staggered) = (None, None, false);
        let read = READ.into_iter().find(|(kind, ..)| *kind == entry.kind && entry.parent.is_empty());
        if let Some((_, is_vectors, one)) = read {
            let mut at = bytes.from(entry.start)?;
            if entry.start < behind {
                return Err(at.fault("a grid begins inside the one before it"));
            }
            let flags = at.u32()?;
            is_staggered = header::is_staggered(&mut at)?;
            let transform = transform::read(&mut at)?;
            let written = [one, if entry.is_half { Number::Half } else { one }];
            if is_vectors {
                vectors = Some(Values { transform, tree: tree::read(&mut at, flags, written)? });
            } else {
                floats = Some(Values { transform, tree: tree::read(&mut at, flags, written)? });
            }
            behind = at.place();
        }
        grids.push(Grid { name: entry.name, kind: entry.kind, floats, vectors, is_staggered });
    }
    Ok(grids)
}

impl<'a, V: Value> Leaf<'a, V> {
    /// Active voxels: places and values.
    pub fn voxels(self) -> impl Iterator<Item = ([i32; 3], V)> + 'a {
        self.places().map(move |(place, value)| {
            let along = [place >> 6, place >> 3 & 7, place & 7];
            (std::array::from_fn(|axis| self.origin[axis].wrapping_add(along[axis] as i32)), value)
        })
    }

    /// Active voxels: places in the block and values.
    pub fn places(self) -> impl Iterator<Item = (usize, V)> + 'a {
        let is_active = move |place: &usize| self.active[place / 8] >> (place % 8) & 1 == 1;
        (0..8 * self.active.len()).filter(is_active).zip(self.values.iter().copied())
    }
}

impl Floats {
    /// Extent of the active values; `None` if there are none.
    pub fn extent(&self) -> Option<Extent> {
        let tiles = self.tree.tiles.iter().map(|tile| (tile.origin, tile.edge, tile.value));
        let leaves = self.tree.leaves().flat_map(Leaf::voxels);
        let (mut voxels, mut sum) = (0, 0.0);
        let [mut low, mut high] = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [mut least, mut most] = [f32::INFINITY, f32::NEG_INFINITY];
        for (origin, edge, value) in tiles.chain(leaves.map(|(voxel, value)| (voxel, 1, value))) {
            let count = (edge as u64).pow(3);
            let origin = DVec3::from(origin.map(f64::from));
            voxels += count;
            sum += count as f64 * f64::from(value);
            (low, high) = (low.min(origin - 0.5), high.max(origin + (f64::from(edge) - 0.5)));
            (least, most) = (least.min(value), most.max(value));
        }
        let corners = corners((low, high)).map(|corner| self.transform.transform_point3(corner));
        let bounds = bounds(corners).into();
        (voxels > 0).then(|| Extent { voxels, bounds, least, most, mean: sum / voxels as f64 })
    }

    /// Smallest active value; `None` if there are none.
    pub fn least(&self) -> Option<f32> {
        let values = self.tree.leaves().flat_map(|leaf| leaf.values);
        values.chain(self.tree.tiles.iter().map(|tile| &tile.value)).copied().reduce(f32::min)
    }
}
