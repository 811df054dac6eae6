//! Fog from OpenVDB files. In go fields, out come grids. Invariant: fields that the file replaces are
//! refused.

use super::Resolver;
use super::track;
use crate::color::Rgb;
use crate::description::ron;
use crate::scene::grids::{GridNames, Refused, USUAL_GRID, grid_frames};
use crate::scene::{GridFrames, Track};
use std::path::Path;

impl Resolver<'_> {
    /// Grids of a fog volume; `None` if they are refused.
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
        let (emission, shines) = (&fog.emission_grid, &fog.emission_w_per_m3_sr);
        if emission.is_some() != shines.is_some() || (fog.emission_kelvin.is_some() && emission.is_none()) {
            let found = "what shines is said by halves";
            let expected =
                "`emission_grid` and `emission_w_per_m3_sr`, or neither, and `emission_kelvin` beside both";
            self.problems.error(owner, found, expected, "add the other one, or take both out");
        }
        let place = format!("{owner}.emission_w_per_m3_sr");
        let shines = shines.as_ref().and_then(|shines| track(shines, &place, &mut self.problems));
        let shines = shines.unwrap_or_else(|| Track::from(Rgb::ZERO));
        let names = GridNames {
            density: fog.grid.clone().unwrap_or_else(|| USUAL_GRID.to_owned()),
            albedo: fog.albedo_grid.clone(),
            emission: fog.emission_grid.clone(),
            kelvin: fog.emission_kelvin.map(ron::Number::si),
            is_principled: false,
        };
        let grids = grid_frames(self.grids.get(path)?, names, shines, self.frame_rate);
        let told = |Refused { found, expected, remedy }| {
            self.problems.error(owner, found, &expected, remedy);
        };
        grids.map_err(told).ok()
    }

    /// Refuses names of grids without a file.
    pub(super) fn check_no_grids(&mut self, owner: &str, fog: &ron::Fog) {
        let names = [
            ("grid", fog.grid.is_some()),
            ("albedo_grid", fog.albedo_grid.is_some()),
            ("emission_grid", fog.emission_grid.is_some()),
            ("emission_w_per_m3_sr", fog.emission_w_per_m3_sr.is_some()),
            ("emission_kelvin", fog.emission_kelvin.is_some()),
        ];
        for (field, _) in names.into_iter().filter(|(_, is_said)| *is_said) {
            let what = if field.ends_with("grid") { "names one" } else { "is" };
            let found = format!("`{field}` {what} of a file that is not named");
            let (expected, remedy) =
                (format!("`vdb` beside `{field}`"), format!("add `vdb`, or take `{field}` out"));
            self.problems.error(owner, &found, &expected, &remedy);
        }
    }
}
