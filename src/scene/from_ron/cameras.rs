//! Cameras. In go those of a file, out come cameras with their nodes. Invariant: a camera has either a target
//! or a rotation, and is either orthographic or has an angle of view.

use super::{Resolver, rotation};
use crate::description::ron;
use crate::scene::{Aperture, Camera, Clip, Lens, Motion, Track};
use glam::{DVec2, DVec3};

/// Default full vertical field of view.
const DEFAULT_FOV_DEG: f64 = 45.0;

impl Resolver<'_> {
    pub(super) fn cameras(&mut self) {
        if self.file.cameras.iter().len() == 0 {
            let remedy = "add `cameras: { \"main\": (position_m: (0.0, 1.0, 4.0)) }`";
            self.problems.error("cameras", "the scene has no camera", "at least one camera", remedy);
        }
        for (name, camera) in self.file.cameras.iter() {
            let owner = format!("cameras.{name}");
            let parent = self.parent(&owner, camera.parent.as_deref());
            let motion = self.camera_motion(&owner, camera);
            let lens = self.lens(&owner, camera);
            let aperture = camera.aperture.as_ref().and_then(|aperture| {
                let owner = format!("{owner}.aperture");
                let f_stop = self.keyed(&owner, "f_stop", &aperture.f_stop);
                let focus = &aperture.focus_distance_m;
                let focus = self.keyed(&owner, "focus_distance_m", focus);
                Some(Aperture {
                    f_stop: f_stop?,
                    sensor_width_m: 1e-3 * aperture.sensor_width_mm.si(),
                    focus_distance_m: focus?,
                    blades: aperture.blades.map_or(0, |blades| blades.0),
                })
            });
            if let (Some(parent), Some(motion), Some(lens)) = (parent, motion, lens) {
                let node = self.scene.add_node(name.to_owned(), parent, motion);
                let (shift, clip) = (DVec2::ZERO, self.clip(&owner, camera));
                self.scene.cameras.push(Camera { name: name.to_owned(), node, lens, shift, aperture, clip });
            }
        }
    }

    fn clip(&mut self, owner: &str, camera: &ron::Camera) -> Clip {
        let Some((start, end)) = &camera.clip_m else { return Clip::NONE };
        let clip = Clip { start_m: start.si(), end_m: end.si() };
        if clip.start_m >= clip.end_m {
            self.problems.error(
                &format!("{owner}.clip_m"),
                format!(
                    "the clipping planes at {} and {} m leave nothing between them",
                    clip.start_m, clip.end_m
                ),
                "the nearer plane first: `(start, end)`",
                "swap them, or take `clip_m` out",
            );
        }
        clip
    }

    fn lens(&mut self, owner: &str, camera: &ron::Camera) -> Option<Lens> {
        let Some(height) = &camera.orthographic_height_m else {
            let fov_y = match &camera.fov_deg {
                Some(fov) => self.keyed(owner, "fov_deg", fov)?,
                None => Track::from(DEFAULT_FOV_DEG.to_radians()),
            };
            return Some(Lens::Perspective { fov_y });
        };
        if camera.fov_deg.is_some() || camera.aperture.is_some() {
            self.problems.error(
                owner,
                "an orthographic camera has neither an angle of view nor an aperture",
                "either `orthographic_height_m`, or `fov_deg` and `aperture`",
                "take one of the two out",
            );
        }
        let height_m = self.keyed(owner, "orthographic_height_m", height)?;
        Some(Lens::Orthographic { height_m })
    }

    fn camera_motion(&mut self, owner: &str, camera: &ron::Camera) -> Option<Motion> {
        let turned = camera.rotation_deg.is_some() || camera.rotation_quaternion.is_some();
        let Some(look_at) = &camera.look_at_m else {
            let position = self.keyed(owner, "position_m", &camera.position_m);
            let turn = rotation(
                camera.rotation_deg.as_ref(),
                camera.rotation_quaternion.as_ref(),
                owner,
                &mut self.problems,
            );
            return Some(Motion::Keyed { translation: position?, rotation: turn?, scale: DVec3::ONE.into() });
        };
        if turned {
            self.problems.error(
                owner,
                "the camera looks at something and is turned as well",
                "either `look_at_m`, or `rotation_deg` or `rotation_quaternion`",
                "take one of the two out",
            );
        }
        let up = self.keyed(owner, "up", &camera.up)?;
        self.aimed(owner, ("position_m", &camera.position_m), ("look_at_m", look_at), up)
    }
}
