//! Cameras. In go nodes and extras, out come cameras. Invariant: one for every node of the scene with a
//! camera, in the order of the nodes.

use super::Builder;
use super::extras::{self, Sunfleck, Unknown};
use crate::description::gltf::{self, Property};
use crate::diagnostic::Loss;
use crate::scene::{Aperture, Camera, Clip, Lens, RenderSettings, Track};
use glam::DVec2;
use serde::Deserialize;

/// Maximum shift of a lens.
const MOST_SHIFT: f64 = 100.0;

/// `sunfleck_camera`: properties of a lens that glTF lacks.
#[derive(Debug, Deserialize)]
struct ThinLens {
    fstop: Option<f64>,
    /// Focus distance, metres.
    focus_distance: Option<f64>,
    shift: Option<[f64; 2]>,
    #[serde(default = "full_frame_mm")]
    sensor_width_mm: f64,
    blades: Option<u32>,
    #[serde(flatten)]
    unknown: Unknown,
}

/// Blender's default sensor.
fn full_frame_mm() -> f64 {
    36.0
}

impl Builder<'_> {
    /// Adds a camera for every node of the scene with one. The chosen camera sets the picture's aspect,
    /// unless the file does.
    pub(super) fn add_cameras(&mut self, sunfleck: &Sunfleck, settings: &mut RenderSettings) {
        let mut seen_by = Vec::new();
        for (index, node) in self.source.nodes.iter().enumerate() {
            let (Some(number), Some(camera)) = (self.node_numbers[index], node.camera) else { continue };
            let source = camera;
            let camera = &self.source.cameras[camera];
            seen_by.push(camera);
            let lens = match camera.lens {
                gltf::Lens::Perspective { fov_y, .. } => {
                    Lens::Perspective { fov_y: self.keyed_number(Property::CameraFovY, source, fov_y) }
                }
                gltf::Lens::Orthographic { half_height, .. } => {
                    let property = Property::CameraHalfHeight;
                    let height_m = self.keyed(property, source, 2.0 * half_height, |half| 2.0 * half[0]);
                    Lens::Orthographic { height_m }
                }
            };
            let extras = self.camera_extras(camera);
            let shift = extras.as_ref().and_then(|extras| extras.shift).unwrap_or_default();
            let aperture = extras.and_then(|extras| self.aperture(camera, &extras));
            let name = node.name.clone();
            let shift = DVec2::from(shift);
            let (start_m, end_m) = camera.clip_m;
            let clip = Clip { start_m, end_m };
            self.scene.cameras.push(Camera { name, node: number, lens, shift, aperture, clip });
        }
        let chosen = self.chosen_camera(&seen_by, settings);
        let aspect = seen_by.get(chosen).and_then(|camera| camera.lens.aspect());
        if let Some(aspect) = aspect.filter(|_| sunfleck.resolution.is_none()) {
            settings.size.width = ((settings.size.height as f64 * aspect).round() as usize).clamp(1, 65536);
        }
    }

    /// Thin lens in a camera's `sunfleck_camera`.
    fn camera_extras(&mut self, camera: &gltf::Camera) -> Option<ThinLens> {
        let path = format!("camera `{}`", camera.name);
        let lens: ThinLens = extras::read(&camera.extras, "sunfleck_camera", &path, &mut self.report)?;
        let name = |field: &str| format!("sunfleck_camera.{field}` of `{}", camera.name);
        extras::tell_unknown(&lens.unknown, &mut self.report, name);
        if lens.shift.is_some_and(|shift| !shift.iter().all(|shift| shift.abs() <= MOST_SHIFT)) {
            let found = format!("the lens is shifted by {:?}", lens.shift.unwrap_or_default());
            let expected = "two numbers from -100 to 100, in lengths of the picture's longer side";
            self.report.error(format!("{path}.extras.sunfleck_camera.shift"), found, expected);
        }
        Some(lens)
    }

    fn aperture(&mut self, camera: &gltf::Camera, lens: &ThinLens) -> Option<Aperture> {
        let path = format!("camera `{}`", camera.name);
        let (Some(f_stop), Some(focus_distance)) = (lens.fstop, lens.focus_distance) else {
            if lens.fstop.is_some() || lens.focus_distance.is_some() {
                let found = "only one of fstop and focus_distance is given";
                self.report.error(format!("{path}.extras.sunfleck_camera"), found, "both, or neither");
            }
            return None;
        };
        let numbers = [f_stop, focus_distance, lens.sensor_width_mm];
        if !numbers.iter().all(|number| number.is_finite() && *number > 0.0)
            || lens.blades.is_some_and(|blades| !(3..=32).contains(&blades))
        {
            self.report.error(
                format!("{path}.extras.sunfleck_camera"),
                format!(
                    "no lens has f-stop {f_stop}, focus {focus_distance} m, sensor {} mm, {:?} blades",
                    lens.sensor_width_mm, lens.blades
                ),
                "numbers above 0, and 3 to 32 blades or none",
            );
            return None;
        }
        if matches!(camera.lens, gltf::Lens::Orthographic { .. }) {
            self.report.not_honoured(Loss::ApertureOrthographic, &camera.name);
            return None;
        }
        Some(Aperture {
            f_stop: Track::from(f_stop),
            sensor_width_m: 1e-3 * lens.sensor_width_mm,
            focus_distance_m: Track::from(focus_distance),
            blades: lens.blades.unwrap_or(0),
        })
    }

    /// Camera that the settings name, by its node or by itself, else the first.
    fn chosen_camera(&mut self, seen_by: &[&gltf::Camera], settings: &mut RenderSettings) -> usize {
        let Some(name) = &settings.camera else { return 0 };
        let by_node = self.scene.cameras.iter().position(|camera| camera.name == *name);
        if let Some(found) = by_node.or_else(|| seen_by.iter().position(|camera| camera.name == *name)) {
            settings.camera = Some(self.scene.cameras[found].name.clone());
            return found;
        }
        let names: Vec<&str> = self.scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
        let expected = if names.is_empty() {
            String::from("a camera of that name, exported (Blender: Include > Cameras)")
        } else {
            format!("one of: {}", names.join(", "))
        };
        let path = format!("scenes[{}].extras.sunfleck.camera", self.source.scene);
        self.report.error(path, format!("there is no camera `{name}`"), &expected);
        0
    }
}
