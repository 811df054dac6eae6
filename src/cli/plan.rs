//! What is to be rendered, once and for all: input and flags in, a plan out. Invariant: flags win
//! over the file, the file over the defaults; a plan that exists can be carried out.

use super::arguments::{ProgressArgument, RenderArguments, Volume, passes};
use super::error::usage;
use super::parse::{Crop, SizeArgument};
use super::{CliError, loading};
use crate::description;
use crate::diagnostic::shown;
use crate::frame_file;
use crate::render::{Job, Method};
use crate::scene::{RenderSettings, Sampling, Scene, Size, Window};
use crate::sequence::{FrameList, OutputPattern};
use crate::snapshot::{Exposure, Shutter, View};
use crate::transport::MarchSteps;
use sha2::{Digest, Sha256};
use std::fmt;
use std::path::Path;

/// 16384 x 8192.
const MOST_PIXELS: usize = 1 << 27;

/// Everything that a run needs to know.
pub(super) struct Plan {
    pub(super) scene: Scene,
    pub(super) settings: RenderSettings,
    /// Index into the scene's cameras.
    pub(super) camera: usize,
    pub(super) frames: FrameList,
    pub(super) output: OutputPattern,
    pub(super) job: Job,
    /// SHA-256 over all input files.
    pub(super) scene_hash: String,
    /// SHA-256 over everything else that reaches the pixels, the frame's number aside.
    pub(super) settings_hash: String,
}

impl Plan {
    pub(super) fn new(arguments: &RenderArguments) -> Result<Self, CliError> {
        check_output(arguments)?;
        let description = description::load(&arguments.input)?;
        let scene_hash = description.content_hash.clone();
        if let Some(stats) = &arguments.stats {
            loading::check_not_read("--stats", stats, &description.files)?;
        }
        let (mut scene, mut settings) = loading::resolve(
            description,
            &arguments.options(),
            &arguments.scene.bakes,
            matches!(arguments.progress, ProgressArgument::Auto),
        )?;

        if let Some(size) = arguments.size {
            settings.size = resized(settings.size, size)?;
        }
        if let Some(frame_rate) = arguments.fps {
            settings.frame_rate = frame_rate;
        }
        if let Some(list) = &arguments.passes {
            settings.passes = passes(list);
        }
        settings.sampling =
            Sampling::said(arguments.samples, arguments.tolerance).unwrap_or(settings.sampling);
        settings.filter = arguments.filter.map_or(settings.filter, Into::into);
        settings.seed = arguments.seed.unwrap_or(settings.seed);
        settings.shutter = arguments.shutter.unwrap_or(settings.shutter);
        settings.shutter_position = arguments.shutter_position.unwrap_or(settings.shutter_position);
        scene.remarks.0.extend(Exposure::remark(&scene, settings.shutter));
        arguments.scene.check(&scene.remarks)?;
        settings.camera = arguments.camera.clone().or(settings.camera);

        let camera = find_camera(&scene, settings.camera.as_deref())?;
        let frames = find_frames(arguments.frames.as_deref(), &settings)?;
        let window = find_window(arguments.crop, settings.size)?;
        let method = method(arguments, &settings)?;
        let job = Job {
            size: settings.size,
            window,
            passes: settings.passes.clone(),
            sampling: settings.sampling,
            filter: settings.filter,
            seed: settings.seed,
            mirror_depth: settings.mirror_depth,
            method,
        };
        let output = find_output(arguments.out.as_deref(), &settings.name, &frames)?;
        // Named where it counts, so that the others' hash stays what it was.
        let shutter_position = match settings.shutter * settings.shutter_position {
            0.0 => String::new(),
            _ => format!(" {:?}", settings.shutter_position),
        };
        let default_light =
            arguments.scene.default_light.map_or(String::new(), |light| format!(" {light:?}"));
        let animation = match &arguments.scene.animation {
            None => String::new(),
            Some(animation) => format!(" animation {animation:?}"),
        };
        let settings_hash = hash(&format!(
            "{} {:?} {:?} {camera} {:?}{shutter_position}{default_light}{animation}",
            job.hashed(),
            settings.frame_rate,
            settings.shutter,
            arguments.scene.light_units
        ));
        Ok(Self { scene, settings, camera, frames, output, job, scene_hash, settings_hash })
    }

