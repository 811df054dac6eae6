//! `sunfleck inspect`: what an input holds. In goes a file, out comes text or JSON. Invariant:
//! whatever rendering would leave out or do differently is said here.

mod json;
mod text;

use super::arguments::InspectArguments;
use super::{CliError, answer};
use crate::description;
use crate::scene::{self, RenderSettings, Scene};

/// An input, resolved.
struct Inspected {
    input: String,
    scene_hash: String,
    scene: Scene,
    settings: RenderSettings,
}

pub(super) fn run(arguments: &InspectArguments) -> Result<(), CliError> {
    let description = description::load(&arguments.input)?;
    let scene_hash = description.content_hash.clone();
    let (scene, settings) = scene::resolve(description, arguments.light_units.map(Into::into))?;
    let inspected = Inspected { input: arguments.input.display().to_string(), scene_hash, scene, settings };
    let frames = if arguments.frames.is_empty() {
        vec![*inspected.settings.frames.start() as f64]
    } else {
        arguments.frames.clone()
    };
    answer(&if arguments.json {
        json::describe(&inspected, &frames)
    } else {
        text::describe(&inspected, &frames)
    });
    Ok(())
}
