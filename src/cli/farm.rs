//! Command `farm`: a job for a render farm's manager. In goes an input, out come the manager's files.
//! Invariant: the tasks' command line was validated with the scene; every file is whole or absent.

mod chunk;
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
use super::parse::ChunkArgument;
use super::plan::{self, Plan};
use super::saving::{failure, save};
use super::{CliError, answer, tell};
use chunk::Farm;
use clap::Parser as _;
use job::{BAKES, FRAMES, Job, Names, ranges};
use std::path::Path;
use std::thread::available_parallelism;
use std::time::Instant;
use sunfleck::description;
use sunfleck::diagnostic::shown;
use sunfleck::frame_file;

/// Name in messages of the flags for tasks.
const FLAGS: &str = "the flags after --";

/// File of the job: its name in the job's folder, and its contents.
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
    // Created even without falls, as managers copy it.
    std::fs::create_dir_all(folder.join(BAKES))
        .map_err(|error| CliError::InputOutput(format!("error: {}: {error}", shown(&folder.join(BAKES)))))?;
    for (name, contents) in &files {
        save(&folder.join(name), &[contents.as_bytes()])?;
    }
    answer(&format!(
        "{}: frames {} in tasks of {}, which read {} files\n{}{how_to_submit}",
        shown(folder),
        ranges(&job.frames, Some('x')),
        job.chunk,
        job.files.len(),
        job.why.as_deref().unwrap_or_default(),
    ))
}

fn new_job(arguments: &FarmArguments) -> Result<Job, CliError> {
    let files = description::load(&arguments.input)?.files;
    let read_bytes: u64 = files.iter().filter_map(|file| file.metadata().ok()).map(|file| file.len()).sum();
    let mut job = Job {
        name: String::new(),
        input: absolute(&arguments.input)?,
        files: files.iter().map(|file| absolute(file)).collect::<Result<_, _>>()?,
        folder: absolute(&arguments.out)?,
        frames: Vec::new(),
        chunk: 1,
        why: None,
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
    plan.picture.remarks.reported().for_each(|remark| tell(&remark.to_string()));
    job.frames = plan.frames.as_slice().to_vec();
    job.frames.sort_unstable();
    if job.frames.is_empty() {
        return Err(usage("--frames", "no frame is to be rendered".into(), "at least one frame"));
    }
    job.name.clone_from(&plan.picture.settings.name);
    job.is_still = scene.resolved().is_still();
    job.threads = task.threads;
    let picture = &plan.picture.job;
    let threads = task.threads.unwrap_or_else(|| usual_threads(arguments.profile));
    let pixels = picture.window.width * picture.window.height;
    let frame_s =
        arguments.frame_seconds.unwrap_or_else(|| job::frame_seconds(pixels, picture.sampling, threads));
    match arguments.chunk {
        ChunkArgument::Frames(frames) => job.chunk = frames,
        ChunkArgument::Auto => {
            // The time of a task to load the scene is measured here, with baked falls.
            let began = Instant::now();
            plan::load(&task)?;
            choose_chunk(&mut job, arguments, frame_s, began.elapsed().as_secs_f64(), read_bytes);
        }
    }
    job.minutes = job::minutes(job.chunk, frame_s);
    job.memory_mib = job::memory_mib(plan.picture.job.memory_bytes() as u64, read_bytes);
    Ok(job)
}

/// Default threads of a task: with Slurm one processor, else a machine like this one.
fn usual_threads(profile: FarmProfile) -> u32 {
    match profile {
        FarmProfile::Slurm => 1,
        _ => available_parallelism().map_or(1, |count| u32::try_from(count.get()).unwrap_or(u32::MAX)),
    }
}

/// Chooses the chunk from the time to load the scene and the bytes of its files.
fn choose_chunk(job: &mut Job, arguments: &FarmArguments, frame_s: f64, load_s: f64, bytes: u64) {
    let machines = job.machines.unwrap_or(shell::MACHINES);
    let begin_s = match arguments.profile {
        FarmProfile::Shell => chunk::PROGRAM_S,
        _ => chunk::MANAGER_S,
    };
    let farm = Farm { machines, start_s: begin_s + load_s, serial_s: chunk::serial_seconds(bytes), frame_s };
    let choice = farm.best_chunk(job.frames.len());
    job.chunk = choice.chunk;
    let estimated = if arguments.frame_seconds.is_some() { "" } else { ", an estimate: see --frame-seconds" };
    job.why = Some(format!(
        "chunk {} gives most frames an hour on {machines} machines: of their time {:.1} % starts tasks and \
         {:.1} % waits; a frame takes {frame_s:.3} s{estimated}\n",
        choice.chunk,
        100.0 * choice.starting,
        100.0 * choice.waiting,
    ));
}

/// Arguments of the tasks for all frames, with falls baked where the farm finds them. Flags that the job
/// itself sets are refused as duplicates.
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

/// Refuses flags that a farm's machine cannot honour, or with which tasks would disturb each other.
fn check_flags(arguments: &FarmArguments, task: &RenderArguments) -> Result<(), CliError> {
    let (is_shell, is_auto) =
        (arguments.profile == FarmProfile::Shell, arguments.chunk == ChunkArgument::Auto);
    match arguments.machines {
        Some(_) if !is_shell && !is_auto => {
            return Err(usage(
                "--machines",
                "a manager knows its machines itself".into(),
                "--machines beside --profile shell or --chunk auto alone",
            ));
        }
        Some(count) if is_shell && count > shell::MOST_MACHINES => {
            let found = format!("{count} scripts are more than anybody starts by hand");
            return Err(usage("--machines", found, "1 to 1000 for --profile shell"));
        }
        None if is_auto && !is_shell => {
            let expected = "--machines N beside --chunk auto: about how many share the work";
            return Err(usage("--machines", "nobody said how many there are".into(), expected));
        }
        _ => {}
    }
    if arguments.frame_seconds.is_some() && !is_auto && arguments.profile != FarmProfile::Slurm {
        return Err(usage(
            "--frame-seconds",
            "the chunk is given".into(),
            "--frame-seconds beside --chunk auto, or --profile slurm, whose tasks have a limit of time",
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

/// Absolute path of a file as text, which managers' files require.
fn absolute(path: &Path) -> Result<String, CliError> {
    let absolute = std::path::absolute(path)
        .map_err(|error| CliError::InputOutput(format!("error: {}: {error}", shown(path))))?;
    match absolute.to_str() {
        Some(text) => Ok(text.trim_end_matches(std::path::is_separator).to_owned()),
        None => Err(usage("--out", format!("{} is no text", shown(path)), "paths that are Unicode text")),
    }
}
