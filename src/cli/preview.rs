//! Command `preview`: pictures of a scene by scan line, or of existing frames. In goes an input, out come PNG
//! files. Invariant: every file is whole or absent, and independent of the number of threads.

use super::arguments::PreviewArguments;
use super::bench::{MOST_PIXELS, fitting};
use super::colors::ColorDoubts;
use super::darkness::DarkFrames;
use super::error::usage;
use super::parse::SizeArgument;
use super::plan::{find_frames, resized};
use super::saving::{clear, clear_folder, failure};
use super::threads;
use super::unshown::Unshown;
use super::{CliError, exposure, loading, tell};
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::time::Instant;
use sunfleck::api::{Plan, Renderer, Scene};
use sunfleck::color::Display;
use sunfleck::description;
use sunfleck::diagnostic::shown;
use sunfleck::film::Frame;
use sunfleck::frame_file::{self, Animation, FrameFileError, Picture};
use sunfleck::scene::{FrameRate, RenderSettings, Size};
use sunfleck::sequence::{FrameList, OutputPattern};

/// Maximum number of frames on a contact sheet; they are evenly spread.
const MOST_ON_SHEET: usize = 64;

enum Source<'a> {
    Scene {
        input: &'a Path,
        plan: Box<Plan<'a>>,
    },
    /// Frames to read.
    Files {
        files: BTreeMap<i64, PathBuf>,
        size: Option<SizeArgument>,
        doubts: Doubts,
    },
}

#[derive(Default)]
struct Doubts {
    colors: ColorDoubts,
    pixels: Unshown,
}

/// Files of the pictures.
struct Outputs {
    pictures: Option<OutputPattern>,
    sheet: Option<PathBuf>,
    animation: Option<PathBuf>,
}

pub(super) fn run(arguments: &PreviewArguments) -> Result<(), CliError> {
    let pool = threads::pool(arguments.threads)?;
    let scene = if frame_file::is_of_frames(&arguments.input) {
        None
    } else {
        Some(pool.install(|| load(arguments))?)
    };
    let (source, settings) = match &scene {
        None => Source::files(arguments)?,
        Some(scene) => Source::scene(scene, arguments)?,
    };
    let frames = find_frames(arguments.frames.as_deref(), &settings)?;
    let frames = source.existing(&frames);
    let outputs = Outputs::new(arguments.out.as_deref(), &settings.name, frames.len())?;
    let measured = || pool.install(|| source.auto_exposure_stops(&settings)).map_err(failure);
    let display = exposure::display(&arguments.display, &settings, measured)?;
    let inputs = scene.as_ref().map_or(&[][..], Scene::files);
    loading::check_not_read("--out", outputs.paths(&frames), inputs)?;
    outputs.clear(&frames);
    let dark_frames = DarkFrames::default();
    let started = Instant::now();
    let mut kept = Kept::new(&outputs, frames.len(), settings.frame_rate);
    // One frame a thread, so that none waits for another's file.
    for group in frames.chunks(pool.current_num_threads()) {
        let pictures: Result<Vec<Picture>, FrameFileError> = pool.install(|| {
            let picture = |&frame: &i64| {
                let path = outputs.pictures.as_ref().map(|pattern| pattern.path(frame));
                let picture = source.picture(frame, &display, &dark_frames)?;
                path.map_or(Ok(()), |path| picture.write(&path))?;
                Ok(picture)
            };
            group.par_iter().map(picture).collect()
        });
        for picture in pictures.map_err(failure)? {
            kept.add(&picture)?;
        }
    }
    let size = kept.finish()?;
    let seconds = started.elapsed().as_secs_f64();
    let rate = frames.len() as f64 / seconds;
    let decimals = usize::from(rate < 10.0);
    tell(&format!(
        "{} frame{} of {}x{} in {seconds:.2} s ({rate:.decimals$} a second), written to {outputs}",
        frames.len(),
        if frames.len() == 1 { "" } else { "s" },
        size.width,
        size.height
    ));
    if let Source::Files { doubts, .. } = &source {
        doubts.pixels.tell();
    }
    // Fog is not drawn, so a picture with fog may be black for no fault.
    if let Source::Scene { plan, .. } = &source
        && plan.scene.resolved().fogs.is_empty()
    {
        dark_frames.tell_of(plan);
    }
    Ok(())
}

fn load(arguments: &PreviewArguments) -> Result<Scene, CliError> {
    let description = description::load(&arguments.input)?;
    loading::seen(description, &arguments.scene, arguments.size, arguments.camera.as_ref(), true)
}

impl<'a> Source<'a> {
    fn scene(scene: &'a Scene, arguments: &'a PreviewArguments) -> Result<(Self, RenderSettings), CliError> {
        let whole = scene.size();
        let smaller = || SizeArgument::Percent(fitting(whole, MOST_PIXELS));
        let Size { width, height } = resized(whole, arguments.size.unwrap_or_else(smaller))?;
        if width * height > LARGEST_PICTURE {
            let found = format!("{width}x{height} pixels are too many for a preview");
            return Err(usage("--size", found, &format!("at most {LARGEST_PICTURE} pixels")));
        }
        let plan = Box::new(Renderer::new(scene).size(width, height).plan()?);
        let remarks = &scene.resolved().remarks;
        arguments.scene.check(remarks)?;
        remarks.reported().for_each(|remark| tell(&remark.to_string()));
        let settings = plan.settings.clone();
        Ok((Self::Scene { input: &arguments.input, plan }, settings))
    }

