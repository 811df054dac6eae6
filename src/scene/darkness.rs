//! Causes of dark pictures. In go the scene, its camera, a time and the coverage of the picture; out comes
//! the likeliest cause, with a remedy. Invariant: a cause follows from the scene's own numbers.

use super::{Instance, Light, LightKind, LightUnits, Scene};
use crate::color::{LUMENS_PER_WATT, Rgb};
use crate::diagnostic::{Diagnostic, Place};
use crate::math::bounds;
use glam::{DVec3, Vec3};
use std::fmt;

/// Limits of dim lights in lux and candela: a sun at deep dusk, W/m^2, and lamps, W/sr (68 lux, 102 cd).
/// Watts, as in Blender's unitless mode, become this dim if they are read as lux and candela.
const DIM_SUN: f64 = 0.1;
const DIM_LAMP: f64 = 0.15;

/// Coverage of a picture below which it is empty, and above which one object fills it.
const HARDLY_COVERED: f64 = 1e-3;
const NEARLY_ALL: f64 = 0.999;

/// Cause of a dark picture.
#[derive(Clone, Debug, PartialEq)]
pub enum DarkCause {
    /// No light and no emission.
    NoLight,
    /// Shafts alone are requested, without fog.
    NoFog,
    /// No object is visible at that time.
    NothingVisible,
    /// All objects are outside the picture.
    OutsidePicture,
    /// All lights are off or hidden at that time.
    LightsOff,
    /// The brightest light of a file in lux and candela is dim.
    DimLights {
        /// Power of the brightest light.
        lux_or_candela: f64,
    },
    /// The camera is inside the bounds of an object that fills the picture.
    InsideObject(String),
    /// Visible surfaces receive too little light.
    TooLittleLight,
}

/// Whether surfaces or fires shine of themselves.
pub(super) fn emits(scene: &Scene, time_s: f64) -> bool {
    scene.materials.iter().any(|material| material.at(time_s).emission != Rgb::ZERO)
        || scene.fogs.iter().any(|fog| fog.shape.emits())
}

/// The likeliest cause of a dark picture at a time, of which things cover the share `covered`.
pub fn dark_cause(scene: &Scene, camera: usize, time_s: f64, covered: f64) -> DarkCause {
    let placements = scene.placements(time_s);
    let is_seen = |instance: &&Instance| placements[instance.node].visible;
    let shines = |light: &Light| placements[light.node].visible && brightest(light, time_s) > 0.0;
    let emits = emits(scene, time_s);
    if scene.lights.is_empty() && scene.sky.is_none() && !emits {
        DarkCause::NoLight
    } else if scene.instances.iter().all(|instance| !is_seen(&instance)) {
        DarkCause::NothingVisible
    } else if covered < HARDLY_COVERED {
        DarkCause::OutsidePicture
    } else if scene.sky.is_none() && !emits && !scene.lights.iter().any(shines) {
        DarkCause::LightsOff
    } else if let Some(lux_or_candela) = dim_lights(scene, time_s) {
        DarkCause::DimLights { lux_or_candela }
    } else {
        let eye = placements[scene.cameras[camera].node].world_from_node.translation;
        let around = scene.instances.iter().filter(is_seen).find(|instance| {
            let (positions, world_from_mesh) = scene.vertices(instance, &placements, time_s);
            is_within_bounds(world_from_mesh.inverse().transform_point3(eye), &positions)
        });
        match around.filter(|_| covered > NEARLY_ALL) {
            Some(instance) => DarkCause::InsideObject(scene.nodes[instance.node].name.clone()),
            None => DarkCause::TooLittleLight,
        }
    }
}

/// Warning for `inspect` about a file whose frames will be dark.
pub(super) fn remark(scene: &Scene, time_s: f64, place: Place) -> Option<Diagnostic> {
    let lux_or_candela = dim_lights(scene, time_s)?;
    let cause = DarkCause::DimLights { lux_or_candela };
    Some(Diagnostic::note(place, cause.to_string()).remedy(cause.remedy()))
}

/// Lux or candela of the brightest light, if the file was read in these units and all lights are dim.
fn dim_lights(scene: &Scene, time_s: f64) -> Option<f64> {
    let is_dim = |light: &Light| match light.kind {
        LightKind::Sun | LightKind::SunDisc(_) => brightest(light, time_s) < DIM_SUN,
        LightKind::Point | LightKind::Sphere { .. } | LightKind::Spot { .. } => {
            brightest(light, time_s) < DIM_LAMP
        }
        // Always in watts.
        LightKind::Area { .. } => false,
    };
    let most = scene.lights.iter().map(|light| brightest(light, time_s)).fold(0.0, f64::max);
    let are_dim = scene.guessed_light_units == Some(LightUnits::Spec) && scene.lights.iter().all(is_dim);
    (are_dim && most > 0.0).then_some(most * LUMENS_PER_WATT)
}

fn brightest(light: &Light, time_s: f64) -> f64 {
    light.power.at(time_s).max_element()
}

fn is_within_bounds(point: DVec3, positions: &[Vec3]) -> bool {
    let (low, high) = bounds(positions.iter().map(|position| position.as_dvec3()));
    point.cmpgt(low).all() && point.cmplt(high).all()
}

