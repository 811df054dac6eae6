//! Camera that a program supplies, a new one for each picture. In go its place and lens, out comes a camera
//! of the scene. Invariant: nothing else of the scene changes, so its trees are kept.

use crate::scene::{Aperture, Camera, Clip, Lens, Motion, Scene, Track};
use glam::{DAffine3, DMat4, DVec2};
use serde::{Deserialize, Serialize};

/// Camera of a viewer.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Viewer {
    /// World from camera, metres, column by column as nodes of glTF have it; it looks along -Z, +Y is up.
    matrix: [f64; 16],
    /// Full vertical angle, degrees; for parallel rays the picture's height, metres.
    #[serde(default)]
    fov_deg: Option<f64>,
    #[serde(default)]
    height_m: Option<f64>,
    /// Offset of the picture's middle from the view axis, to the right and up, as a fraction of its longer
    /// side.
    #[serde(default)]
    shift: [f64; 2],
    /// Distances of the clipping planes, metres.
    #[serde(default)]
    clip_m: Option<[f64; 2]>,
    #[serde(default)]
    aperture: Option<Opening>,
}

#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Opening {
    f_stop: f64,
    focus_distance_m: f64,
    sensor_width_m: f64,
    /// Number of blades; 0 is a round opening.
    #[serde(default)]
    blades: u32,
}

/// Name of the viewer's camera, which no camera of a file can have.
pub const NAME: &str = "\0viewer";

impl Viewer {
    /// Description of an invalid value, if there is one.
    pub fn fault(&self) -> Option<&'static str> {
        let is_length = |value: f64| value.is_finite() && value > 0.0;
        let world_from_camera = DMat4::from_cols_array(&self.matrix);
        let has_lens = match (self.fov_deg, self.height_m) {
            (Some(fov_deg), None) => fov_deg > 0.0 && fov_deg < 180.0,
            (None, Some(height_m)) => is_length(height_m),
            _ => false,
        };
        let clips = self.clip_m.is_none_or(|[start_m, end_m]| start_m >= 0.0 && end_m > start_m);
        let opens = self.aperture.as_ref().is_none_or(|opening| {
            let sizes = [opening.f_stop, opening.focus_distance_m, opening.sensor_width_m];
            sizes.into_iter().all(is_length) && (opening.blades == 0 || opening.blades >= 3)
        });
        let faults = [
            (
                !world_from_camera.is_finite() || world_from_camera.determinant() == 0.0,
                "`matrix` is no place",
            ),
            (!has_lens, "either `fov_deg` between 0 and 180, or `height_m` above 0, is a lens"),
            (!self.shift.iter().all(|shift| shift.is_finite()), "`shift` is two finite numbers"),
            (!clips, "`clip_m` is a start of at least 0 and an end beyond it"),
            (!opens, "`aperture` has numbers above 0, and no blades or at least 3"),
        ];
        faults.into_iter().find(|(is_fault, _)| *is_fault).map(|(_, fault)| fault)
    }

    /// Puts the viewer's camera into a scene, in place of an earlier viewer's.
    pub fn put_into(&self, scene: &mut Scene) {
        let world_from_camera = DAffine3::from_mat4(DMat4::from_cols_array(&self.matrix));
        let motion = Motion::Still(world_from_camera);
        let node = match scene.cameras.iter().find(|camera| camera.name == NAME) {
            Some(camera) => camera.node,
            None => scene.add_node(String::from(NAME), None, motion.clone()),
        };
        scene.nodes[node].motion = motion;
        scene.cameras.retain(|camera| camera.name != NAME);
        scene.cameras.push(self.camera(node));
    }

    fn camera(&self, node: usize) -> Camera {
        let lens = match self.height_m {
            Some(height_m) => Lens::Orthographic { height_m: Track::from(height_m) },
            None => Lens::Perspective { fov_y: Track::from(self.fov_deg.unwrap_or_default().to_radians()) },
        };
        let aperture = self.aperture.as_ref().map(|opening| Aperture {
            f_stop: Track::from(opening.f_stop),
            sensor_width_m: opening.sensor_width_m,
            focus_distance_m: Track::from(opening.focus_distance_m),
            blades: opening.blades,
        });
        let clip = self.clip_m.map_or(Clip::NONE, |[start_m, end_m]| Clip { start_m, end_m });
        Camera { name: String::from(NAME), node, lens, shift: DVec2::from(self.shift), aperture, clip }
    }
}
