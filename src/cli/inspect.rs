//! `sunfleck inspect`: what an input holds. In goes a file, out comes text or JSON. Invariant:
//! whatever rendering would leave out or do differently is said here.

mod json;
mod properties;
mod text;
mod units;

pub(super) use json::losses;

use super::arguments::InspectArguments;
use super::plan::{find_camera, resized};
use super::{CliError, answer, loading};
use crate::description;
use crate::render::{Choice, choose};
use crate::scene::{RenderSettings, Sampling, Scene};
use crate::snapshot::{Exposure, MeshTrees, Shutter};
use std::path::PathBuf;

/// An input, resolved.
struct Inspected {
    input: String,
    scene_hash: String,
    scene: Scene,
    settings: RenderSettings,
    trees: MeshTrees,
}

impl Inspected {
    /// How `--volume auto` renders a frame.
    fn choice(&self, frame: f64) -> Choice {
        let Self { scene, settings, .. } = self;
        let wanted = settings.camera.as_deref();
        let camera = scene.cameras.iter().position(|camera| wanted == Some(&camera.name)).unwrap_or(0);
        let aspect = settings.size.width as f64 / settings.size.height as f64;
        choose(&Exposure::middle_of(scene, &self.trees, camera, aspect, Shutter::of(settings, frame)))
    }
}

pub(super) fn run(arguments: &InspectArguments) -> Result<(), CliError> {
    let description = description::load(&arguments.input)?;
    if arguments.dependencies {
        return answer(&dependencies(&description.files));
    }
    let scene_hash = description.content_hash.clone();
    let (mut scene, mut settings) =
        loading::resolve(description, &arguments.options(), &arguments.scene.bakes, true)?.into_parts();
    if let Some(size) = arguments.size {
        settings.size = resized(settings.size, size)?;
    }
    settings.frame_rate = arguments.fps.unwrap_or(settings.frame_rate);
    settings.sampling = Sampling::said(None, arguments.tolerance).unwrap_or(settings.sampling);
    settings.camera = arguments.camera.clone().or(settings.camera);
    find_camera(&scene, settings.camera.as_deref())?;
    scene.remarks.0.extend(Exposure::remark(&scene, settings.shutter));
    let input = arguments.input.display().to_string();
    let trees = MeshTrees::new(&scene);
    let inspected = Inspected { input, scene_hash, scene, settings, trees };
    let frames = if arguments.frames.is_empty() {
        vec![*inspected.settings.frames.start() as f64]
    } else {
        arguments.frames.clone()
    };
    answer(&if arguments.json {
        json::describe(&inspected, &frames)
    } else {
        text::describe(&inspected, &frames)
    })?;
    arguments.scene.check(&inspected.scene.remarks)
}

/// A path a line, from the root of the file system.
fn dependencies(files: &[PathBuf]) -> String {
    let absolute = files.iter().map(|file| std::path::absolute(file).unwrap_or_else(|_| file.clone()));
    absolute.map(|file| file.display().to_string()).collect::<Vec<_>>().join("\n")
}
