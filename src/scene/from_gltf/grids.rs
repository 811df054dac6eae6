//! Fog as dense as the grids of files. In go extras, out comes its shape. Invariant: what the file says
//! stands nowhere else.

use super::{Builder, extras};
use crate::diagnostic::Diagnostic;
use crate::scene::FogShape;
use crate::scene::grids::{Refused, grid_frames};

impl Builder<'_> {
    /// The shape of a node's fog that names a file, `path` in its own; `None` where that is refused.
    pub(super) fn fog_of_grids(&mut self, uri: &str, fog: &extras::Fog, path: &str) -> Option<FogShape> {
        let others = [
            ("shape", fog.shape.is_some()),
            ("bounds", fog.bounds.is_some()),
            ("height_falloff", fog.height_falloff.is_some()),
            ("scale_height", fog.scale_height.is_some()),
            ("base_height", fog.base_height.is_some()),
        ];
        for (field, _) in others.into_iter().filter(|(_, is_said)| *is_said) {
            let found = format!("`{field}` stands beside `vdb`, whose voxels say where the fog is");
            self.report.error(format!("{path}.{field}"), found, "one of the two");
        }
        let frame_rate = self.clock.frame_rate;
        let grids = grid_frames(self.source.grids.get(uri)?, fog.grid.as_deref(), frame_rate);
        let told = |Refused { found, expected, remedy }| {
            let place = self.report.at(format!("{path}.vdb"));
            self.report.push(Diagnostic::error(place, found).expected(expected).remedy(remedy));
        };
        grids.map_err(told).ok().map(FogShape::Voxels)
    }

    /// Whether fog that names no file names a grid, which is an error then.
    pub(super) fn check_no_grid(&mut self, fog: &extras::Fog, path: &str) {
        if fog.grid.is_some() {
            let found = "`grid` names one of a file that is not named";
            self.report.error(format!("{path}.grid"), found, "`vdb` beside `grid`");
        }
    }
}
