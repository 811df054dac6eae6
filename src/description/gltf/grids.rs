//! OpenVDB files in the extras of fog. In go their names, out come grids. Invariant: only files that the
//! shown scene uses are opened.

use super::buffers::file_beside;
use super::report::Report;
use super::{GltfScene, LoadError, invalid, pictures};
use crate::description::{Files, vdb};
use std::collections::BTreeMap;

/// Reads all grids; other faults of extras are reported elsewhere.
pub(super) fn read(scene: &mut GltfScene, files: &mut Files, report: &mut Report) -> Result<(), LoadError> {
    let mut grids = BTreeMap::new();
    for index in pictures::shown_nodes(scene) {
        let named = scene.nodes[index].extras.get("sunfleck_fog_volume").and_then(|fog| fog.get("vdb"));
        let Some(uri) = named.and_then(|name| name.as_str()) else { continue };
        if grids.contains_key(uri) {
            continue;
        }
        let place = format!("nodes[{index}].extras.sunfleck_fog_volume.vdb");
        let path = match file_beside(uri, &scene.path) {
            Ok(path) => path,
            Err(found) => {
                let error = invalid(&scene.path, place, found)
                    .expected("an OpenVDB file beside this one")
                    .remedy("give the file's name relative to this one");
                report.push(error);
                continue;
            }
        };
        match vdb::load_files(&path, &format!("{}: {place}", scene.path.display()), files) {
            Ok(found) => {
                grids.insert(uri.to_owned(), found);
            }
            Err(LoadError::Invalid(problems)) => {
                problems.0.into_iter().for_each(|problem| report.push(problem));
            }
            Err(error) => return Err(error),
        }
    }
    scene.grids = grids;
    Ok(())
}
