//! `sunfleck farm`: an input becomes a job for the manager of a render farm. In goes a file, out come the
//! files that the manager takes. Invariant: the command line that tasks have has been checked, with the
//! scene; a file is whole or not there.

mod deadline;
mod flamenco;
mod job;
mod openjd;
mod quoting;
mod scripts;
mod shell;
mod slurm;

use super::arguments::{Arguments, Command, FarmArguments, FarmProfile, RenderArguments};
use super::error::usage;
use super::plan::{self, Plan};
use super::saving::{failure, save};
use super::{CliError, answer, tell};
use crate::description;
use crate::diagnostic::shown;
use crate::frame_file;
use clap::Parser as _;
use job::{BAKES, FRAMES, Job, Names, ranges};
use std::path::Path;

/// What messages call the flags for every task.
const FLAGS: &str = "the flags after --";

/// A file of the job: its name in the job's folder, and what is in it.
type JobFile = (String, String);

pub(super) fn run(arguments: &FarmArguments) -> Result<(), CliError> {
    let folder = arguments.out.as_path();
    frame_file::check_folder(folder).map_err(failure)?;
    let job = new_job(arguments)?;
    let (files, how_to_submit) = match arguments.profile {
        FarmProfile::Openjd => (openjd::files(&job)?, openjd::how_to_submit(&job)),
        FarmProfile::Flamenco => (flamenco::files(&job)?, flamenco::how_to_submit(&job)),
        FarmProfile::Deadline => (deadline::files(&job)?, deadline::how_to_submit(&job)),
        FarmProfile::Slurm => (slurm::files(&job)?, slurm::how_to_submit(&job)),
        FarmProfile::Shell => (shell::files(&job)?, shell::how_to_submit(&job)),
    };
    // There even if nothing falls: managers bring it along.
    std::fs::create_dir_all(folder.join(BAKES))
        .map_err(|error| CliError::InputOutput(format!("error: {}: {error}", shown(&folder.join(BAKES)))))?;
    for (name, contents) in &files {
        save(&folder.join(name), &[contents.as_bytes()])?;
    }
    answer(&format!(
        "{}: frames {} in tasks of {}, which read {} files\n{how_to_submit}",
        shown(folder),
        ranges(&job.frames, Some('x')),
        job.chunk,
        job.files.len(),
    ))
}

fn new_job(arguments: &FarmArguments) -> Result<Job, CliError> {
    let files = description::load(&arguments.input)?.files;
    let read_bytes = files.iter().filter_map(|file| file.metadata().ok()).map(|file| file.len()).sum();
    let mut job = Job {
        name: String::new(),
        input: absolute(&arguments.input)?,
        files: files.iter().map(|file| absolute(file)).collect::<Result<_, _>>()?,
        folder: absolute(&arguments.out)?,
        frames: Vec::new(),
        chunk: arguments.chunk,
        flags: arguments.flags.clone(),
        is_still: false,
        memory_mib: 0,
        threads: None,
        minutes: 0,
        machines: arguments.machines,
    };
    let task = first_task(&job, arguments.frames.as_deref().unwrap_or("all"))?;
    check_flags(arguments, &task)?;
    let scene = plan::load(&task)?;
    let plan = Plan::new(&scene, &task)?;
    plan.picture.remarks.told().for_each(|remark| tell(&remark.to_string()));
    job.frames = plan.frames.as_slice().to_vec();
    job.frames.sort_unstable();
    if job.frames.is_empty() {
        return Err(usage("--frames", "no frame is to be rendered".into(), "at least one frame"));
    }
    job.name.clone_from(&plan.picture.settings.name);
    job.is_still = scene.resolved().is_still();
    job.threads = task.threads;
    let picture = &plan.picture.job;
    let pixels = picture.window.width * picture.window.height;
    job.minutes = job::minutes(job.chunk, pixels, picture.sampling, task.threads.unwrap_or(1));
    job.memory_mib = job::memory_mib(plan.picture.job.memory_bytes() as u64, read_bytes);
    Ok(job)
}

/// The command line of the tasks, for all frames at once; falls are baked where machines of the farm find
/// them. Flags that the job itself says are refused, as they stand there twice.
fn first_task(job: &Job, frames: &str) -> Result<RenderArguments, CliError> {
    let names = Names {
        input: &job.input,
        frames,
        chunk: frames,
        output: &format!("{}/{FRAMES}", job.folder),
        bakes: &format!("{}/{BAKES}", job.folder),
        progress: "auto",
    };
    let [render, ..] = job.steps(&names);
    let mut line = render.arguments;
    line.insert(0, String::from("sunfleck"));
    line.insert(2, String::from("--dry-run"));
    match Arguments::try_parse_from(line) {
        Ok(Arguments { command: Command::Render(task) }) => Ok(task),
        Ok(_) => Err(usage(FLAGS, "another command than render".into(), "flags of `sunfleck render`")),
        Err(error) => {
            let error = error.to_string();
            let found = error.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
            Err(usage(FLAGS, found, "flags of `sunfleck render` that the job does not say itself"))
        }
    }
}

/// Refuses what a machine of a farm cannot do, or what tasks would take from one another.
fn check_flags(arguments: &FarmArguments, task: &RenderArguments) -> Result<(), CliError> {
    if arguments.machines.is_some() && arguments.profile != FarmProfile::Shell {
        return Err(usage(
            "--machines",
            "a manager knows its machines itself".into(),
            "--machines beside --profile shell alone",
        ));
    }
    if let Some(viewer) = &task.live {
        return Err(usage(
            FLAGS,
            format!("`--live {viewer}` shows frames here, where nothing is rendered"),
            "flags that serve on any machine; `sunfleck render --live` shows frames of this one",
        ));
    }
    if let Some(stats) = &task.stats {
        return Err(usage(
            FLAGS,
            format!("`--stats {}` is one file, which every task would write anew", shown(stats)),
            "no `--stats`: the lines of a task say what each of its frames took",
        ));
    }
    Ok(())
}

/// Where a file lies, as text: managers' files have no other names.
fn absolute(path: &Path) -> Result<String, CliError> {
    let absolute = std::path::absolute(path)
        .map_err(|error| CliError::InputOutput(format!("error: {}: {error}", shown(path))))?;
    match absolute.to_str() {
        Some(text) => Ok(text.trim_end_matches(std::path::is_separator).to_owned()),
        None => Err(usage("--out", format!("{} is no text", shown(path)), "paths that are Unicode text")),
    }
}
