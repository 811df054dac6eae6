//! A [`Description`] in, a [`Scene`] and its [`RenderSettings`] out. Invariant: what cannot be
//! honoured is in [`Scene::remarks`], what cannot be rendered is an error; nothing is dropped in silence.

use super::{Baking, MOST_FOGS, RenderSettings, Scene, from_gltf, from_ron};
use crate::description::{Description, SceneSource};
use crate::diagnostic::{Diagnostic, Diagnostics, Place};

/// Which photometric units a glTF file's lights are in; the file does not say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightUnits {
    /// Lux and candela (Blender's default export): W = value / 683.
    Spec,
    /// Blender's "Unitless": W/m^2 and W/sr as they stand.
    Compat,
    /// Blender's "Raw": sun in W/m^2, point and spot in W of radiant power over 4 pi sr.
    Raw,
}

/// What whoever renders wants of an input, beside what it says itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ResolveOptions {
    /// What the lights of a glTF file are measured in, whatever it says.
    pub light_units: Option<LightUnits>,
    /// Which animations of a glTF file play, whatever its sequence says: a name, a number from 0, or `all`.
    pub animation: Option<String>,
}

/// Resolves everything once. `light_units` overrides what a glTF file says of its lights.
///
/// # Errors
/// Every problem that was found, if any of them is an error.
pub fn resolve(
    description: Description,
    light_units: Option<LightUnits>,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    resolve_telling(description, &ResolveOptions { light_units, ..ResolveOptions::default() }, &Baking::ALONE)
}

/// The same, on the threads that it is called on; falls that take their time are told of and kept.
///
/// # Errors
/// Every problem that was found, if any of them is an error.
pub fn resolve_telling(
    description: Description,
    options: &ResolveOptions,
    baking: &Baking,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    let file = Place::File(description.path);
    let (scene, settings) = match description.scene {
        SceneSource::Ron(scene) => from_ron::resolve(scene, description.sequence, baking)?,
        SceneSource::Gltf(scene) => {
            let of_sequence = || description.sequence.as_ref()?.fields.animation.clone();
            let animation = options.animation.clone().or_else(of_sequence);
            let options = ResolveOptions { animation, ..options.clone() };
            let (scene, settings) = from_gltf::resolve(scene, &options)?;
            match description.sequence {
                None => (scene, settings),
                Some(sequence) => {
                    let settings = from_ron::apply_sequence(sequence, &scene, settings)?;
                    (scene, settings)
                }
            }
        }
    };
    if scene.fogs.len() > MOST_FOGS {
        let found = format!("there are {} banks of fog", scene.fogs.len());
        let error = Diagnostic::error(file, found)
            .expected(format!("at most {MOST_FOGS}"))
            .remedy("make one larger bank of several, or render the scene in parts");
        return Err(Diagnostics(vec![error]));
    }
    Ok((scene, settings))
}
