//! Fog as dense as the voxels of a file. In go fields, out come grids. Invariant: what the file says stands
//! nowhere else.

use super::Resolver;
use crate::description::ron;
use crate::scene::GridFrames;
use crate::scene::grids::{Refused, grid_frames};
use std::path::Path;

impl Resolver<'_> {
    /// The grids of a bank; `None` where they are refused.
    pub(super) fn fog_grids(&mut self, owner: &str, fog: &ron::Fog, path: &Path) -> Option<GridFrames> {
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
        let grids = grid_frames(self.grids.get(path)?, fog.grid.as_deref(), self.frame_rate);
        let told = |Refused { found, expected, remedy }| {
            self.problems.error(owner, found, &expected, remedy);
        };
        grids.map_err(told).ok()
    }
}
