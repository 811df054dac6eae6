//! Choice between slices and rays for a frame, with its reason. In goes an exposure, out comes the cheaper of
//! the methods that can render it. Invariant: the choice depends on the scene at that frame alone, never on a
//! crop, a clock or a number of threads. So a crop has the pixels of the whole picture.

use super::Method;
use super::draws::Draws;
use crate::scene::Size;
use crate::snapshot::{Exposure, FrozenLight, Luminaire, Snapshot};
use std::fmt;

/// Costs of a sample, in primary rays: `cargo bench --bench figures -- shafts` and `-- slices` on leaves500
/// (2026-11-21, 2 virtual cores of an AMD EPYC). In a denser scene all but the slices cost more.
mod cost {
    /// Slices of one light, with fog or without, primary visibility included.
    pub(super) const SLICES: f64 = 1.3;
    /// Direct light of one light on a surface.
    pub(super) const DIRECT: f64 = 0.8;
    /// Light of one light that fog scatters along a ray.
    pub(super) const SHAFTS: f64 = 32.0;
}

/// Method of a frame, and its reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// [`Method::Slices`] or [`Method::Segments`].
    pub method: Method,
    /// Reason for it.
    pub reason: Reason,
}

/// Reason for a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// The scene has no light for slices.
    NoLight,
    /// A light at the camera has no slices.
    LightAtCamera,
    /// Parallel rays have no eye for slices to pass through.
    Orthographic,
    /// Lens or light are so large, and the picture so narrow, that nearly all slices would miss it.
    NarrowPicture,
    /// Both methods can render it, at these costs a sample, in primary rays.
    Cost {
        /// Cost by slices.
        slices: f64,
        /// Cost by rays.
        rays: f64,
    },
}

/// Returns the method of `--volume auto`.
pub fn choose(exposure: &Exposure) -> Choice {
    let snapshot = exposure.middle();
    let reason = obstacle(exposure).unwrap_or_else(|| {
        let lights = snapshot.lights.len() as f64;
        let shafts = if snapshot.medium.is_empty() { 0.0 } else { cost::SHAFTS };
        // Rays that blended surfaces touch are traced by the per-ray method: without fog, maybe all of them.
        let alone =
            if exposure.moments().iter().any(Snapshot::has_blended) { 1.0 + cost::DIRECT } else { 0.0 };
        // Rays for the sky are traced with either method, except for light that slices already have.
        let sky = if exposure.has_sky_light() { 1.0 } else { 0.0 };
        Reason::Cost {
            slices: lights * (cost::SLICES + alone) + sky,
            rays: 1.0 + lights * (cost::DIRECT + shafts),
        }
    });
    let method = match reason {
        Reason::Cost { slices, rays } if slices <= rays => Method::Slices,
        _ => Method::Segments,
    };
    Choice { method, reason }
}

/// Reason why slices cannot render a frame, if there is one. They need an eye and a light, and no light may
/// be at the eye or around it. Some sampled points of a light around the eye lie next to it, and a few slices
/// do not average these.
pub(super) fn obstacle(exposure: &Exposure) -> Option<Reason> {
    let at_camera = |light: &Luminaire| match light.centre() {
        FrozenLight::Sun { .. } => false,
        FrozenLight::Point { position, .. } => position.length() <= light.radius_m(),
    };
    let lights = &exposure.middle().lights;
    if exposure.middle().view.is_orthographic {
        Some(Reason::Orthographic)
    } else if lights.is_empty() {
        Some(Reason::NoLight)
    } else if lights.iter().any(at_camera) {
        Some(Reason::LightAtCamera)
    } else {
        narrowness(exposure)
    }
}

/// Maximum deviation of fans over a picture, in widths of it: about that many times as many slices are laid
/// out as cross it.
const FARTHEST_DEVIATION: f64 = 100.0;

