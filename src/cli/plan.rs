//! Plan of a run. In go input and flags, out comes a plan. Invariant: flags override the file, and the file
//! overrides defaults; a plan that exists is valid.

use super::arguments::{ProgressArgument, RenderArguments, Volume, passes};
use super::error::usage;
use super::parse::{Crop, SizeArgument};
use super::saving::failure;
use super::{CliError, loading};
use std::borrow::Cow;
use std::fmt;
use std::path::{Path, PathBuf};
use sunfleck::api::{self, Renderer, Scene};
use sunfleck::description::{self, LoadError};
use sunfleck::diagnostic::shown;
use sunfleck::frame_file;
use sunfleck::render::Method;
use sunfleck::scene::{RenderSettings, Size, Window};
use sunfleck::sequence::{FrameList, OutputPattern};
use sunfleck::snapshot::Shutter;
use sunfleck::transport::MarchSteps;

/// Parameters of a run.
pub(super) struct Plan<'scene> {
    pub(super) picture: api::Plan<'scene>,
    pub(super) frames: FrameList,
    pub(super) output: OutputPattern,
}

/// Loads the scene, once frames are known to be writable.
pub(super) fn load(arguments: &RenderArguments) -> Result<Scene, CliError> {
    check_output(arguments)?;
    let description = description::load(&arguments.input)?;
    loading::check_not_read("--stats", &arguments.stats, &description.files)?;
    loading::seen(
        description,
        &arguments.scene,
        arguments.size,
        arguments.camera.as_ref(),
        matches!(arguments.progress, ProgressArgument::Auto),
    )
}

impl<'scene> Plan<'scene> {
    pub(super) fn new(scene: &'scene Scene, arguments: &RenderArguments) -> Result<Self, CliError> {
        let picture = renderer(scene, arguments)?.plan()?;
        arguments.scene.check(&picture.remarks)?;
        let frames = find_frames(arguments.frames.as_deref(), &picture.settings)?;
        let output = parse_output(arguments.out.as_deref(), &picture.settings.name)?;
        output.check(frames.as_slice().len()).map_err(CliError::Usage)?;
        if let Some(last) = frames.as_slice().last().filter(|_| !arguments.dry_run) {
            frame_file::check_name(&output.path(*last)).map_err(failure)?;
        }
        let plan = Self { picture, frames, output };
        loading::check_not_read("--out", plan.written(arguments), scene.files())?;
        match &arguments.stats {
            Some(stats) if plan.written(arguments).any(|path| is_same(&path, stats)) => {
                let found = format!("{} is a frame of this run, and would be lost", shown(stats));
                Err(usage("--stats", found, "a file of another name"))
            }
            _ => Ok(plan),
        }
    }

    /// Time in which its frames see the scene, seconds: their shutters, and for motion a frame more.
    pub(super) fn span_s(&self) -> Option<(f64, f64)> {
        let frames = self.frames.as_slice().iter();
        let spans = frames.map(|&frame| {
            let Shutter { open_s, close_s } = self.picture.shutter(frame);
            let at = |offset: f64| self.picture.settings.frame_rate.seconds(frame as f64 + offset);
            (open_s.min(at(-1.0)), close_s.max(at(1.0)))
        });
        spans.reduce(|all, one| (all.0.min(one.0), all.1.max(one.1)))
    }

    /// Files that the run writes: frames, and pictures beside them.
    fn written(&self, arguments: &RenderArguments) -> impl Iterator<Item = PathBuf> {
        let has_pictures = arguments.preview.is_some();
        self.frames.as_slice().iter().flat_map(move |&frame| {
            let path = self.output.path(frame);
            let picture = has_pictures.then(|| path.with_extension("png"));
            std::iter::once(path).chain(picture)
        })
    }
}

/// Whether two names refer to the same file, which need not exist yet.
fn is_same(one: &Path, other: &Path) -> bool {
    let folder = |path: &Path| {
        let folder = frame_file::folder_of(path);
        folder.canonicalize().unwrap_or_else(|_| folder.to_owned())
    };
    one.file_name() == other.file_name() && folder(one) == folder(other)
}