    /// EXR file, or those of a folder, by the number at the end of their names.
    fn files(arguments: &PreviewArguments) -> Result<(Self, RenderSettings), CliError> {
        let input = arguments.input.as_path();
        let flags = [
            ("--camera", arguments.camera.is_some()),
            ("--light-units", arguments.scene.light_units.is_some()),
            ("--default-light", arguments.scene.default_light.is_some()),
            ("--sky-sun", arguments.scene.sky_sun.is_some()),
        ];
        if let Some((flag, _)) = flags.into_iter().find(|(_, given)| *given) {
            return Err(usage(
                flag,
                String::from("frames that are there are shown as they are"),
                "no such flag",
            ));
        }
        let files = frame_file::frames_in(input).map_err(failure)?;
        let (Some(first), Some(last)) = (files.keys().next().copied(), files.keys().last().copied()) else {
            let found = format!("there is no frame in {}", shown(input));
            let below =
                frame_file::folder_below(input).map(|below| format!(": there are some in {}", shown(&below)));
            let expected = format!("a folder of files such as name.0001.exr{}", below.unwrap_or_default());
            return Err(usage("INPUT", found, &expected));
        };
        let own = |path: PathBuf| {
            let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
            Some(name?.to_string_lossy().into_owned())
        };
        let name = input.canonicalize().ok().and_then(own);
        let settings = RenderSettings {
            name: name.unwrap_or_else(|| String::from("frames")),
            frames: first..=last,
            only_these_frames: true,
            frame_rate: arguments.scene.fps.unwrap_or(RenderSettings::default().frame_rate),
            ..RenderSettings::default()
        };
        Ok((Self::Files { files, size: arguments.size, doubts: Doubts::default() }, settings))
    }

    /// Existing frames among the requested ones.
    fn existing(&self, frames: &FrameList) -> Vec<i64> {
        let exists = |frame: &i64| match self {
            Self::Scene { .. } => true,
            Self::Files { files, .. } => files.contains_key(frame),
        };
        frames.as_slice().iter().copied().filter(exists).collect()
    }

    fn path(&self, frame: i64) -> PathBuf {
        match self {
            Self::Scene { input, .. } => input.to_path_buf(),
            Self::Files { files, .. } => files[&frame].clone(),
        }
    }

    /// Automatic exposure of the middle frame of the input's range.
    fn auto_exposure_stops(&self, settings: &RenderSettings) -> Result<f64, FrameFileError> {
        let middle = exposure::reference_frame(&settings.frames);
        let frame = match self {
            Self::Scene { plan, .. } => plan.draw(middle, exposure::small(plan.job.size)),
            Self::Files { files, .. } => {
                let (after, before) = (files.keys().find(|frame| **frame >= middle), files.keys().last());
                self.frame(after.or(before).copied().unwrap_or(middle))?.0
            }
        };
        Ok(frame.auto_exposure_stops())
    }

    fn picture(
        &self,
        frame: i64,
        display: &Display,
        dark_frames: &DarkFrames,
    ) -> Result<Picture, FrameFileError> {
        let encode = |reason| FrameFileError::Encode { path: self.path(frame), reason };
        let (shown, pixel_aspect) = self.frame(frame)?;
        dark_frames.count(frame, shown.darkness());
        let picture = Picture::of(&shown, display).map_err(encode)?;
        self.sized(picture, pixel_aspect).map_err(encode)
    }

    /// Picture of a frame with square pixels at the requested size; scenes are drawn at theirs.
    fn sized(&self, picture: Picture, pixel_aspect: f64) -> Result<Picture, String> {
        let Self::Files { size: wanted, .. } = self else { return Ok(picture) };
        let square = picture.unsqueezed(pixel_aspect);
        let size =
            wanted.map_or(Ok(square), |size| resized(square, size)).map_err(|error| error.to_string())?;
        if size == picture.size {
            return Ok(picture);
        }
        if size.width * size.height > LARGEST_PICTURE {
            return Err(format!("{}x{} pixels are too many for a preview", size.width, size.height));
        }
        Ok(picture.resized(size))
    }

    /// A frame, and the width of its pixels by their height.
    fn frame(&self, frame: i64) -> Result<(Frame, f64), FrameFileError> {
        match self {
            Self::Scene { plan, .. } => Ok((plan.draw(frame, plan.job.size), 1.0)),
            Self::Files { files, doubts, .. } => {
                let file = frame_file::read(&files[&frame])?;
                let has_picture = doubts.colors.tell_shown(&files[&frame], &file);
                let has_pixels = file.frame.window.width > 0;
                let pixel_aspect = file.pixel_aspect;
                let shown = file.shown();
                // Depth may be infinite.
                if has_picture {
                    doubts.pixels.count(&files[&frame], has_pixels, &shown);
                }
                Ok((shown, pixel_aspect))
            }
        }
    }
}

