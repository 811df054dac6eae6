//! Command `render`: frames of an input. In goes an input, out come files. Invariant: at its end the run
//! reports the frames' folder, its duration and the skipped frames.

use super::arguments::{PreviewArgument, ProgressArgument, RenderArguments};
use super::darkness::DarkFrames;
use super::doubts::{Doubt, Doubts};
use super::live::Live;
use super::plan::{self, Plan};
use super::progress::{self, Progress};
use super::signals::Stop;
use super::stats::Stats;
use super::threads;
use super::workers::Workers;
use super::{CliError, answer, exposure, tell};
use rayon::ThreadPool;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use sunfleck::api::Scene;
use sunfleck::color::Display;
use sunfleck::film::Frame;
use sunfleck::render::{self, Rendered, Stage, Watch};
use sunfleck::sequence::{self, Job, SequenceError};

/// Common data of all frames of a run.
struct Run<'a> {
    arguments: &'a RenderArguments,
    stop: &'a Stop,
    workers: Workers<'a>,
    plan: &'a Plan<'a>,
    live: Live,
    stats: Stats,
}

pub(super) fn run(arguments: &RenderArguments, stop: &Stop) -> Result<(), CliError> {
    let result = render(arguments, stop);
    if let (Err(error), ProgressArgument::Openjd) = (&result, arguments.progress) {
        progress::fail(&error.to_string());
    }
    result
}

fn render(arguments: &RenderArguments, stop: &Stop) -> Result<(), CliError> {
    let pool = threads::pool(arguments.threads)?;
    let mut scene = pool.install(|| plan::load(arguments))?;
    // Most keys of a fall are of other times.
    if let Some(span_s) = Plan::new(&scene, arguments)?.span_s() {
        scene.keep_span(span_s);
    }
    of_scene(arguments, &scene, &pool, stop)
}

/// Renders a loaded scene with the available threads.
pub(super) fn of_scene(
    arguments: &RenderArguments,
    scene: &Scene,
    pool: &ThreadPool,
    stop: &Stop,
) -> Result<(), CliError> {
    let plan = Plan::new(scene, arguments)?;
    let remarks = &plan.picture.remarks;
    remarks.reported().for_each(|remark| tell(&remark.to_string()));
    if arguments.dry_run {
        return answer(&plan.to_string());
    }
    plan.picture.check_memory()?;
    let live = Live::new(arguments.live.as_deref())?;
    let stats = Stats::new(arguments.stats.as_deref(), remarks)?;
    // One frame at a time, with all threads, if frames have a timeout or are shown live.
    let one = arguments.frame_timeout.is_some() || live.is_on() || scene.resolved().is_still();
    let asked = arguments.frames_at_once.map(|asked| asked as usize).or(one.then_some(1));
    let workers = Workers::new(pool, asked);
    Run { arguments, stop, workers, plan: &plan, live, stats }.sequence()
}

