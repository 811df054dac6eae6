//! `sunfleck render`: an input becomes frames on the disk. Invariant: the run ends by saying where
//! the frames are, how long they took and what was skipped.

use super::arguments::{PreviewArgument, ProgressArgument, RenderArguments, SkipArgument};
use super::darkness::DarkFrames;
use super::live::Live;
use super::plan::{self, Plan};
use super::progress::{Progress, ProgressStyle};
use super::signals::Stop;
use super::stats::Stats;
use super::{CliError, answer, exposure, tell};
use crate::film::Frame;
use crate::render::{Rendered, Watch};
use crate::sequence::{self, Job, SequenceError, Skip};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

pub(super) fn run(arguments: &RenderArguments, stop: &Stop) -> Result<(), CliError> {
    let threads = arguments.threads.unwrap_or(0) as usize;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| CliError::InputOutput(format!("error: threads cannot be started: {error}")))?;
    let scene = pool.install(|| plan::load(arguments))?;
    let plan = Plan::new(&scene, arguments)?;
    let picture = &plan.picture;
    picture.remarks.told().for_each(|remark| tell(&remark.to_string()));
    if arguments.dry_run {
        return answer(&plan.to_string());
    }
    picture.check_memory()?;
    let live = Live::new(arguments.live.as_deref());
    let stats = Stats::new(arguments.stats.as_deref(), &picture.remarks)?;
    let progress = Progress::new(match arguments.progress {
        ProgressArgument::Auto => ProgressStyle::auto(),
        ProgressArgument::Plain => ProgressStyle::Plain,
        ProgressArgument::Jsonl => ProgressStyle::JsonLines,
        ProgressArgument::Openjd => ProgressStyle::OpenJd,
        ProgressArgument::None => ProgressStyle::None,
    });
    let measured = || Ok::<f64, CliError>(pool.install(|| plan.auto_exposure_stops()));
    let display = arguments.preview.map(|PreviewArgument::Png| {
        exposure::display(&arguments.display, picture.settings.exposure_stops, measured)
    });
    let job = Job {
        frames: &plan.frames,
        output: &plan.output,
        skip: match arguments.skip {
            SkipArgument::Valid => Skip::Valid,
            SkipArgument::Exists => Skip::Exists,
            SkipArgument::None => Skip::None,
        },
        preview: display.transpose()?,
        stop: &stop.flag,
    };
    let dark_frames = DarkFrames::default();
    let mut still_frame: Option<Rendered> = None;
    let rendered = sequence::run(
        job,
        |frame| picture.provenance(frame),
        |frame, progress| -> Result<Option<Rendered>, Stopped> {
            if let Some(same) = &still_frame {
                return Ok(Some(same.clone()));
            }
            let started = Instant::now();
            let is_late = AtomicBool::new(false);
            let rendered = pool.install(|| {
                let exposure = picture.exposure(frame);
                stats.snapshot_took(frame, started.elapsed().as_secs_f64());
                let cancelled = || {
                    let limit = arguments.frame_timeout;
                    is_late.fetch_or(
                        limit.is_some_and(|limit| started.elapsed().as_secs_f64() > limit),
                        Ordering::Relaxed,
                    );
                    is_late.load(Ordering::Relaxed) || stop.flag.load(Ordering::Relaxed)
                };
                let name = plan.output.path(frame).to_string_lossy().into_owned();
                let look = |so_far: &Frame| live.show(&name, so_far);
                let look: Option<&(dyn Fn(&Frame) + Sync)> = if live.is_on() { Some(&look) } else { None };
                let rendered = picture.render(&exposure, &Watch { progress, cancelled: &cancelled, look });
                live.show(&name, &rendered.frame);
                rendered
            });
            if stop.flag.load(Ordering::Relaxed) {
                return Err(Stopped);
            }
            if is_late.into_inner() {
                return Ok(None);
            }
            // Where nothing moves, every frame is this one.
            if picture.scene.resolved().is_still() {
                still_frame = Some(rendered.clone());
            }
            Ok(Some(rendered))
        },
        &|event| {
            progress.report(&event);
            stats.report(&event);
            dark_frames.report(&event);
        },
    );
    let summary = rendered.map_err(CliError::from)?;
    dark_frames.tell_of(&plan);
    if let Some(number) = stop.signal().filter(|_| summary.stopped) {
        return Err(CliError::Signal(number));
    }
    stats.finish()?;
    if !summary.given_up.is_empty() {
        let frames: Vec<String> = summary.given_up.iter().map(ToString::to_string).collect();
        let frames = frames.join(",");
        return Err(CliError::Frame(format!(
            "error: frames {frames} took longer than --frame-timeout and are not written\n  expected: frames within it\n  \
             remedy: `--frames {frames}` with a longer time or a larger --tolerance renders them alone"
        )));
    }
    Ok(())
}

/// A frame was given up because a signal came.
#[derive(Debug, thiserror::Error)]
#[error("stopped by a signal")]
struct Stopped;

impl From<SequenceError<Stopped>> for CliError {
    fn from(error: SequenceError<Stopped>) -> Self {
        match error {
            SequenceError::Defective { .. } => Self::Frame(format!(
                "error: {error}\n  expected: finite light everywhere\n  remedy: report this scene; `--crop` around the pixel shows it"
            )),
            SequenceError::Write { frame, source } => {
                let mut diagnostic = source.diagnostic();
                diagnostic.found = format!("frame {frame}: {}", diagnostic.found);
                Self::InputOutput(diagnostic.to_string())
            }
            SequenceError::Render { .. } => Self::InputOutput(format!("error: {error}")),
        }
    }
}
