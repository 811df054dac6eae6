//! Light for inputs that have none: a soft key sun and an even sky, as in a viewer of models. In goes a scene with a
//! camera, out comes one that is lit. Invariant: the lights stand still in the frame of the camera at the first frame, so
//! a frame rendered alone is the frame of the sequence, and a moving camera does not make the light flicker.

use super::{
    Light, LightKind, Motion, Node, RenderSettings, Scene, Sky, SkyLight, SkyPicture, SunDisc, Track,
};
use crate::color::Rgb;
use glam::{DAffine3, DMat3, DVec3};
use std::f64::consts::PI;

/// What the sun and its node are called.
const NAME: &str = "default key";

/// Where the sun stands, in camera space: to the left, above and behind.
const TO_KEY: DVec3 = DVec3::new(-0.5, 0.7, 0.75);

/// The whole angle of the sun's disc, radians: shadows have soft edges.
const KEY_DIAMETER: f64 = 10.0 * PI / 180.0;

/// W/m^2. A white surface that faces the camera sends back about 1 W m^-2 sr^-1 with the sky's light, and middle grey (0.18) about 0.18,
/// which display transforms show in the middle of their range.
const KEY_IRRADIANCE: f64 = 1.1 * PI;

/// W m^-2 sr^-1, from everywhere.
const SKY_RADIANCE: f64 = 0.25;

/// Whether nothing lights the scene and nothing lies behind it; what glows by itself is seen better with a light beside it.
pub(super) fn is_wanted(scene: &Scene) -> bool {
    scene.lights.is_empty() && scene.sky.is_none() && scene.background == Rgb::ZERO
}

/// Adds the lights. The sky lights surfaces alone: fog would turn white in it.
pub(super) fn add(scene: &mut Scene, settings: &RenderSettings) {
    let to_key = (camera_axes(scene, settings) * TO_KEY).normalize();
    let (x, y) = to_key.any_orthonormal_pair();
    let turned = DAffine3::from_mat3(DMat3::from_cols(x, y, to_key));
    let node = scene.nodes.len();
    let name = String::from(NAME);
    let visible = Track::from(true);
    scene.nodes.push(Node { name: name.clone(), parent: None, motion: Motion::Still(turned), visible });
    let kind = LightKind::SunDisc(SunDisc::even(Track::from(KEY_DIAMETER)));
    scene.lights.push(Light { name, node, power: Rgb::splat(KEY_IRRADIANCE).into(), kind });
    let sky = Sky::new(SkyPicture::Even(Rgb::splat(SKY_RADIANCE)));
    scene.sky = sky.map(|sky| sky.with(Rgb::ONE.into(), 0.0.into(), SkyLight::Surfaces));
}

/// Right, up and backward of the camera that renders, at the first frame.
fn camera_axes(scene: &Scene, settings: &RenderSettings) -> DMat3 {
    let named = |name: &String| scene.cameras.iter().find(|camera| camera.name == *name);
    let Some(camera) = settings.camera.as_ref().and_then(named).or(scene.cameras.first()) else {
        return DMat3::IDENTITY;
    };
    let time_s = settings.frame_rate.seconds(*settings.frames.start() as f64);
    let axes = scene.placements(time_s)[camera.node].world_from_node.matrix3;
    let backward = axes.z_axis.try_normalize().unwrap_or(DVec3::Z);
    let right = axes.y_axis.cross(backward).try_normalize();
    let right = right.unwrap_or_else(|| backward.any_orthonormal_vector());
    DMat3::from_cols(right, backward.cross(right), backward)
}
