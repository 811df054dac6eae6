//! Images in extras: the sky's and those on suns. In go their names, out come images. Invariant: only images
//! that the shown scene uses are opened.

use super::buffers::fetch;
use super::report::Report;
use super::{GltfScene, LightKind, LoadError, invalid, textures};
use crate::description::Files;
use crate::description::image::{self, DecodedImage, Encoding};
use crate::diagnostic::Diagnostic;
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Reads all images; other faults of extras are reported elsewhere.
pub(super) fn read(scene: &mut GltfScene, files: &mut Files, report: &mut Report) -> Result<(), LoadError> {
    scene.sky_image = of_sky(scene, "image", files, report)?;
    scene.backdrop_image = of_sky(scene, "backdrop/image", files, report)?;
    let mut on_suns = BTreeMap::new();
    let is_sun = |light: usize| matches!(scene.lights[light].kind, LightKind::Directional);
    for index in shown_nodes(scene) {
        if !scene.nodes[index].light.is_some_and(is_sun) {
            continue;
        }
        let named = scene.nodes[index].extras.get("sunfleck_light").and_then(|light| light.get("image"));
        let Some(uri) = named.and_then(|name| name.as_str()) else { continue };
        if on_suns.contains_key(uri) {
            continue;
        }
        let place = format!("nodes[{index}].extras.sunfleck_light.image");
        let texels: usize = on_suns.values().map(|image: &DecodedImage| image.texels.len()).sum();
        if texels > textures::MAX_TEXELS {
            report.error(place, "the images on suns are too large together", "2^28 texels in all");
            break;
        }
        let image = decoded(bytes_of(scene, uri, &place, files)?, &place, Encoding::Srgb, report);
        on_suns.extend(image.map(|image| (uri.to_owned(), image)));
    }
    scene.sun_images = on_suns;
    Ok(())
}

/// Image in a field of `sunfleck_env`.
fn of_sky(
    scene: &GltfScene,
    field: &str,
    files: &mut Files,
    report: &mut Report,
) -> Result<Option<DecodedImage>, LoadError> {
    let named = scene.extras.pointer(&format!("/sunfleck_env/{field}"));
    let Some(uri) = named.and_then(|name| name.as_str()) else { return Ok(None) };
    let place = format!("scenes[{}].extras.sunfleck_env.{}", scene.scene, field.replace('/', "."));
    let bytes = bytes_of(scene, uri, &place, files)?;
    Ok(decoded(bytes, &place, Encoding::Radiance, report))
}

pub(super) fn shown_nodes(scene: &GltfScene) -> Vec<usize> {
    let mut was_there = vec![false; scene.nodes.len()];
    let mut waiting = scene.roots.clone();
    let mut shown = Vec::new();
    // The hierarchy may be damaged, which is reported already.
    while let Some(index) = waiting.pop() {
        let Some(node) = scene.nodes.get(index) else { continue };
        if !std::mem::replace(&mut was_there[index], true) {
            waiting.extend(&node.children);
            shown.push(index);
        }
    }
    shown.sort_unstable();
    shown
}

/// Bytes of an image, or the reason why there are none.
fn bytes_of<'a>(
    scene: &GltfScene,
    uri: &str,
    place: &str,
    files: &mut Files,
) -> Result<Result<Cow<'a, [u8]>, Diagnostic>, LoadError> {
    let bytes = fetch(uri, &scene.path, files, &format!("{}: {place}", scene.path.display()))?;
    Ok(bytes.map_err(|found| {
        invalid(&scene.path, place, found)
            .expected("an image beside the file, or a data URI")
            .remedy("give the image's name relative to the file")
    }))
}

fn decoded(
    bytes: Result<Cow<'_, [u8]>, Diagnostic>,
    place: &str,
    encoding: Encoding,
    report: &mut Report,
) -> Option<DecodedImage> {
    let image = bytes.and_then(|bytes| image::decode(&bytes, encoding, report.at(place)));
    report.keep(image)
}