    /// When the shutter is open for a frame.
    pub(super) fn shutter(&self, frame: i64) -> Shutter {
        Shutter::of(&self.settings, frame as f64)
    }

    /// The camera at a frame.
    pub(super) fn view(&self, frame: i64) -> View {
        let time_s = self.shutter(frame).middle_s();
        let camera = &self.scene.cameras[self.camera];
        let world_from_camera = self.scene.placements(time_s)[camera.node].world_from_node;
        let size = self.job.size;
        View::new(camera, world_from_camera, size.width as f64 / size.height as f64, time_s)
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let frames = self.frames.as_slice();
        let Size { width, height } = self.job.size;
        writeln!(
            f,
            "{} frame{} of {width}x{height} pixels, {}, --filter {}, --volume {}, {}",
            frames.len(),
            if frames.len() == 1 { "" } else { "s" },
            self.job.sampling,
            self.job.filter.name(),
            self.job.method.name(),
            super::pass_names(&self.job.passes)
        )?;
        writeln!(f, "camera `{}`, seed {}", self.scene.cameras[self.camera].name, self.job.seed)?;
        if let Some(&first) = frames.first() {
            write!(f, "the first would be {}; ", shown(&self.output.path(first)))?;
        }
        write!(f, "nothing was rendered")
    }
}

fn hash(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Refuses a place that cannot be written to before anybody waits for the scene.
fn check_output(arguments: &RenderArguments) -> Result<(), CliError> {
    let pattern = parse_output(arguments.out.as_deref(), "frame")?;
    if arguments.dry_run {
        return Ok(());
    }
    frame_file::check_folder(pattern.folder())
        .map_err(|error| CliError::InputOutput(error.diagnostic().to_string()))
}

fn parse_output(out: Option<&Path>, name: &str) -> Result<OutputPattern, CliError> {
    let Some(out) = out else { return Ok(OutputPattern::default_for(name)) };
    OutputPattern::parse(out, name).map_err(CliError::Usage)
}

fn find_output(out: Option<&Path>, name: &str, frames: &FrameList) -> Result<OutputPattern, CliError> {
    let pattern = parse_output(out, name)?;
    pattern.check(frames.as_slice().len()).map_err(CliError::Usage)?;
    Ok(pattern)
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

pub(super) fn find_camera(scene: &Scene, name: Option<&str>) -> Result<usize, CliError> {
    let Some(name) = name else { return Ok(0) };
    scene.cameras.iter().position(|camera| camera.name == name).ok_or_else(|| {
        let names: Vec<_> = scene.cameras.iter().map(|camera| format!("`{}`", camera.name)).collect();
        usage("--camera", format!("there is no camera `{name}`"), &format!("one of {}", names.join(", ")))
    })
}

pub(super) fn find_frames(list: Option<&str>, settings: &RenderSettings) -> Result<FrameList, CliError> {
    let all = &settings.frames;
    let frames = FrameList::parse(list.unwrap_or("all"), all.clone()).map_err(CliError::Usage)?;
    if settings.only_these_frames {
        frames.check_within(all).map_err(CliError::Usage)?;
    }
    Ok(frames)
}

/// The window, unless its film would not fit into the memory of common machines.
fn find_window(crop: Option<Crop>, size: Size) -> Result<Window, CliError> {
    let window = cropped(crop, size)?;
    if window.width * window.height > MOST_PIXELS {
        let found = format!("{} x {} pixels are too many at once", window.width, window.height);
        return Err(usage("--size", found, &format!("at most {MOST_PIXELS} pixels; --crop renders a part")));
    }
    Ok(window)
}

fn cropped(crop: Option<Crop>, size: Size) -> Result<Window, CliError> {
    let Some(Crop { x0, y0, x1, y1 }) = crop else { return Ok(Window::whole(size)) };
    if x1 > size.width || y1 > size.height {
        let Size { width, height } = size;
        let found = format!("{x0},{y0},{x1},{y1} reaches beyond the picture");
        return Err(usage("--crop", found, &format!("x1 up to {width} and y1 up to {height}")));
    }
    Ok(Window { x: x0, y: y0, width: x1 - x0, height: y1 - y0 })
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
        (Volume::Equiangular, points) => Method::Equiangular { points: points.unwrap_or(1) },
    })
}
