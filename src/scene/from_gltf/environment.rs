//! Environment of a scene. In goes `sunfleck_env`, out comes a background or a sky. Invariant: a uniform sky
//! that lights nothing is a background.

use super::extras::{Channels, read};
use crate::color::Rgb;
use crate::description::gltf::GltfScene;
use crate::description::gltf::report::Report;
use crate::description::image::DecodedImage;
use crate::diagnostic::Loss;
use crate::scene::{Sky, SkyLight, SkyPicture};
use serde::Deserialize;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Environment {
    color: Option<[f64; 3]>,
    zenith: Option<[f64; 3]>,
    horizon: Option<[f64; 3]>,
    #[serde(default)]
    ground: [f64; 3],
    /// Radiance HDR or OpenEXR: a file beside the glTF file, or a data URI.
    image: Option<String>,
    #[serde(default = "one")]
    strength: Channels,
    /// Rotation of an image about +y, anticlockwise from above, radians.
    #[serde(default)]
    rotation: f64,
    #[serde(default = "nothing", with = "Lights")]
    lights: SkyLight,
    #[serde(default = "seen")]
    visible_to_camera: bool,
    /// Environment for the camera alone; its `lights` and its visibility are ignored.
    backdrop: Option<Box<Environment>>,
}

#[derive(Deserialize)]
#[serde(remote = "SkyLight", rename_all = "snake_case")]
enum Lights {
    Nothing,
    Surfaces,
    SurfacesAndFog,
}

fn nothing() -> SkyLight {
    SkyLight::Nothing
}

fn seen() -> bool {
    true
}

fn one() -> Channels {
    Channels::Same(1.0)
}

/// Background, sky and backdrop in the scene's extras.
///
/// Images were read already, and errors reported.
pub(super) fn surroundings(
    source: &GltfScene,
    [image, of_backdrop]: [Option<DecodedImage>; 2],
    report: &mut Report,
) -> (Rgb, Option<Sky>, Option<Sky>) {
    let path = format!("scenes[{}]", source.scene);
    let found = read::<Environment>(&source.extras, "sunfleck_env", &path, report);
    let Some(mut found) = found else { return (Rgb::ZERO, None, None) };
    let path = format!("{path}.extras.sunfleck_env");
    let backdrop = found.backdrop.take().map(|backdrop| {
        found.visible_to_camera = false;
        let seen = Environment { lights: SkyLight::Surfaces, visible_to_camera: true, ..*backdrop };
        sky_of(&seen, of_backdrop, format!("{path}.backdrop"), report).1
    });
    let (background, sky) = sky_of(&found, image, path, report);
    (background, sky, backdrop.flatten())
}

fn sky_of(
    found: &Environment,
    image: Option<DecodedImage>,
    path: String,
    report: &mut Report,
) -> (Rgb, Option<Sky>) {
    let nothing = (Rgb::ZERO, None);
    let strength = Rgb::from(found.strength);
    let Some(picture) = picture(found, image, &path, report) else { return nothing };
    let colors = match picture {
        SkyPicture::Gradient { zenith, horizon, ground } => vec![zenith, horizon, ground],
        SkyPicture::Even(color) => vec![color],
        SkyPicture::Image(_) => vec![strength, Rgb::splat(found.rotation.abs())],
    };
    if let Some(bad) = colors.iter().find(|color| color.min_element() < 0.0 || !color.is_finite()) {
        let found = format!("the background's radiance is {bad}");
        report.error(path, found, "colors and a strength of at least 0");
        return nothing;
    }
    let lights = found.lights;
    match picture {
        _ if lights == SkyLight::Nothing && !found.visible_to_camera => nothing,
        SkyPicture::Even(background) if lights == SkyLight::Nothing => (background, None),
        // A black picture is no sky.
        picture => {
            let is_image = matches!(picture, SkyPicture::Image(_));
            let strength = if is_image { strength } else { Rgb::ONE };
            let sky = Sky::new(picture).filter(|_| strength != Rgb::ZERO);
            let mut sky = sky.map(|sky| sky.with(strength.into(), found.rotation.into(), lights));
            sky.iter_mut().for_each(|sky| sky.visible_to_camera = found.visible_to_camera);
            (Rgb::ZERO, sky)
        }
    }
}

/// Picture of the sky, times its strength unless it is an image.
fn picture(
    found: &Environment,
    image: Option<DecodedImage>,
    path: &str,
    report: &mut Report,
) -> Option<SkyPicture> {
    let strength = Rgb::from(found.strength);
    let scaled = |color: [f64; 3]| Rgb::from(color) * strength;
    Some(match (found.color, found.zenith, found.horizon, &found.image) {
        (Some(color), None, None, None) => SkyPicture::Even(scaled(color)),
        (None, None, None, Some(name)) => {
            let DecodedImage { width, height, texels, doubt } = image?;
            let name = if name.starts_with("data:") { "the sky" } else { name };
            if let Some((loss, found)) = doubt {
                report.put_right(loss, name, found);
            }
            let (picture, negative) = SkyPicture::of_image(name.to_owned(), [width, height], texels);
            if negative > 0 {
                report.not_honoured(Loss::NegativeRadiance, name);
            }
            picture
        }
        (None, Some(zenith), Some(horizon), None) => SkyPicture::Gradient {
            zenith: scaled(zenith),
            horizon: scaled(horizon),
            ground: scaled(found.ground),
        },
        _ => {
            report.error(
                path,
                "the sky is not told, or told twice",
                "either color, or zenith and horizon, or image",
            );
            return None;
        }
    })
}
