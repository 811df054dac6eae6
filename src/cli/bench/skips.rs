//! `sunfleck bench --skips`: what the renderer leaves out, with and without. In goes a file, out
//! comes a table.

use super::{BenchArguments, CliError, Subject, answer, pool};
use sunfleck::bench::{SkipsPlan, measure_skips, skips_table};
use sunfleck::render::{Job, Method};
use sunfleck::scene::{Bounces, Sampling, Window};

pub(super) fn run(arguments: &BenchArguments, subject: &Subject) -> Result<(), CliError> {
    let folder = tempfile::tempdir().map_err(|error| {
        CliError::InputOutput(format!(
            "error: no folder for temporary files: {error}\n  remedy: make room, or set TMPDIR to a folder that can be written to"
        ))
    })?;
    let plan = SkipsPlan {
        scene: subject.scene,
        camera: subject.plan.camera,
        shutter: subject.shutter,
        job: Job {
            size: subject.size,
            window: Window::whole(subject.size),
            passes: Vec::new(),
            sampling: Sampling::Exactly(4),
            filter: subject.settings.filter,
            seed: subject.settings.seed,
            mirror_depth: subject.settings.mirror_depth,
            bounces: Bounces::NONE,
            method: Method::Slices,
        },
        rounds: arguments.rounds.unwrap_or(if arguments.quick { 2 } else { 5 }) as usize,
        folder: folder.path(),
    };
    let skips = pool(Some(1))?.install(|| measure_skips(&plan)).map_err(CliError::InputOutput)?;
    answer(skips_table(&skips).trim_end())
}
