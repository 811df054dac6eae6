//! Default light: a soft key sun and a uniform sky, as in viewers of models. In goes a scene with a camera,
//! out comes one with light. Invariant: the lights are fixed relative to the camera of the first frame. So a
//! frame rendered alone equals that of the sequence, and a moving camera does not change the light.

use super::{Light, LightKind, Motion, RenderSettings, Scene, Sky, SkyLight, SkyPicture, SunDisc, Track};
use crate::color::Rgb;
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::PI;

const NAME: &str = "default key";

/// Direction to the sun in camera space: to the left, above and behind.
const TO_KEY: DVec3 = DVec3::new(-0.5, 0.7, 0.75);

/// Full angle of the sun's disc, radians, for soft shadows.
const KEY_DIAMETER: f64 = 10.0 * PI / 180.0;

/// W/m^2. With the sky, a white surface that faces the camera reflects about 1 W m^-2 sr^-1, and middle grey
/// (0.18) about 0.18, the middle of display transforms.
const KEY_IRRADIANCE: f64 = 1.1 * PI;

/// W m^-2 sr^-1, uniform.
const SKY_RADIANCE: f64 = 0.25;

/// Whether the scene has no light, sky, background or emissive fog. Emissive surfaces alone still get a
/// default light, to be seen better.
pub(super) fn is_wanted(scene: &Scene) -> bool {
    let has_fire = scene.fogs.iter().any(|fog| fog.shape.emits());
    scene.lights.is_empty() && scene.sky.is_none() && scene.background == Rgb::ZERO && !has_fire
}

/// Adds the lights. The sky lights surfaces alone, as it would turn fog white.
pub(super) fn add(scene: &mut Scene, settings: &RenderSettings) {
    let to_key = (camera_axes(scene, settings) * TO_KEY).normalize();
    let (x, y) = to_key.any_orthonormal_pair();
    let turned = DAffine3::from_mat3(DMat3::from_cols(x, y, to_key));
    let name = String::from(NAME);
    let node = scene.add_node(name.clone(), None, Motion::Still(turned));
    let kind = LightKind::SunDisc(SunDisc::even(Track::from(KEY_DIAMETER)));
    scene.lights.push(Light { name, node, power: Rgb::splat(KEY_IRRADIANCE).into(), kind });
    let sky = Sky::new(SkyPicture::Even(Rgb::splat(SKY_RADIANCE)));
    scene.sky = sky.map(|sky| sky.with(Rgb::ONE.into(), 0.0.into(), SkyLight::Surfaces));
}

/// Right, up and backward axes of the rendering camera, at the first frame.
fn camera_axes(scene: &Scene, settings: &RenderSettings) -> DMat3 {
    let named = |name: &String| scene.cameras.iter().find(|camera| camera.name == *name);
    let Some(camera) = settings.camera.as_ref().and_then(named).or(scene.cameras.first()) else {
        return DMat3::IDENTITY;
    };
    let time_s = settings.frame_rate.seconds(*settings.frames.start() as f64);
    let axes = scene.placement(camera.node, time_s).world_from_node.matrix3;
    let backward = axes.z_axis.try_normalize().unwrap_or(DVec3::Z);
    let right = axes.y_axis.cross(backward).try_normalize();
    let right = right.unwrap_or_else(|| backward.any_orthonormal_vector());
    DMat3::from_cols(right, backward.cross(right), backward)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::{Display, luminance};
    use crate::scene::default_view;
    use glam::DQuat;

    fn lit(world_from_camera: DAffine3) -> Scene {
        let mut scene = Scene::default();
        default_view::add(&mut scene);
        scene.nodes[0].motion = Motion::Still(world_from_camera);
        add(&mut scene, &RenderSettings::default());
        scene
    }

    /// Towards the sun, in the space of a camera.
    fn to_key(scene: &Scene, world_from_camera: DAffine3) -> DVec3 {
        let light = scene.placements(0.0)[scene.lights[0].node].world_from_node;
        let camera = DMat3::from_quat(DQuat::from_mat3(&world_from_camera.matrix3));
        camera.transpose() * light.matrix3.z_axis
    }

    #[test]
    fn the_sun_stands_to_the_left_above_and_behind_whatever_way_the_camera_looks() {
        for turn in [0.0, 1.0, 2.5] {
            let turned = DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(-turn);
            let camera = DAffine3::from_rotation_translation(turned, DVec3::splat(3.0));
            let to_key = to_key(&lit(camera), camera);
            assert!(to_key.abs_diff_eq(TO_KEY.normalize(), 1e-9), "{to_key}");
        }
        let [to_left, up, back] = to_key(&lit(DAffine3::IDENTITY), DAffine3::IDENTITY).to_array();
        assert!(to_left < 0.0 && up > 0.0 && back > 0.0);
        // A camera whose node is squashed to nothing stands for one that is not turned.
        let nothing = DAffine3::from_scale(DVec3::ZERO);
        assert!(to_key(&lit(nothing), DAffine3::IDENTITY).is_finite());
    }

    /// Display values of a matte surface that faces the camera: of middle grey, and of white.
    #[test]
    fn middle_grey_is_shown_as_such_and_white_is_not_cut_off() {
        let radiance = |albedo: f64| albedo * (KEY_IRRADIANCE * TO_KEY.normalize().z / PI + SKY_RADIANCE);
        let shown = |albedo: f64| luminance(Display::default().encode(Rgb::splat(radiance(albedo))));
        assert!((0.18..0.5).contains(&shown(0.18)), "{}", shown(0.18));
        assert!((0.15..0.22).contains(&radiance(0.18)), "{}", radiance(0.18));
        assert!((0.7..0.85).contains(&shown(0.9)), "{}", shown(0.9));
    }

    #[test]
    fn whatever_lights_or_surrounds_a_scene_is_enough() {
        assert!(is_wanted(&Scene::default()));
        let lit = lit(DAffine3::IDENTITY);
        let sky = Scene { sky: lit.sky.clone(), ..Scene::default() };
        let background = Scene { background: Rgb::X, ..Scene::default() };
        for scene in [lit, sky, background] {
            assert!(!is_wanted(&scene));
        }
    }

    #[test]
    fn the_sky_leaves_fog_alone() {
        let sky = lit(DAffine3::IDENTITY).sky.expect("a sky");
        assert_eq!(sky.lights, SkyLight::Surfaces);
    }
}
