//! Command `export`: an input as glTF. In goes an input, out comes a file. Invariant: the file is whole or
//! absent, and losses are reported.

use super::arguments::ExportArguments;
use super::error::usage;
use super::saving::save;
use super::words::Switch;
use super::{CliError, answer, loading, tell};
use std::ops::RangeInclusive;
use std::path::Path;
use sunfleck::api::Scene;
use sunfleck::description;
use sunfleck::diagnostic::{Diagnostics, shown};
use sunfleck::scene::ResolveOptions;
use sunfleck::sequence::FrameList;

pub(super) fn run(arguments: &ExportArguments) -> Result<(), CliError> {
    let output = &arguments.output;
    if output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("glb")) {
        let found = format!("`{}` is no name of a binary glTF file", shown(output));
        return Err(usage("OUT.glb", found, "a name that ends in .glb"));
    }
    let description = description::load(&arguments.input)?;
    loading::check_not_read("OUT.glb", [output], &description.files)?;
    // Readers of a file without light add their own, so default light is exported only on request.
    let no_default_light = arguments.scene.default_light != Some(Switch::On);
    let options = ResolveOptions { no_default_light, ..arguments.scene.options() };
    let scene = loading::resolve(description, &options, &arguments.scene.bakes, true)?;
    let frames = frames(arguments.frames.as_deref(), &scene)?;
    let (first, last) = (*frames.start(), *frames.end());
    if first == last && arguments.frames.is_none() && !scene.resolved().is_still() {
        tell(&format!(
            "note: things move, and frame {first} alone is exported\n  remedy: --frames 1-48, or a sequence"
        ));
    }
    let folder = output.parent().unwrap_or(Path::new(""));
    let exported = scene.export(frames, folder).map_err(|error| CliError::Scene(Diagnostics(vec![error])))?;
    let remarks = Diagnostics([scene.resolved().remarks.0.clone(), exported.remarks.0].concat());
    arguments.scene.check(&remarks)?;
    remarks.reported().for_each(|remark| tell(&remark.to_string()));
    save(output, &[&exported.head, &exported.binary])?;
    let files: Vec<String> = exported.files.iter().map(|uri| format!(", beside `{uri}`")).collect();
    answer(&format!(
        "{}: {:.1} MB, {} nodes, {} moving values over frames {first} to {last}{}",
        shown(output),
        (exported.head.len() + exported.binary.len()) as f64 / 1e6,
        scene.nodes().count(),
        exported.channels,
        files.concat()
    ))
}

/// Range from the first to the last frame of a list, or all frames.
fn frames(list: Option<&str>, scene: &Scene) -> Result<RangeInclusive<i64>, CliError> {
    let Some(list) = list else { return Ok(scene.frames()) };
    let frames = FrameList::parse(list, scene.frames()).map_err(CliError::Usage)?;
    match (frames.as_slice().iter().min(), frames.as_slice().iter().max()) {
        (Some(&first), Some(&last)) => Ok(first..=last),
        _ => {
            let expected = "its first and last frame, such as 1-48";
            Err(usage("--frames", "an animation of no frames".into(), expected))
        }
    }
}
