//! `sunfleck render`: an input becomes frames on the disk. Invariant: the run ends by saying where
//! the frames are, how long they took and what was skipped.

use super::arguments::{PreviewArgument, ProgressArgument, RenderArguments, SkipArgument};
use super::darkness::DarkFrames;
use super::live::Live;
use super::plan::Plan;
use super::progress::{Progress, ProgressStyle};
use super::signals::Stop;
use super::stats::Stats;
use super::{CliError, answer, exposure, tell};
use crate::film::Frame;
use crate::frame_file::Provenance;
use crate::passes::{Needs, any_needs};
use crate::render::{self, Rendered, Watch};
use crate::scene::matte_id;
use crate::sequence::{self, Job, SequenceError, Skip};
use crate::snapshot::{Exposure, MeshTrees, MotionField};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

pub(super) fn run(arguments: &RenderArguments, stop: &Stop) -> Result<(), CliError> {
    let threads = arguments.threads.unwrap_or(0) as usize;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| CliError::InputOutput(format!("error: threads cannot be started: {error}")))?;
    let plan = pool.install(|| Plan::new(arguments))?;
    plan.scene.remarks.told().for_each(|remark| tell(&remark.to_string()));
    if arguments.dry_run {
        return answer(&plan.to_string());
    }
    check_memory(&plan.job)?;
    let live = Live::new(arguments.live.as_deref());
    let stats = Stats::new(arguments.stats.as_deref(), &plan.scene.remarks)?;
    let progress = Progress::new(match arguments.progress {
        ProgressArgument::Auto => ProgressStyle::auto(),
        ProgressArgument::Plain => ProgressStyle::Plain,
        ProgressArgument::Jsonl => ProgressStyle::JsonLines,
        ProgressArgument::Openjd => ProgressStyle::OpenJd,
        ProgressArgument::None => ProgressStyle::None,
    });
    let trees = MeshTrees::new(&plan.scene);
    let measured = || Ok::<f64, CliError>(pool.install(|| plan.auto_exposure_stops(&trees)));
    let display = arguments.preview.map(|PreviewArgument::Png| {
        exposure::display(&arguments.display, plan.settings.exposure_stops, measured)
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
        |frame| provenance(&plan, frame),
        |frame, progress| -> Result<Option<Rendered>, Stopped> {
            if let Some(same) = &still_frame {
                return Ok(Some(same.clone()));
            }
            let started = Instant::now();
            let is_late = AtomicBool::new(false);
            let picture = pool.install(|| {
                let exposure = plan.exposure(&trees, frame);
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
                let picture =
                    render::render(&exposure, &plan.job, &Watch { progress, cancelled: &cancelled, look });
                live.show(&name, &picture.frame);
                picture
            });
            if stop.flag.load(Ordering::Relaxed) {
                return Err(Stopped);
            }
            if is_late.into_inner() {
                return Ok(None);
            }
            // Where nothing moves, every frame is this one.
            if plan.scene.is_still() {
                still_frame = Some(picture.clone());
            }
            Ok(Some(picture))
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

/// Refuses a picture for which there is no memory: an allocation that fails in the middle of it would end the process.
fn check_memory(job: &render::Job) -> Result<(), CliError> {
    let bytes = job.memory_bytes();
    let mut all: Vec<u8> = Vec::new();
    all.try_reserve_exact(bytes).map_err(|_| {
        let (width, height) = (job.window.width, job.window.height);
        CliError::InputOutput(format!(
            "error: {width} x {height} pixels take {:.1} GB, more memory than can be had\n  expected: a picture that fits\n  \
             remedy: make --size or --passes smaller, or render parts with --crop",
            bytes as f64 / 1e9
        ))
    })
}

impl Plan {
    /// What the camera sees at a frame.
    fn exposure(&self, trees: &MeshTrees, frame: i64) -> Exposure<'_> {
        let size = self.job.size;
        let aspect = size.width as f64 / size.height as f64;
        let mut exposure = Exposure::new(&self.scene, trees, self.camera, aspect, self.shutter(frame));
        if any_needs(&self.job.passes, |needs| needs == Needs::Motion) {
            let rate = self.settings.frame_rate;
            let times_s = [-1.0, 0.0, 1.0].map(|offset| rate.seconds(frame as f64 + offset));
            exposure = exposure.with_motion(MotionField::new(&self.scene, self.camera, size, times_s));
        }
        if any_needs(&self.job.passes, |needs| needs == Needs::Names) {
            exposure = exposure.with_mattes(&self.scene);
        }
        exposure
    }

    /// What mattes are called, if the frames have any.
    fn object_names(&self) -> BTreeMap<u32, String> {
        let is_asked = any_needs(&self.job.passes, |needs| needs == Needs::Names);
        let instances = 0..if is_asked { self.scene.instances.len() } else { 0 };
        let names = instances.map(|instance| self.scene.matte_name(instance));
        names.map(|name| (matte_id(name), name.to_owned())).collect()
    }
}

fn provenance(plan: &Plan, frame: i64) -> Provenance {
    let shutter = plan.shutter(frame);
    Provenance {
        frame,
        frame_rate: plan.settings.frame_rate,
        exposure_s: shutter.close_s - shutter.open_s,
        camera_from_world: plan.view(frame).camera_from_world(),
        scene_hash: plan.scene_hash.clone(),
        settings_hash: plan.settings_hash.clone(),
        seed: plan.job.seed,
        sampling: plan.job.sampling,
        owner: None,
        comments: None,
        object_names: plan.object_names(),
    }
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
