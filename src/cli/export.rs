//! `sunfleck export`: an input becomes a glTF file. Invariant: the file is whole or not there, and what
//! it does not carry is said.

use super::arguments::ExportArguments;
use super::error::usage;
use super::saving::save;
use super::{CliError, answer, loading, tell};
use crate::diagnostic::{Diagnostics, shown};
use crate::sequence::FrameList;
use crate::{description, export};

pub(super) fn run(arguments: &ExportArguments) -> Result<(), CliError> {
    let output = &arguments.output;
    if output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("glb")) {
        let found = format!("`{}` is no name of a binary glTF file", shown(output));
        return Err(usage("OUT.glb", found, "a name that ends in .glb"));
    }
    let description = description::load(&arguments.input)?;
    loading::check_not_read("OUT.glb", output, &description.files)?;
    let (scene, mut settings) =
        loading::resolve(description, &arguments.options(), &arguments.scene.bakes, true)?.into_parts();
    settings.frame_rate = arguments.fps.unwrap_or(settings.frame_rate);
    if let Some(list) = &arguments.frames {
        let frames = FrameList::parse(list, settings.frames.clone()).map_err(CliError::Usage)?;
        let (first, last) = (frames.as_slice().iter().min(), frames.as_slice().iter().max());
        let (Some(&first), Some(&last)) = (first, last) else {
            return Err(usage(
                "--frames",
                "an animation of no frames".into(),
                "its first and last frame, such as 1-48",
            ));
        };
        settings.frames = first..=last;
    }
    let exported =
        export::glb(&scene, &settings).map_err(|error| CliError::Scene(Diagnostics(vec![error])))?;
    let remarks = Diagnostics([scene.remarks.0.clone(), exported.remarks.0].concat());
    arguments.scene.check(&remarks)?;
    remarks.told().for_each(|remark| tell(&remark.to_string()));
    save(output, &[&exported.head, &exported.binary])?;
    let (first, last) = (settings.frames.start(), settings.frames.end());
    answer(&format!(
        "{}: {:.1} MB, {} nodes, {} moving values over frames {first} to {last}",
        shown(output),
        (exported.head.len() + exported.binary.len()) as f64 / 1e6,
        scene.nodes.len(),
        exported.channels
    ))
}
