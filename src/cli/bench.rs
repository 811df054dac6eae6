//! Command `bench`: error against run time. In go a file and efforts, out come a table, CSV and a plot.
//! Invariant: loading and building are reported, but not counted for any method.

use super::arguments::BenchArguments;
use super::error::usage;
use super::parse::SizeArgument;
use super::plan::resized;
use super::saving::{clear, failure};
use super::threads::pool;
use super::{CliError, answer, loading, tell};
use clap::ValueEnum;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;
use sunfleck::api::{self, Plan, Renderer};
use sunfleck::bench::{self, Method, Reference, Stage, Study, StudyPlan, brute_force};
use sunfleck::description::{self, PeerRow};
use sunfleck::diagnostic::{Diagnostic, Place, shown};
use sunfleck::frame_file::{self, FrameFile};
use sunfleck::scene::{self, Bounces, PixelFilter, RenderSettings, Scene, Size};
use sunfleck::snapshot::Shutter;

/// Maximum pixels of a picture without `--size`: 480 x 270.
pub(super) const MOST_PIXELS: f64 = 480.0 * 270.0;
const QUICK_PIXELS: f64 = 240.0 * 135.0;

struct Subject<'a> {
    plan: Plan<'a>,
    scene: &'a Scene,
    settings: RenderSettings,
    size: Size,
    frame: i64,
    shutter: Shutter,
    load_s: f64,
}

/// Loads the scene, and refuses outputs that would overwrite its files.
fn load(arguments: &BenchArguments) -> Result<api::Scene, CliError> {
    let description = description::load(&arguments.input)?;
    for (flag, output) in [("--csv", &arguments.csv), ("--svg", &arguments.svg)] {
        loading::check_not_read(flag, output, &description.files)?;
    }
    loading::seen(description, &arguments.scene, arguments.size, arguments.camera.as_ref(), true)
}

impl<'a> Subject<'a> {
    fn new(scene: &'a api::Scene, arguments: &BenchArguments, load_s: f64) -> Result<Self, CliError> {
        arguments.scene.check(&scene.resolved().remarks)?;
        let most = if arguments.quick { QUICK_PIXELS } else { MOST_PIXELS };
        let size = arguments.size.unwrap_or_else(|| SizeArgument::Percent(fitting(scene.size(), most)));
        let size = resized(scene.size(), size)?;
        let renderer = Renderer::new(scene).size(size.width, size.height);
        let plan = arguments.bounces.into_iter().fold(renderer, Renderer::bounces).plan()?;
        let settings = plan.settings.clone();
        let frame = arguments.frame.unwrap_or(*settings.frames.start());
        if settings.only_these_frames && !settings.frames.contains(&frame) {
            let (first, last) = (settings.frames.start(), settings.frames.end());
            return Err(usage(
                "--frame",
                format!("there is no frame {frame}"),
                &format!("{first} to {last}"),
            ));
        }
        let shutter = Shutter::instant(settings.frame_rate.seconds(frame as f64));
        Ok(Self { plan, scene: scene.resolved(), settings, size, frame, shutter, load_s })
    }
}

/// Percentage of a size that has at most `most` pixels.
pub(super) fn fitting(size: Size, most: f64) -> f64 {
    let pixels = size.width as f64 * size.height as f64;
    100.0 * (most / pixels).sqrt().min(1.0)
}

pub(super) fn run(arguments: &BenchArguments) -> Result<(), CliError> {
    let started = Instant::now();
    let scene = pool(arguments.threads)?.install(|| load(arguments))?;
    let subject = Subject::new(&scene, arguments, started.elapsed().as_secs_f64())?;
    if subject.settings.filter != PixelFilter::Box {
        tell(&format!("pixels are boxes here, not filtered by `{}`", subject.settings.filter.name()));
    }
    study(arguments, &subject)
}

