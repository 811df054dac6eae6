//! Command `inspect`: contents of an input. In goes a file, out comes text or JSON. Invariant: everything
//! that rendering would drop or change is reported.

mod grids;
mod json;
mod properties;
mod text;
mod units;

pub(super) use json::losses;

use super::arguments::InspectArguments;
use super::parse::parse_frame;
use super::plan::{self, resized};
use super::{CliError, answer, loading};
use std::ops::RangeInclusive;
use std::path::PathBuf;
use sunfleck::api::{Plan, Renderer};
use sunfleck::description;
use sunfleck::scene::{RenderSettings, Scene, Size};
use sunfleck::sequence::FrameList;

/// Input, and its render settings.
struct Inspected<'a> {
    input: String,
    scene: &'a Scene,
    settings: &'a RenderSettings,
    plan: &'a Plan<'a>,
}

pub(super) fn run(arguments: &InspectArguments) -> Result<(), CliError> {
    if grids::holds(&arguments.input) && !arguments.json && !arguments.dependencies {
        return answer(&grids::describe(&arguments.input)?);
    }
    let description = description::load(&arguments.input)?;
    if arguments.dependencies {
        return answer(&dependencies(&description.files));
    }
    let scene =
        loading::seen(description, &arguments.scene, arguments.size, arguments.camera.as_ref(), true)?;
    let mut renderer = Renderer::new(&scene);
    if let Some(size) = arguments.size {
        let Size { width, height } = resized(scene.size(), size)?;
        renderer = renderer.size(width, height);
    }
    let plan = arguments.tolerance.into_iter().fold(renderer, Renderer::tolerance).plan()?;
    let inspected = Inspected {
        input: arguments.input.display().to_string(),
        scene: scene.resolved(),
        settings: &plan.settings,
        plan: &plan,
    };
    let frames = match &arguments.frames {
        None => vec![*scene.frames().start() as f64],
        Some(list) => moments(list, scene.frames())?,
    };
    answer(&if arguments.json {
        json::describe(&inspected, &frames)
    } else {
        text::describe(&inspected, &frames)
    })?;
    arguments.scene.check(&inspected.plan.remarks)
}

/// Frames of a list as for `render`, but fractions are allowed.
fn moments(list: &str, all: RangeInclusive<i64>) -> Result<Vec<f64>, CliError> {
    let list = plan::listed(list)?;
    let mut frames = Vec::new();
    for item in list.trim().split(',') {
        match parse_frame(item) {
            Ok(frame) => frames.push(frame),
            Err(_) => {
                let found = FrameList::parse(item.trim(), all.clone()).map_err(CliError::Usage)?;
                frames.extend(found.as_slice().iter().map(|&frame| frame as f64));
            }
        }
    }
    Ok(frames)
}

/// Absolute paths, one a line.
fn dependencies(files: &[PathBuf]) -> String {
    let absolute = files.iter().map(|file| std::path::absolute(file).unwrap_or_else(|_| file.clone()));
    absolute.map(|file| file.display().to_string()).collect::<Vec<_>>().join("\n")
}