impl Run<'_> {
    fn sequence(self) -> Result<(), CliError> {
        let Self { arguments, stop, plan, .. } = self;
        let progress = Progress::new(arguments.progress);
        let job = Job {
            frames: &plan.frames,
            output: &plan.output,
            skip: arguments.skip,
            preview: self.preview()?,
            stop: &stop.flag,
            workers: &|left| self.workers.start(left),
        };
        let (dark_frames, doubts) = (DarkFrames::default(), Doubts::default());
        // In a still scene every frame is the first one.
        let is_still = plan.picture.scene.resolved().is_still();
        let still_frame = OnceLock::new();
        let summary = sequence::run(
            job,
            |frame| plan.picture.provenance(frame),
            |worker, frame, progress| {
                if let Some(same) = still_frame.get() {
                    return Ok(Some(Rendered::clone(same)));
                }
                let rendered = self.frame(self.workers.pool(worker), frame, progress)?;
                if let Some(rendered) = &rendered {
                    self.weigh(frame, rendered, &doubts)?;
                    if is_still {
                        still_frame.get_or_init(|| rendered.clone());
                    }
                }
                Ok(rendered)
            },
            &|event| {
                progress.report(&event);
                self.stats.report(&event);
                dark_frames.report(&event);
            },
        )?;
        dark_frames.tell_of(&plan.picture);
        doubts.tell();
        if let Some(number) = stop.signal().filter(|_| summary.stopped) {
            return Err(CliError::Interrupted(number));
        }
        self.stats.finish()?;
        if summary.given_up.is_empty() { Ok(()) } else { Err(too_late(&summary.given_up)) }
    }

    /// Refuses a frame with too uncertain indirect light, or counts it.
    fn weigh(&self, frame: i64, rendered: &Rendered, doubts: &Doubts) -> Result<(), Halt> {
        let sampling = self.plan.picture.settings.sampling;
        match Doubt::of(frame, &rendered.statistics, sampling) {
            Some(doubt) if self.arguments.scene.strict => Err(Halt::Doubt(doubt)),
            Some(doubt) => {
                doubts.count(doubt);
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Display of pictures beside the frames, if they are requested.
    fn preview(&self) -> Result<Option<Display>, CliError> {
        let Self { arguments, plan, stop, workers, .. } = self;
        let measured = || {
            let started = Instant::now();
            let cancelled = || stop.flag.load(Ordering::Relaxed);
            let watch = Watch { cancelled: &cancelled, ..Watch::NOBODY };
            let stops = workers.pool(0).install(|| plan.auto_exposure_stops(&watch));
            let first = plan.frames.as_slice().first().copied().unwrap_or_default();
            self.stats.took(first, "exposure_seconds", started.elapsed());
            // An unfinished picture has no exposure.
            stop.signal().map_or(Ok(stops), |number| Err(CliError::Interrupted(number)))
        };
        let display =
            |PreviewArgument::Png| exposure::display(&arguments.display, &plan.picture.settings, measured);
        if arguments.preview.is_none() && arguments.display.is_asked_for() {
            tell("note: flags of pictures for eyes change no EXR\n  remedy: add --preview png");
        }
        arguments.preview.map(display).transpose()
    }

    /// Renders a frame; `None` if it exceeds the time limit.
    fn frame(
        &self,
        pool: &ThreadPool,
        frame: i64,
        progress: &(dyn Fn(render::Progress) + Sync),
    ) -> Result<Option<Rendered>, Halt> {
        let Self { arguments, stop, plan, live, .. } = self;
        let started = Instant::now();
        let is_late = AtomicBool::new(false);
        let cancelled = || {
            let limit = arguments.frame_timeout;
            is_late.fetch_or(
                limit.is_some_and(|limit| started.elapsed().as_secs_f64() > limit),
                Ordering::Relaxed,
            );
            is_late.load(Ordering::Relaxed) || stop.flag.load(Ordering::Relaxed)
        };
        let name = plan.output.path(frame).to_string_lossy().into_owned();
        let look = |so_far: &dyn Fn() -> Frame| live.look(&name, so_far);
        let look: Option<&render::Look> = if live.is_on() { Some(&look) } else { None };
        let rendered = pool.install(|| {
            let exposure = plan.picture.exposure(frame);
            if live.is_on() {
                let watch = Watch { cancelled: &cancelled, ..Watch::NOBODY };
                live.show(&name, plan.picture.rough(&exposure, &watch));
            }
            let stage = |stage, took| {
                let key = match stage {
                    Stage::IndirectLight => "indirect_seconds",
                    Stage::Walks => "walks_seconds",
                };
                self.stats.took(frame, key, took);
            };
            let watch = Watch { progress, cancelled: &cancelled, look, stage: &stage };
            let rendered = plan.picture.render(&exposure, &watch);
            self.stats.took(frame, "snapshot_seconds", exposure.took());
            if live.is_on() {
                live.show(&name, rendered.frame.colors());
            }
            rendered
        });
        if stop.flag.load(Ordering::Relaxed) {
            return Err(Halt::Signal);
        }
        Ok(if is_late.into_inner() { None } else { Some(rendered) })
    }
}

/// Error about frames that exceeded the time limit.
fn too_late(frames: &[i64]) -> CliError {
    let frames: Vec<String> = frames.iter().map(ToString::to_string).collect();
    let frames = frames.join(",");
    CliError::Frame(format!(
        "error: not written, for it took longer than --frame-timeout: {frames}\n  expected: every frame within it\n  \
         remedy: `--frames {frames}` with a longer time or a larger --tolerance renders them alone"
    ))
}

/// Reason for giving a frame up and ending the run.
#[derive(Debug, thiserror::Error)]
enum Halt {
    #[error("stopped by a signal")]
    Signal,
    #[error("indirect light is too uncertain")]
    Doubt(Doubt),
}

impl From<SequenceError<Halt>> for CliError {
    fn from(error: SequenceError<Halt>) -> Self {
        match error {
            SequenceError::Defective { .. } => Self::Frame(format!(
                "error: {error}\n  expected: finite light everywhere\n  remedy: report this scene; `--crop` around the pixel shows it"
            )),
            SequenceError::Write { frame, source } => {
                let mut diagnostic = source.diagnostic();
                diagnostic.found = format!("frame {frame}: {}", diagnostic.found);
                Self::InputOutput(diagnostic.to_string())
            }
            SequenceError::Render { source: Halt::Doubt(doubt), .. } => Self::Frame(doubt.refusal()),
            SequenceError::Render { source: Halt::Signal, .. } => {
                Self::InputOutput(format!("error: {error}"))
            }
        }
    }
}