/// Maximum pixels of a preview.
const LARGEST_PICTURE: usize = 1 << 26;

impl Outputs {
    fn new(out: Option<&Path>, name: &str, frames: usize) -> Result<Self, CliError> {
        let Some(out) = out else {
            let folder = Path::new("out").join(format!("{name}.preview"));
            let sheet = Some(folder.join(format!("{name}.sheet.png")));
            let pictures = Some(OutputPattern::in_folder(folder, name, "png", "--out"));
            return Ok(Self { pictures, sheet, animation: None });
        };
        if Animation::is_named(out) {
            return Ok(Self { pictures: None, sheet: None, animation: Some(out.to_owned()) });
        }
        let pictures = OutputPattern::parse_as(out, name, "png", "--out").map_err(|error| {
            CliError::Usage(
                error.remedy("end it in .png, in .apng or .webp for a movie, or in / if it is a folder"),
            )
        })?;
        // A single file for many frames is their contact sheet.
        if pictures.check(frames).is_err() {
            return Ok(Self { pictures: None, sheet: Some(out.to_owned()), animation: None });
        }
        Ok(Self { pictures: Some(pictures), sheet: None, animation: None })
    }

    fn paths(&self, frames: &[i64]) -> impl Iterator<Item = PathBuf> {
        let pictures =
            self.pictures.iter().flat_map(|pattern| frames.iter().map(|&frame| pattern.path(frame)));
        pictures.chain(self.sheet.clone()).chain(self.animation.clone())
    }

    /// Removes temporary files that killed runs left of these.
    fn clear(&self, frames: &[i64]) {
        if let Some(pictures) = &self.pictures {
            let paths: Vec<PathBuf> = frames.iter().map(|&frame| pictures.path(frame)).collect();
            let names: HashSet<&[u8]> = paths
                .iter()
                .filter_map(|path| path.file_name())
                .map(std::ffi::OsStr::as_encoded_bytes)
                .collect();
            clear_folder(pictures.folder(), |name| names.contains(name));
        }
        self.sheet.iter().chain(&self.animation).for_each(|path| clear(path));
    }
}

impl std::fmt::Display for Outputs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (&self.pictures, self.sheet.as_ref().or(self.animation.as_ref())) {
            (Some(pictures), _) if pictures.check(2).is_err() => write!(f, "{}", shown(&pictures.path(0))),
            (Some(pictures), _) => write!(f, "{}", shown(pictures.folder())),
            (None, file) => write!(f, "{}", shown(file.map_or(Path::new(""), PathBuf::as_path))),
        }
    }
}

/// Pictures for one file.
struct Kept<'a> {
    outputs: &'a Outputs,
    frames: usize,
    rate: FrameRate,
    /// Number of pictures so far.
    seen: usize,
    size: Size,
    sheet: Option<Picture>,
    animation: Option<Animation>,
}

impl<'a> Kept<'a> {
    fn new(outputs: &'a Outputs, frames: usize, rate: FrameRate) -> Self {
        let size = Size { width: 0, height: 0 };
        Self { outputs, frames, rate, seen: 0, size, sheet: None, animation: None }
    }

    fn add(&mut self, picture: &Picture) -> Result<(), CliError> {
        let shown = self.frames.min(MOST_ON_SHEET);
        let columns = (shown as f64).sqrt().ceil() as usize;
        if self.seen == 0 {
            self.size = picture.size;
            let Size { width, height } = self.size;
            let sheet =
                || Picture::black(Size { width: columns * width, height: shown.div_ceil(columns) * height });
            self.sheet = self.outputs.sheet.as_ref().map(|_| sheet());
            if let Some(path) = &self.outputs.animation {
                self.animation =
                    Some(Animation::new(path, self.size, self.frames, self.rate).map_err(failure)?);
            }
        }
        let kept = self.sheet.is_some() || self.animation.is_some();
        if kept && picture.size != self.size {
            let (Size { width, height }, other) = (self.size, picture.size);
            let found = format!(
                "a frame of {}x{} pixels is among others of {width}x{height}",
                other.width, other.height
            );
            return Err(usage("--frames", found, "frames of one size, or --out NAME.####.png"));
        }
        // Evenly spread, starting with the first.
        let place = (self.seen * shown).div_ceil(self.frames);
        if place * self.frames / shown == self.seen
            && let Some(sheet) = &mut self.sheet
        {
            sheet.paste(place % columns * self.size.width, place / columns * self.size.height, picture);
        }
        if let Some(animation) = &mut self.animation {
            animation.push(picture).map_err(failure)?;
        }
        self.seen += 1;
        Ok(())
    }

    /// Writes the file; returns the size of its pictures.
    fn finish(self) -> Result<Size, CliError> {
        if let (Some(sheet), Some(path)) = (&self.sheet, &self.outputs.sheet) {
            sheet.write(path).map_err(failure)?;
        }
        self.animation.map_or(Ok(()), Animation::finish).map_err(failure)?;
        Ok(self.size)
    }
}
