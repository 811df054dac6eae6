//! `inspect` for OpenVDB files. In goes a file, out comes text. Invariant: each grid has a paragraph.

use std::path::Path;
use sunfleck::description::LoadError;
use sunfleck::description::vdb::{self, Grid};

/// Whether a file has the extension of OpenVDB.
pub(super) fn holds(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("vdb"))
}

/// Description with a paragraph for each grid.
pub(super) fn describe(path: &Path) -> Result<String, LoadError> {
    let grids = vdb::load(path)?;
    let mut text = format!(
        "{}: {} in an OpenVDB file; fog of a scene names it as `vdb`",
        path.display(),
        count(grids.len())
    );
    for grid in &grids {
        text += &of_one(grid);
    }
    Ok(text)
}

fn count(grids: usize) -> String {
    if grids == 1 { String::from("1 grid") } else { format!("{grids} grids") }
}

fn of_one(grid: &Grid) -> String {
    let Grid { name, kind, .. } = grid;
    if let Some(vectors) = &grid.vectors {
        let voxels: usize = vectors.tree.leaves().map(|leaf| leaf.values.len()).sum();
        return format!(
            "\n{name}: {kind}\n  active voxels  {voxels} in {} leaves, and {} tiles; of fog velocities or colours",
            vectors.tree.leaves().len(),
            vectors.tree.tiles.len(),
        );
    }
    let Some(floats) = &grid.floats else {
        return format!("\n{name}: {kind}, of which nothing is read; grids of numbers and of vectors are");
    };
    let Some(extent) = floats.extent() else {
        return format!("\n{name}: {kind}, no active voxels");
    };
    let [low, high] = extent.bounds;
    let edges = floats.transform.matrix3;
    format!(
        "\n{name}: {kind}\n  active voxels  {} in {} leaves and {} tiles\n  \
         voxel edges    {:.6} x {:.6} x {:.6}\n  bounds         ({:.6}, {:.6}, {:.6}) to ({:.6}, {:.6}, {:.6})\n  \
         values         {} to {}, mean {:.6}, background {}\n  memory         {} bytes",
        extent.voxels,
        floats.tree.leaves().len(),
        floats.tree.tiles.len(),
        edges.x_axis.length(),
        edges.y_axis.length(),
        edges.z_axis.length(),
        low.x,
        low.y,
        low.z,
        high.x,
        high.y,
        high.z,
        extent.least,
        extent.most,
        extent.mean,
        floats.tree.background,
        floats.tree.memory(),
    )
}
