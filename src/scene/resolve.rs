//! Resolution of an input. In goes a [`Description`], out come a [`Scene`] and its [`RenderSettings`].
//! Invariant: a request that is not honoured is in [`Scene::remarks`], and invalid input is an error; nothing
//! is dropped in silence.

use super::{
    Baking, LightUnits, MOST_FOGS, RenderSettings, ResolveOptions, Scene, darkness, default_light,
    default_view, flatness, from_gltf, from_ron, limits,
};
use crate::description::{Description, SceneSource};
use crate::diagnostic::{Diagnostic, Diagnostics, Loss, Place};

/// Resolves a description, without reports or a cache of bakes. `light_units` overrides the file's.
pub fn resolve(
    description: Description,
    light_units: Option<LightUnits>,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    let options = ResolveOptions { light_units, ..ResolveOptions::default() };
    resolve_telling(description, &options, &Baking::ALONE)
}

/// Resolves a description on the current rayon pool; `baking` reports and caches falls.
pub fn resolve_telling(
    description: Description,
    options: &ResolveOptions,
    baking: &Baking,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    let file = Place::File(description.path);
    let (is_bare, scene_path) = (description.scene.is_bare(), description.scene.path().to_owned());
    let has_default_light = !options.no_default_light && !description.scene.says_surroundings();
    let scene_file = Place::File(scene_path.clone());
    let of_sequence = || description.sequence.as_ref()?.fields.animation.clone();
    let animation = options.animation.clone().or_else(of_sequence);
    let holds_cameras = matches!(description.scene, SceneSource::Gltf(_));
    let (mut scene, mut settings) = match description.scene {
        SceneSource::Ron(scene) => {
            let of_sequence = || from_ron::frame_rate(description.sequence.as_ref()?);
            let frame_rate = options.frame_rate.or_else(of_sequence).unwrap_or_default();
            from_ron::resolve(scene, frame_rate, baking)?
        }
        SceneSource::Gltf(scene) => {
            from_gltf::resolve(scene, &ResolveOptions { animation, ..options.clone() })?
        }
    };
    // A sequence may name this camera, and its settings decide what it has to show.
    let has_made_up_camera = default_view::add(&mut scene);
    if let Some(sequence) = description.sequence {
        settings = from_ron::apply_sequence(sequence, &scene, settings)?;
    }
    // Other programs ignore hidden files, so frames must not begin with a dot.
    let visible = settings.name.trim_start_matches('.');
    settings.name = String::from(if visible.is_empty() { "scene" } else { visible });
    let rendered = options.overrule(&settings);
    if has_made_up_camera {
        default_view::aim(&mut scene, &rendered);
        scene.remarks.push(camera_made_up(&scene_file, holds_cameras));
    }
    if is_bare {
        light_up(&mut scene, &rendered, has_default_light, &scene_file);
    }
    if !options.keep_sky_suns {
        set_suns_apart(&mut scene, &scene_file);
    }
    let first_s = rendered.frame_rate.seconds(*rendered.frames.start() as f64);
    scene.remarks.0.extend(flatness::remark(&scene, first_s, scene_file.clone()));
    scene.remarks.0.extend(darkness::remark(&scene, first_s, scene_file));
    let banks: usize = scene.fogs.iter().map(|fog| fog.shape.most_banks()).sum();
    if banks > MOST_FOGS {
        let found = format!("there are {banks} banks of fog");
        let error = Diagnostic::error(file, found)
            .expected(format!("at most {MOST_FOGS}; one whose albedo differs by voxel counts as six"))
            .remedy("make one larger bank of several, or render the scene in parts");
        return Err(Diagnostics(vec![error]));
    }
    limits::check(&scene, &scene_path)?;
    // Nodes were pushed one by one, and none will follow.
    scene.nodes.shrink_to_fit();
    scene.instances.shrink_to_fit();
    Ok((scene, settings))
}

/// Makes lights of the suns in a sky's picture.
fn set_suns_apart(scene: &mut Scene, file: &Place) {
    let Some(sky) = scene.sky.take() else { return };
    let sky = scene.sky.insert(sky.with_suns_apart());
    let found = match sky.suns_apart() {
        0 => return,
        1 => String::from("the sky's picture shows a sun, which lights as a `Sun` does"),
        count => format!("the sky's picture shows {count} suns, which light as `Sun`s do"),
    };
    let found = format!("{found} (--sky-sun off leaves all light to the picture)");
    scene.remarks.push(Diagnostic::choice(file.clone(), found));
}

fn camera_made_up(file: &Place, holds_cameras: bool) -> Diagnostic {
    let found =
        "the scene has no camera: one is made up, at three quarters, that sees all of it in every frame";
    let choice = Diagnostic::choice(file.clone(), found);
    if holds_cameras {
        choice.remedy("export with cameras (Blender: Include > Cameras; off by default)")
    } else {
        choice
    }
}

/// Adds default light to an input in a format whose files mostly have none.
fn light_up(scene: &mut Scene, settings: &RenderSettings, has_default: bool, file: &Place) {
    if default_light::is_wanted(scene) {
        if has_default {
            default_light::add(scene, settings);
            let found = "the scene has no light: a sun behind the camera and an even sky light it (--default-light off leaves it dark)";
            scene.remarks.push(Diagnostic::choice(file.clone(), found));
        }
        return;
    }
    let first_s = settings.frame_rate.seconds(*settings.frames.start() as f64);
    if scene.lights.is_empty() && scene.sky.is_none() && !darkness::emits(scene, first_s) {
        let found = "the scene has a background and no light";
        let remedy = "export with lights, or let the background light surfaces: `lights` of `sunfleck_env`";
        scene.remarks.push(Diagnostic::warning(Loss::NoLight, file.clone(), found).remedy(remedy));
    }
}