/// Measures every method at several efforts.
fn study(arguments: &BenchArguments, subject: &Subject) -> Result<(), CliError> {
    let peers = arguments.peers.as_deref().map(description::load_peers).transpose()?.unwrap_or_default();
    let known =
        arguments.reference.as_deref().map(|path| read_reference(path, arguments, subject)).transpose()?;
    let methods = methods(arguments, subject.settings.bounces)?;
    for path in
        [output(arguments.csv.as_deref(), subject, "csv"), output(arguments.svg.as_deref(), subject, "svg")]
    {
        // Checked before minutes of measuring.
        std::fs::create_dir_all(frame_file::folder_of(&path)).map_err(|error| cannot_write(&path, error))?;
    }
    let many = pool(arguments.threads)?;
    let one = pool(Some(1))?;

    let started = Instant::now();
    let exposure = subject.plan.exposure_of(subject.shutter);
    let snapshot = exposure.middle();
    let build_s = started.elapsed().as_secs_f64();
    let stage = Stage {
        exposure: &exposure,
        size: subject.size,
        mirror_depth: subject.settings.mirror_depth,
        bounces: subject.settings.bounces,
        planes: (bench::depth_m(snapshot), subject.settings.march_step_m),
    };
    let triangles = brute_force::triangles(subject.scene, snapshot.view.eye, subject.shutter.middle_s());
    tell(&format!(
        "{} triangles; loaded in {:.3} s, trees built in {build_s:.3} s (in no row below)",
        triangles.len(),
        subject.load_s
    ));
    let quick = arguments.quick;
    let reference = many.install(|| {
        let mut reference = known.unwrap_or_else(|| rendered_reference(arguments, &stage));
        reference.check(&stage, &triangles);
        reference
    });
    let plan = StudyPlan {
        stage,
        triangles: &triangles,
        methods,
        rounds: arguments.rounds.unwrap_or(if quick { 2 } else { 3 }) as usize,
        longest_s: arguments.longest.unwrap_or(if quick { 0.5 } else { 8.0 }),
        most_samples: arguments.most_samples.unwrap_or(u32::MAX),
        seed: subject.settings.seed,
    };
    let points = one.install(|| bench::run(&plan, &reference, &tell));
    let mean = reference.mean();
    let Size { width, height } = subject.size;
    let study = Study {
        title: format!("{}, {width} x {height} pixels, one thread", subject.settings.name),
        reference_note: reference.to_string(),
        points,
        peers: peers.into_iter().map(|row| PeerRow { rmse: row.rmse / mean, ..row }).collect(),
    };
    answer(bench::table(&study).trim_end())?;
    write(&output(arguments.csv.as_deref(), subject, "csv"), &bench::csv(&study))?;
    write(&output(arguments.svg.as_deref(), subject, "svg"), &bench::plot(&study).to_svg())
}

/// Requested methods, or all that support the number of bounces.
fn methods(arguments: &BenchArguments, bounces: Bounces) -> Result<Vec<Method>, CliError> {
    let all = Method::value_variants().iter().copied();
    let Some(asked) = &arguments.methods else {
        return Ok(all.filter(|method| method.makes(bounces)).collect());
    };
    match asked.iter().find(|method| !method.makes(bounces)) {
        Some(method) => {
            let found = format!("`{}` makes no picture with --bounces {bounces}", method.name());
            Err(usage("--methods", found, "others, or `literal` with --bounces 0, `paths` with more"))
        }
        None => Ok(all.filter(|method| asked.contains(method)).collect()),
    }
}

fn rendered_reference(arguments: &BenchArguments, stage: &Stage) -> Reference {
    let samples = arguments.reference_samples.unwrap_or(if arguments.quick { 32 } else { 256 });
    tell(&format!("the reference: {samples} samples a pixel"));
    Reference::render(stage, samples)
}

fn read_reference(path: &Path, arguments: &BenchArguments, subject: &Subject) -> Result<Reference, CliError> {
    let FrameFile { frame, attributes, .. } = frame_file::read(path).map_err(failure)?;
    let Size { width, height } = subject.size;
    let whole = frame.full == subject.size && frame.window == scene::Window::whole(subject.size);
    let colored = ["R", "G", "B"].iter().all(|name| frame.channel(name).is_some());
    if !whole || !colored {
        let Size { width: found_width, height: found_height } = frame.full;
        let found = format!("{found_width} x {found_height} pixels, or a crop, or no colour");
        let diagnostic = Diagnostic::error(Place::File(path.to_owned()), found)
            .expected(format!("a whole picture of {width} x {height} pixels with R, G and B"))
            .remedy(format!("give --size {found_width}x{found_height}, or render a reference of this size"));
        return Err(CliError::Usage(diagnostic));
    }
    let measured = subject.frame.to_string();
    if let Some(number) = attributes.get("imageCounter").filter(|number| **number != measured) {
        let diagnostic = Diagnostic::error(Place::File(path.to_owned()), format!("is frame {number}"))
            .expected(format!("frame {measured}, which is measured"))
            .remedy(format!("give --frame {number}, or another reference"));
        return Err(CliError::Usage(diagnostic));
    }
    Ok(Reference::known(frame, arguments.reference_noise))
}

fn output(asked: Option<&Path>, subject: &Subject, extension: &str) -> PathBuf {
    asked.map_or_else(
        || Path::new("out/bench").join(format!("{}.{extension}", subject.settings.name)),
        Path::to_owned,
    )
}

fn write(path: &Path, text: &str) -> Result<(), CliError> {
    clear(path);
    frame_file::write_whole(path, &[text.as_bytes()]).map_err(|error| {
        let reason = error.source().map_or_else(|| error.to_string(), ToString::to_string);
        cannot_write(path, reason)
    })?;
    answer(&format!("{} was written", shown(path)))
}

fn cannot_write(path: &Path, error: impl std::fmt::Display) -> CliError {
    let diagnostic = Diagnostic::error(Place::File(path.to_owned()), format!("cannot be written: {error}"))
        .expected("a place where files can be written")
        .remedy("choose another with --csv and --svg");
    CliError::InputOutput(diagnostic.to_string())
}
