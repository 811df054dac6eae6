//! The sky's image, which the extras of a scene name. In goes that name, out comes the image. Invariant: only the image
//! of the scene that is shown is opened.

use super::buffers::fetch;
use super::report::Report;
use super::{GltfScene, LoadError, invalid};
use crate::description::Files;
use crate::description::image::{self, DecodedImage, Encoding};

/// The image of `sunfleck_env`, if it has one; what is malformed is reported with the other extras.
pub(super) fn image(
    scene: &GltfScene,
    files: &mut Files,
    report: &mut Report,
) -> Result<Option<DecodedImage>, LoadError> {
    let named = scene.extras.get("sunfleck_env").and_then(|sky| sky.get("image"));
    let Some(uri) = named.and_then(|name| name.as_str()) else { return Ok(None) };
    let place = format!("scenes[{}].extras.sunfleck_env.image", scene.scene);
    let bytes = fetch(uri, &scene.path, files, &format!("{}: {place}", scene.path.display()))?;
    let bytes = bytes.map_err(|found| {
        invalid(&scene.path, place.as_str(), found)
            .expected("an image beside the file, or a data URI")
            .remedy("give the image's name relative to the file")
    });
    let decoded = bytes.and_then(|bytes| image::decode(&bytes, Encoding::Radiance, report.at(place)));
    Ok(report.keep(decoded))
}
