//! Fog from OpenVDB grids. In go extras, out comes its shape. Invariant: fields that the file replaces are
//! refused.

use super::{Builder, extras};
use crate::color::Rgb;
use crate::diagnostic::Diagnostic;
use crate::scene::grids::{GridNames, Refused, USUAL_GRID, grid_frames};
use crate::scene::{FogShape, Track};

impl Builder<'_> {
    /// Shape of a node's fog that names a file; `path` is that of the property; `None` if it is refused.
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
        let (emission, kelvin) = (fog.emission.map(Rgb::from), fog.emission_kelvin);
        let is_whole =
            fog.emission_grid.is_some() == emission.is_some() && (kelvin.is_none() || emission.is_some());
        let are_right = emission.is_none_or(|emission| emission.min_element() >= 0.0)
            && kelvin.is_none_or(|kelvin| kelvin > 0.0);
        if !is_whole || !are_right {
            let found = "what shines is said by halves, or by numbers below 0";
            let expected =
                "`emission_grid` and `emission`, or neither; `emission_kelvin` above 0 beside both";
            self.report.error(format!("{path}.emission"), found, expected);
        }
        let names = GridNames {
            density: fog.grid.clone().unwrap_or_else(|| USUAL_GRID.to_owned()),
            albedo: fog.albedo_grid.clone(),
            emission: fog.emission_grid.clone(),
            kelvin,
            is_principled: fog.emission_principled,
        };
        let shines = Track::from(emission.unwrap_or(Rgb::ZERO));
        let grids = grid_frames(self.source.grids.get(uri)?, names, shines, frame_rate);
        let told = |Refused { found, expected, remedy }| {
            let place = self.report.at(format!("{path}.vdb"));
            self.report.push(Diagnostic::error(place, found).expected(expected).remedy(remedy));
        };
        grids.map_err(told).ok().map(|grids| FogShape::Voxels(Box::new(grids)))
    }

    /// Refuses names of grids without a file.
    pub(super) fn check_no_grid(&mut self, fog: &extras::Fog, path: &str) {
        let names = [
            ("grid", fog.grid.is_some()),
            ("albedo_grid", fog.albedo_grid.is_some()),
            ("emission_grid", fog.emission_grid.is_some()),
            ("emission", fog.emission.is_some()),
            ("emission_kelvin", fog.emission_kelvin.is_some()),
            ("emission_principled", fog.emission_principled),
        ];
        for (field, _) in names.into_iter().filter(|(_, is_said)| *is_said) {
            let what = if field.ends_with("grid") { "names one" } else { "is" };
            let found = format!("`{field}` {what} of a file that is not named");
            self.report.error(format!("{path}.{field}"), found, "`vdb` beside it");
        }
    }
}
