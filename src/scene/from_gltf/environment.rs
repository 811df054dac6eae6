//! `sunfleck_env` of a scene in, its background or its sky out. Invariant: what lights nothing and is the same
//! everywhere is a background.

use super::extras::read;
use crate::color::Rgb;
use crate::description::gltf::report::Report;
use crate::scene::{Sky, SkyLight, SkyPicture};
use serde::Deserialize;
use serde_json::Value;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Environment {
    color: Option<[f64; 3]>,
    zenith: Option<[f64; 3]>,
    horizon: Option<[f64; 3]>,
    #[serde(default)]
    ground: [f64; 3],
    #[serde(default = "one")]
    strength: f64,
    #[serde(default)]
    lights: Lights,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Lights {
    #[default]
    Nothing,
    Surfaces,
    SurfacesAndFog,
}

fn one() -> f64 {
    1.0
}

/// What lies behind the scene, from the extras that stand at `path`.
pub(super) fn surroundings(extras: &Value, path: &str, report: &mut Report) -> (Rgb, Option<Sky>) {
    let nothing = (Rgb::ZERO, None);
    let Some(found) = read::<Environment>(extras, "sunfleck_env", path, report) else { return nothing };
    let path = format!("{path}.extras.sunfleck_env");
    let scaled = |color: [f64; 3]| Rgb::from(color) * found.strength;
    let picture = match (found.color, found.zenith, found.horizon) {
        (Some(color), None, None) => SkyPicture::Even(scaled(color)),
        (None, Some(zenith), Some(horizon)) => SkyPicture::Gradient {
            zenith: scaled(zenith),
            horizon: scaled(horizon),
            ground: scaled(found.ground),
        },
        _ => {
            report.error(path, "the sky is not told, or told twice", "either color, or zenith and horizon");
            return nothing;
        }
    };
    let colors = match picture {
        SkyPicture::Gradient { zenith, horizon, ground } => vec![zenith, horizon, ground],
        SkyPicture::Even(color) => vec![color],
        SkyPicture::Image(_) => vec![],
    };
    if let Some(bad) = colors.iter().find(|color| color.min_element() < 0.0 || !color.is_finite()) {
        let found = format!("the background's radiance is {bad}");
        report.error(path, found, "colors and a strength of at least 0");
        return nothing;
    }
    let lights = match found.lights {
        Lights::Nothing => SkyLight::Nothing,
        Lights::Surfaces => SkyLight::Surfaces,
        Lights::SurfacesAndFog => SkyLight::SurfacesAndFog,
    };
    match picture {
        SkyPicture::Even(background) if lights == SkyLight::Nothing => (background, None),
        // A black one is none.
        picture => (Rgb::ZERO, Sky::new(picture).map(|sky| sky.with(Rgb::ONE.into(), 0.0.into(), lights))),
    }
}
