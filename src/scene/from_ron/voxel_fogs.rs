//! Fog as dense as the voxels of a file. In go grids, out come shapes of fog and where they are. Invariant:
//! what no fog can be, negative or without bounds, is refused.

use super::Resolver;
use crate::description::ron;
use crate::description::vdb::{Floats, Grid};
use crate::math::{BRICK, SunlitVoxels, Voxels, VoxelsBuilder, VoxelsError};
use glam::{DAffine3, IVec3};
use std::path::Path;
use std::sync::Arc;

/// What a grid of density is called unless one says otherwise.
const USUAL: &str = "density";

impl Resolver<'_> {
    /// The voxels of a bank, and their parent's space from theirs; `None` where that is refused.
    pub(super) fn fog_voxels(
        &mut self,
        owner: &str,
        fog: &ron::Fog,
        path: &Path,
    ) -> Option<(Arc<SunlitVoxels>, DAffine3)> {
        let others = [
            ("min_m", fog.min_m.is_some()),
            ("max_m", fog.max_m.is_some()),
            ("scale_height_m", fog.scale_height_m.is_some()),
            ("base_m", fog.base_m.is_some()),
        ];
        for (field, _) in others.into_iter().filter(|(_, is_said)| *is_said) {
            let found = format!("`{field}` stands beside `vdb`, whose voxels say where the fog is");
            let remedy = format!("take `{field}` out, or add a bank of fog of its own");
            self.problems.error(owner, &found, "one of the two", &remedy);
        }
        let name = fog.grid.as_deref().unwrap_or(USUAL);
        let found = voxels_of(self.grids.get(path)?, name);
        let found = found.map_err(|Refused { found, expected, remedy }| {
            let found = format!("{}: {found}", path.display());
            self.problems.error(owner, &found, &expected, remedy);
        });
        found.ok()
    }
}

/// Why a grid is no fog.
struct Refused {
    found: String,
    expected: String,
    remedy: &'static str,
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
