//! Fog as dense as the grids of files. In go files, out come voxels by frame. Invariant: what no fog can be,
//! negative or without bounds, is refused.

use super::FrameRate;
use crate::description::vdb::{Floats, Grid, GridFiles};
use crate::math::{BRICK, SunlitVoxels, Voxels, VoxelsBuilder, VoxelsError};
use glam::{DAffine3, IVec3};
use std::path::PathBuf;
use std::sync::Arc;

/// Default name of a grid of density.
const USUAL_GRID: &str = "density";

/// A grid of a file, or of a file a frame.
#[derive(Clone, Debug)]
pub struct GridFrames {
    /// Path of the file; of a sequence with signs in the number's place.
    pub path: PathBuf,
    /// Name of the grid.
    pub name: String,
    /// Grids by time, at least one.
    pub frames: Vec<GridFrame>,
}

/// A grid about a time.
#[derive(Clone, Debug)]
pub struct GridFrame {
    /// Time of the grid; it is there where no other's is nearer.
    pub time_s: f64,
    /// Transform from coordinates of voxels, whole at their middles.
    pub shape_from_voxel: DAffine3,
    /// Voxels.
    pub voxels: Arc<SunlitVoxels>,
}

impl GridFrames {
    /// Grid at a time.
    pub fn at(&self, time_s: f64) -> &GridFrame {
        let begun = |pair: &&[GridFrame]| 0.5 * (pair[0].time_s + pair[1].time_s) <= time_s;
        &self.frames[self.frames.windows(2).take_while(begun).count()]
    }
}

/// Why a grid is no fog.
pub(super) struct Refused {
    pub(super) found: String,
    pub(super) expected: String,
    pub(super) remedy: &'static str,
}

/// The grid of a name in files, of a sequence at a frame rate.
pub(super) fn grid_frames(
    files: &GridFiles,
    name: Option<&str>,
    frame_rate: FrameRate,
) -> Result<GridFrames, Refused> {
    let name = name.unwrap_or(USUAL_GRID);
    let frames = files.frames.iter().zip(files.first_frame..).map(|(grids, number)| {
        let (voxels, shape_from_voxel) = voxels_of(grids, name).map_err(|refused| {
            let of_frame = if files.frames.len() > 1 { format!(" (frame {number})") } else { String::new() };
            let found = format!("{}{of_frame}: {}", files.path.display(), refused.found);
            Refused { found, ..refused }
        })?;
        Ok(GridFrame { time_s: frame_rate.seconds(number as f64), shape_from_voxel, voxels })
    });
    let frames = frames.collect::<Result<_, _>>()?;
    Ok(GridFrames { path: files.path.clone(), name: name.to_owned(), frames })
}

fn voxels_of(grids: &[Grid], name: &str) -> Result<(Arc<SunlitVoxels>, DAffine3), Refused> {
    let refused = |found: String, expected: &str, remedy: &'static str| {
        Err(Refused { found, expected: expected.to_owned(), remedy })
    };
    let Some(grid) = grids.iter().find(|grid| grid.name == name) else {
        let names: Vec<String> = grids.iter().map(|grid| format!("`{}`", grid.name)).collect();
        let expected =
            if names.is_empty() { String::from("a grid") } else { format!("one of {}", names.join(", ")) };
        return refused(format!("there is no grid `{name}`"), &expected, "name one of them in `grid`");
    };
    let Some(floats) = &grid.floats else {
        let found = format!("grid `{name}` is a {}", grid.kind);
        return refused(found, "a grid of floats", "name another in `grid`, or write it as one of floats");
    };
    if floats.tree.background != 0.0 {
        let found = format!("grid `{name}` is {} everywhere else", floats.tree.background);
        return refused(found, "a background of 0", "write it with that: fog ends somewhere");
    }
    let extent = floats.extent();
    if let Some(extent) = extent.filter(|extent| extent.least < 0.0) {
        let found = format!("grid `{name}` has a density of {}", extent.least);
        return refused(found, "none below 0", "clip it where it is made, or name another in `grid`");
    }
    match built(floats) {
        Ok(voxels) => Ok((Arc::new(voxels.into()), floats.transform)),
        Err(error @ VoxelsError::Empty) => {
            let remedy = "name another in `grid`, or leave the fog out";
            refused(format!("grid `{name}`: {error}"), "fog somewhere", remedy)
        }
        Err(error @ VoxelsError::TooWide(_)) => {
            let remedy = "clip it to what is seen, or write it with larger voxels";
            refused(format!("grid `{name}`: {error}"), "fewer", remedy)
        }
    }
}

/// Active voxels alone: what else a file holds is no part of the grid.
fn built(floats: &Floats) -> Result<Voxels, VoxelsError> {
    let mut builder = VoxelsBuilder::default();
    for tile in &floats.tree.tiles {
        builder.add_even(IVec3::from(tile.origin), tile.edge, tile.value)?;
    }
    for leaf in &floats.tree.leaves {
        let is_active = |place: usize| leaf.active[place / 8] >> (place % 8) & 1 == 1;
        let values = (0..BRICK).map(|place| if is_active(place) { leaf.values[place] } else { 0.0 });
        builder.add(IVec3::from(leaf.origin), values);
    }
    builder.built()
}