impl DarkCause {
    /// Remedy.
    pub fn remedy(&self) -> &'static str {
        match self {
            Self::NoLight => {
                "add a light, or a sky that lights surfaces (glTF and OBJ files get a light of their own unless --default-light is off)"
            }
            Self::NoFog => "add fog, or take --only out",
            Self::NothingVisible => "show something at that frame, or render others with --frames",
            Self::OutsidePicture => "turn the camera, or name another with --camera",
            Self::LightsOff => "switch a light on at that frame, or render others with --frames",
            Self::DimLights { .. } => {
                "--light-units compat reads them as Blender's unitless mode writes them"
            }
            Self::InsideObject(_) => "move the camera out of it, or hide it",
            Self::TooLittleLight => {
                "move or brighten the lights; --preview png shows what there is, brightened, and EXR files hold all of it"
            }
        }
    }
}

impl fmt::Display for DarkCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoLight => write!(f, "nothing lights the scene"),
            Self::NoFog => write!(f, "the scene has no fog that could have shafts"),
            Self::NothingVisible => write!(f, "nothing in the scene is visible"),
            Self::OutsidePicture => write!(f, "the camera sees nothing: everything lies outside the picture"),
            Self::LightsOff => write!(f, "all lights are off or hidden"),
            Self::DimLights { lux_or_candela } => write!(
                f,
                "all lights are dim, {lux_or_candela:.3} lux or candela at most; lights of so little are mostly those of Blender's unitless mode"
            ),
            Self::InsideObject(name) => write!(f, "the camera seems to be inside of `{name}`"),
            Self::TooLittleLight => write!(f, "too little light reaches what the camera sees"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Material, Mesh, Motion, Node, RenderSettings, Track, default_light, default_view};
    use glam::DAffine3;

    /// A cube of 2 m around the origin, the camera at a place, a sun of so much irradiance.
    fn scene(eye: DVec3, irradiance: f64) -> Scene {
        let node =
            |motion| Node { name: String::from("cube"), parent: None, motion, visible: Track::from(true) };
        let positions = vec![Vec3::NEG_ONE, Vec3::ONE];
        let instance = Instance { node: 0, mesh: 0, material: None, leaf_id: 1, deformation: None };
        let mut scene = Scene {
            nodes: vec![node(Motion::STILL)],
            meshes: vec![Mesh { positions, ..Mesh::default() }],
            materials: vec![Material::default()],
            instances: vec![instance],
            guessed_light_units: Some(LightUnits::Spec),
            ..Scene::default()
        };
        default_view::add(&mut scene);
        scene.nodes[1].motion = Motion::Still(DAffine3::from_translation(eye));
        default_light::add(&mut scene, &RenderSettings::default());
        (scene.sky, scene.lights[0].power) = (None, Rgb::splat(irradiance).into());
        scene
    }

    const FAR: DVec3 = DVec3::new(0.0, 0.0, 9.0);

    #[test]
    fn every_cause_is_found() {
        let unlit = Scene { lights: Vec::new(), ..scene(FAR, 1.0) };
        assert_eq!(dark_cause(&unlit, 0, 0.0, 0.5), DarkCause::NoLight);
        let mut hidden = scene(FAR, 1.0);
        hidden.nodes[0].visible = Track::from(false);
        assert_eq!(dark_cause(&hidden, 0, 0.0, 0.0), DarkCause::NothingVisible);
        assert_eq!(dark_cause(&scene(FAR, 1.0), 0, 0.0, 0.0), DarkCause::OutsidePicture);
        assert_eq!(dark_cause(&scene(FAR, 0.0), 0, 0.0, 0.5), DarkCause::LightsOff);
        let three_lux = DarkCause::DimLights { lux_or_candela: 3.0 };
        assert_eq!(dark_cause(&scene(FAR, 3.0 / LUMENS_PER_WATT), 0, 0.0, 0.5), three_lux);
        let inside = DarkCause::InsideObject(String::from("cube"));
        assert_eq!(dark_cause(&scene(DVec3::ZERO, 1.0), 0, 0.0, 1.0), inside);
        assert_eq!(dark_cause(&scene(FAR, 1.0), 0, 0.0, 1.0), DarkCause::TooLittleLight);
    }

    #[test]
    fn what_emits_is_light() {
        let mut emissive = Scene { lights: Vec::new(), ..scene(FAR, 1.0) };
        emissive.materials[0].emission = Rgb::splat(1e-6);
        assert_eq!(dark_cause(&emissive, 0, 0.0, 0.5), DarkCause::TooLittleLight);
    }

    /// Only numbers that were taken for lux and candela are doubted, and only if all are small.
    #[test]
    fn dim_lights_are_remarked_where_their_units_were_guessed() {
        let remark = |scene: &Scene| remark(scene, 0.0, Place::Nowhere);
        let dim = scene(FAR, 0.01);
        let told = remark(&dim).expect("a remark").to_string();
        assert!(told.contains("6.830 lux") && told.contains("--light-units compat"), "{told}");
        for units in [None, Some(LightUnits::Compat)] {
            assert_eq!(remark(&Scene { guessed_light_units: units, ..dim.clone() }), None);
        }
        let mut both = dim.clone();
        both.lights.extend(scene(FAR, 3.0).lights);
        assert_eq!(remark(&both), None);
        assert_eq!(remark(&scene(FAR, 0.0)), None);
    }

    #[test]
    fn the_flag_that_helps_is_named() {
        assert!(DarkCause::DimLights { lux_or_candela: 3.0 }.remedy().contains("--light-units compat"));
        assert!(DarkCause::NoLight.remedy().contains("--default-light"));
        assert!(DarkCause::OutsidePicture.remedy().contains("--camera"));
    }
}