fn renderer<'a>(scene: &'a Scene, arguments: &RenderArguments) -> Result<Renderer<'a>, CliError> {
    let mut renderer = Renderer::new(scene).method(method(arguments, scene.settings())?);
    if let Some(size) = arguments.size {
        let Size { width, height } = resized(scene.size(), size)?;
        renderer = renderer.size(width, height);
    }
    if let Some(list) = &arguments.passes {
        renderer = renderer.passes(passes(list));
    }
    renderer = renderer.shafts_alone(arguments.only.is_some());
    if let Some(Crop { x0, y0, x1, y1 }) = arguments.crop {
        renderer = renderer.crop(Window { x: x0, y: y0, width: x1 - x0, height: y1 - y0 });
    }
    renderer = arguments.samples.into_iter().fold(renderer, Renderer::samples);
    renderer = arguments.tolerance.into_iter().fold(renderer, Renderer::tolerance);
    renderer = arguments.bounces.into_iter().fold(renderer, Renderer::bounces);
    renderer = arguments.filter.into_iter().fold(renderer, Renderer::filter);
    renderer = arguments.camera.iter().fold(renderer, |renderer, name| renderer.camera(name));
    renderer = arguments.seed.into_iter().fold(renderer, Renderer::seed);
    renderer = arguments.shutter.into_iter().fold(renderer, Renderer::shutter);
    Ok(arguments.shutter_position.into_iter().fold(renderer, Renderer::shutter_position))
}

impl fmt::Display for Plan<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let frames = self.frames.as_slice();
        let job = &self.picture.job;
        let Size { width, height } = job.size;
        writeln!(
            f,
            "{} frame{} of {width}x{height} pixels, {}, --filter {}, --volume {}, {}",
            frames.len(),
            if frames.len() == 1 { "" } else { "s" },
            job.sampling,
            job.filter.name(),
            job.method.name(),
            super::pass_names(&job.passes)
        )?;
        let camera = &self.picture.scene.resolved().cameras[self.picture.camera];
        writeln!(f, "camera `{}`, seed {}", camera.name, job.seed)?;
        if let Some(&first) = frames.first() {
            write!(f, "the first would be {}; ", shown(&self.output.path(first)))?;
        }
        write!(f, "nothing was rendered")
    }
}

/// Checks that the output is writable, before the scene is loaded.
fn check_output(arguments: &RenderArguments) -> Result<(), CliError> {
    let pattern = parse_output(arguments.out.as_deref(), "frame")?;
    if arguments.dry_run {
        return Ok(());
    }
    // The name of the input is not yet known.
    let folder = arguments.out.as_ref().map_or(Path::new("out"), |_| pattern.folder());
    frame_file::check_folder(folder).map_err(failure)
}

fn parse_output(out: Option<&Path>, name: &str) -> Result<OutputPattern, CliError> {
    let Some(out) = out else { return Ok(OutputPattern::default_for(name)) };
    OutputPattern::parse(out, name).map_err(CliError::Usage)
}

pub(super) fn resized(size: Size, argument: SizeArgument) -> Result<Size, CliError> {
    match argument {
        SizeArgument::Pixels(size) => Ok(size),
        SizeArgument::Percent(percent) => {
            let side = |side: usize| (side as f64 * percent / 100.0).round() as usize;
            let size = Size { width: side(size.width), height: side(size.height) };
            if size.width == 0 || size.height == 0 {
                return Err(usage("--size", format!("{percent}% leaves no pixel"), "a larger percentage"));
            }
            Ok(size)
        }
    }
}

pub(super) fn find_frames(list: Option<&str>, settings: &RenderSettings) -> Result<FrameList, CliError> {
    let all = &settings.frames;
    let list = listed(list.unwrap_or("all"))?;
    let frames = FrameList::parse(list.trim(), all.clone()).map_err(CliError::Usage)?;
    if settings.only_these_frames {
        frames.check_within(all).map_err(CliError::Usage)?;
    }
    Ok(frames)
}

/// List of frames, or the contents of the file after `@`.
pub(super) fn listed(list: &str) -> Result<Cow<'_, str>, CliError> {
    let Some(path) = list.strip_prefix('@') else { return Ok(list.into()) };
    let bytes = description::read_regular(path.as_ref()).map_err(|source| LoadError::Io {
        path: path.into(),
        referrer: Some(String::from("--frames")),
        source,
    })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned().into())
}

fn method(arguments: &RenderArguments, settings: &RenderSettings) -> Result<Method, CliError> {
    let stepped = matches!(arguments.volume, Volume::March | Volume::Equiangular);
    if arguments.volume_steps.is_some() && !stepped {
        let found = String::from("the exact methods take no steps");
        return Err(usage("--volume-steps", found, "--volume march or --volume equiangular beside it"));
    }
    Ok(match (arguments.volume, arguments.volume_steps) {
        (Volume::Auto, _) => Method::Auto,
        (Volume::Slices, _) => Method::Slices,
        (Volume::Segments, _) => Method::Segments,
        (Volume::March, Some(steps)) => Method::March(MarchSteps::Count(steps)),
        (Volume::March, None) => Method::March(MarchSteps::Planes {
            depth_m: settings.march_depth_m,
            step_m: settings.march_step_m,
        }),
        (Volume::Paths, _) => Method::Paths,
        (Volume::Equiangular, points) => Method::Equiangular { points: points.unwrap_or(1) },
    })
}
