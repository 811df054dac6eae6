//! Resolution of glTF. In goes a glTF description, out come a [`Scene`] and its [`RenderSettings`].
//! Invariant: glTF's space is the world (metres, Y up); all animations that play do so at once.

mod animations;
mod cameras;
mod clock;
mod controls;
mod deformations;
mod environment;
mod extras;
mod fog;
mod grids;
mod joined;
mod light_extras;
mod lights;
mod masks;
mod material_extras;
mod meshes;
mod mist;
mod nodes;
mod properties;
mod settings;
mod sun_pictures;
mod surfaces;

use super::outline::Tally;
use super::{Light, LightKind, MaterialIndex, RenderSettings, ResolveOptions, Scene, Texture};
use crate::description::gltf::report::Report;
use crate::description::gltf::{Channel, GltfScene, Property};
use crate::diagnostic::{Diagnostic, Diagnostics, Loss};
use clock::Clock;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Scene under construction.
struct Builder<'a> {
    source: &'a GltfScene,
    clock: Clock,
    scene: Scene,
    report: Report,
    /// Index in the scene of each of the file's nodes; `None` for nodes outside.
    node_numbers: Vec<Option<usize>>,
    channels: BTreeMap<(Property, usize), &'a Channel>,
    /// Images on suns, by their names in the file.
    sun_images: BTreeMap<String, Arc<Texture>>,
    pictures_on_suns: usize,
    /// Meshes that masks have cut.
    outlines: Tally,
    /// Materials with an instance's colour, by the material and the colour.
    colored: BTreeMap<(MaterialIndex, [u64; 3]), MaterialIndex>,
}

/// Resolves a glTF file with these options.
pub(super) fn resolve(
    mut source: GltfScene,
    options: &ResolveOptions,
) -> Result<(Scene, RenderSettings), Diagnostics> {
    let mut report = Report::new(&source.path);
    std::mem::take(&mut source.remarks).0.into_iter().for_each(|remark| report.push(remark));
    let sky_images = [source.sky_image.take(), source.backdrop_image.take()];
    let sun_images = sun_pictures::images(std::mem::take(&mut source.sun_images));
    let (sunfleck, fog) = extras::scene_extras(&source, &mut report);
    let surroundings = environment::surroundings(&source, sky_images, &mut report);
    let mut animations = animations::choose(&mut source, options.animation.as_deref(), &mut report);
    let (mut settings, clock) = settings::settings(&source, &sunfleck, &mut report);

    animations::set_right(&mut animations, &clock);
    let textures = std::mem::take(&mut source.textures);
    let node_numbers = vec![None; source.nodes.len()];
    let mut builder = Builder {
        source: &source,
        clock,
        scene: Scene { animations, ..Scene::default() },
        report,
        node_numbers,
        channels: BTreeMap::new(),
        sun_images,
        pictures_on_suns: 0,
        outlines: Tally::default(),
        colored: BTreeMap::new(),
    };
    builder.collect_channels();
    builder.add_nodes();
    builder.add_surfaces(textures);
    builder.add_meshes_and_instances();
    builder.add_lights(options.light_units, sunfleck.light_units.as_deref());
    builder.add_fogs(fog);
    (builder.scene.background, builder.scene.sky, builder.scene.backdrop) = surroundings;
    builder.add_cameras(&sunfleck, &mut settings);
    builder.apply_controls();
    builder.settle_suns();
    builder.report_other_extras();
    builder.keep_properties();

    let Builder { mut scene, mut report, outlines, .. } = builder;
    let is_seen = |light: &Light| matches!(&light.kind, LightKind::SunDisc(disc) if disc.visible_to_camera);
    let has_sun_in_view = scene.lights.iter().any(is_seen);
    let is_dark_behind = scene.sky.is_none() && scene.backdrop.is_none();
    if scene.instances.is_empty() && scene.fogs.is_empty() && is_dark_behind && !has_sun_in_view {
        let (found, place) = (Loss::NothingToDraw.sentence(), report.file());
        report.push(Diagnostic::warning(Loss::NothingToDraw, place, found));
    }
    outlines.remark(report.at("meshes")).into_iter().for_each(|remark| report.push(remark));
    let remarks = report.into_diagnostics();
    if remarks.has_errors() {
        return Err(remarks);
    }
    scene.remarks = remarks;
    Ok((scene, settings))
}