/// Whether the fans of a light deviate too far over the picture.
fn narrowness(exposure: &Exposure) -> Option<Reason> {
    let size = Size { width: 1, height: 1 };
    let width_rad = 2.0 * exposure.middle().view.half_extents().max_element().atan();
    let deviates = |light: usize| {
        let deviation_rad = Draws::new(exposure, light, 0).deviation_rad(size);
        deviation_rad.is_some_and(|deviation_rad| deviation_rad > FARTHEST_DEVIATION * width_rad)
    };
    let lights = 0..exposure.middle().lights.len();
    lights.into_iter().any(deviates).then_some(Reason::NarrowPicture)
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let way = if self.method == Method::Slices { "slices" } else { "rays" };
        match self.reason {
            Reason::NoLight => write!(f, "{way}: there is no light"),
            Reason::LightAtCamera => write!(f, "{way}: a light is at the camera"),
            Reason::Orthographic => write!(f, "{way}: the camera is orthographic"),
            Reason::NarrowPicture => write!(f, "{way}: lens or light is wide, and the picture narrow"),
            Reason::Cost { slices, rays } => {
                write!(
                    f,
                    "{way}: a sample costs about {slices:.1} primary rays from slices, {rays:.1} by rays"
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::scene::{
        Camera, Clip, Fog, FogShape, Lens, Light, LightKind, Motion, Node, Scene, SunDisc, Track,
    };
    use crate::snapshot::{MeshTrees, Shutter};
    use glam::{DAffine3, DVec2, DVec3};

    fn chosen(suns: usize, lamp: Option<DVec3>, fog: bool) -> Choice {
        seen_by(1.0, LightKind::Sun, suns, lamp, fog)
    }

    fn seen_by(fov_y: f64, sun: LightKind, suns: usize, lamp: Option<DVec3>, fog: bool) -> Choice {
        let mut scene = Scene::default();
        let node = |scene: &mut Scene, place: DVec3| {
            let motion = Motion::Still(DAffine3::from_translation(place));
            scene.nodes.push(Node { name: String::new(), parent: None, motion, visible: Track::from(true) });
            scene.nodes.len() - 1
        };
        let eye = node(&mut scene, DVec3::ZERO);
        let lens = Lens::Perspective { fov_y: Track::from(fov_y) };
        scene.cameras.push(Camera {
            name: String::new(),
            node: eye,
            lens,
            shift: DVec2::ZERO,
            aperture: None,
            clip: Clip::NONE,
        });
        let light = |scene: &mut Scene, place: DVec3, kind: LightKind| {
            let node = node(scene, place);
            scene.lights.push(Light { name: String::new(), node, power: Track::from(Rgb::ONE), kind });
        };
        for _ in 0..suns {
            light(&mut scene, DVec3::ZERO, sun.clone());
        }
        if let Some(place) = lamp {
            light(&mut scene, place, LightKind::Point);
        }
        if fog {
            scene.fogs.push(Fog {
                name: String::new(),
                node: eye,
                shape: FogShape::EvenBox,
                density_per_m: Track::from(Rgb::splat(0.1)),
                albedo: Track::from(Rgb::ONE),
                anisotropy: Track::from(0.0),
            });
        }
        let shutter = Shutter { open_s: 0.0, close_s: 0.0 };
        choose(&Exposure::new(&scene, &MeshTrees::new(&scene), 0, 1.0, shutter))
    }

    #[test]
    fn fog_wants_slices_however_many_lights() {
        for suns in [1, 8, 64] {
            assert_eq!(chosen(suns, None, true).method, Method::Slices);
        }
    }

    /// Slices are laid out over the whole deviation of fans. Few of them cross a picture a ten-thousandth as
    /// wide.
    #[test]
    fn narrow_pictures_of_wide_suns_want_rays_whoever_asks() {
        let sun = || LightKind::SunDisc(SunDisc::even(Track::from(0.2)));
        assert_eq!(seen_by(1e-5, sun(), 1, None, true).reason, Reason::NarrowPicture);
        assert_eq!(seen_by(0.1, sun(), 1, None, true).method, Method::Slices);
        assert_eq!(seen_by(1e-5, LightKind::Sun, 1, None, true).method, Method::Slices);
    }

    #[test]
    fn many_lights_without_fog_want_rays() {
        assert_eq!(chosen(1, None, false).method, Method::Slices);
        assert_eq!(chosen(8, None, false).method, Method::Segments);
    }

    #[test]
    fn obstacles_are_named() {
        assert_eq!(chosen(0, None, true).reason, Reason::NoLight);
        assert_eq!(chosen(1, Some(DVec3::ZERO), true).reason, Reason::LightAtCamera);
        assert_eq!(chosen(0, Some(DVec3::X), true).method, Method::Slices);
        let said = chosen(1, Some(DVec3::ZERO), true).to_string();
        assert_eq!(said, "rays: a light is at the camera");
    }
}
