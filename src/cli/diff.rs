//! Command `diff`: differences of frames. In go two EXR files or two folders of them, out comes a table, and
//! a failure if a limit is exceeded. Invariant: each number in either folder has its line.

use super::arguments::{DiffArguments, LimitArguments};
use super::colors::ColorDoubts;
use super::error::usage;
use super::parse::ChannelsLimit;
use super::saving::failure;
use super::{CliError, answer, exposure};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use sunfleck::color::Display;
use sunfleck::diagnostic::{Diagnostic, Diagnostics, Place, shown};
use sunfleck::frame_file::{
    self, CompareError, Comparison, FrameFileError, Limit, Measure, compare, difference_picture, exceeded,
    frames_in, net_rmse,
};
use sunfleck::scene::RenderSettings;
use sunfleck::sequence::OutputPattern;

pub(super) fn run(arguments: &DiffArguments) -> Result<(), CliError> {
    let paths = [arguments.output.as_path(), arguments.reference.as_path()];
    if paths.iter().any(|path| frame_file::is_of_many(path)) {
        return run_of_folders(arguments, paths);
    }
    let pictures = Pictures::of(arguments, "difference", &arguments.reference)?;
    let work = Work { arguments, pictures, limits: arguments.limits.all(), doubts: ColorDoubts::default() };
    let comparison = work.compare(paths, 0).map_err(|error| match error {
        Fault::File(error) | Fault::Picture(error) => failure(error),
        Fault::Comparison(error) => CliError::Scene(Diagnostics(vec![
            Diagnostic::error(Place::File(arguments.output.clone()), error.to_string())
                .expected(format!("a frame of the same size and with channels of {}", shown(paths[1])))
                .remedy("render with the same --size, --crop and --passes"),
        ])),
    })?;
    answer(&comparison.to_string())?;
    if let Some(color) = comparison.color.as_ref().filter(|_| arguments.reference_noise > 0.0) {
        answer(&format!("net RMSE {:.6}", net_rmse(color.rmse, arguments.reference_noise)))?;
    }
    work.end(&work.too_much(comparison).join("; "))
}

/// Compares frames with equal numbers.
fn run_of_folders(arguments: &DiffArguments, paths: [&Path; 2]) -> Result<(), CliError> {
    if let Some(file) = paths.into_iter().find(|path| path.is_file()) {
        return Err(usage(
            "diff",
            format!("{} is a file", shown(file)),
            "two files, or two folders or sequences",
        ));
    }
    let [ours, theirs] = paths.map(|path| frames_in(path).map_err(failure));
    let [ours, theirs]: [BTreeMap<i64, PathBuf>; 2] = [ours?, theirs?];
    let numbers: BTreeSet<i64> = ours.keys().chain(theirs.keys()).copied().collect();
    let numbers: Vec<i64> = numbers.into_iter().collect();
    let Some(middle) = theirs.values().nth(theirs.len() / 2) else {
        return Err(usage(
            "REFERENCE",
            format!("there is no frame in {}", shown(paths[1])),
            "a folder of frames",
        ));
    };
    let pictures = Pictures::of(arguments, "difference", middle)?;
    if let Some(pictures) = &pictures {
        pictures.pattern.check(numbers.len()).map_err(CliError::Usage)?;
    }
    let work = Work { arguments, pictures, limits: arguments.limits.all(), doubts: ColorDoubts::default() };
    let line = |&number: &i64| {
        let pair = ours.get(&number).zip(theirs.get(&number)).ok_or_else(|| {
            let lacking = paths[usize::from(ours.contains_key(&number))];
            format!("{} has no such frame", shown(lacking))
        });
        let compared = pair.map(|(one, other)| work.compare([one, other], number));
        Ok(match compared {
            Ok(Ok(comparison)) => {
                let headline = headline(&comparison);
                let too_much = work.too_much(comparison);
                let is_kept = too_much.is_empty();
                let over =
                    if is_kept { String::new() } else { format!("; too much: {}", too_much.join("; ")) };
                (is_kept, format!("frame {number}: {headline}{over}"))
            }
            Ok(Err(Fault::Picture(error))) => return Err(failure(error)),
            Ok(Err(reason)) => (false, format!("frame {number}: {reason}")),
            Err(reason) => (false, format!("frame {number}: {reason}")),
        })
    };
    let mut bad = 0;
    for group in numbers.chunks(rayon::current_num_threads()) {
        let lines: Vec<Result<(bool, String), CliError>> = group.par_iter().map(line).collect();
        for line in lines {
            let (is_kept, line) = line?;
            answer(&line)?;
            bad += usize::from(!is_kept);
        }
    }
    work.end(&if bad > 0 { format!("{bad} of {} frames", numbers.len()) } else { String::new() })
}

/// Line of one frame among many: its colour, else its first channel.
fn headline(found: &Comparison) -> String {
    match (&found.color, found.channels.first(), found.ids.first()) {
        (Some(color), ..) => format!("RGB  {color}"),
        (None, Some(channel), _) => format!("{}  {}", channel.name, channel.errors),
        (None, None, Some(ids)) => format!("{}  {ids}", ids.name),
        (None, None, None) => String::new(),
    }
}

/// Options for each pair of files.
struct Work<'a> {
    arguments: &'a DiffArguments,
    pictures: Option<Pictures>,
    limits: Vec<Limit>,
    doubts: ColorDoubts,
}

/// Paths of pictures of differences, and their display.
struct Pictures {
    pattern: OutputPattern,
    display: Display,
}

/// Reason why there is no comparison.
#[derive(Debug, thiserror::Error)]
enum Fault {
    #[error("{0}")]
    File(#[from] FrameFileError),
    #[error("{0}")]
    Comparison(#[from] CompareError),
    #[error("{0}")]
    Picture(FrameFileError),
}

impl Pictures {
    /// Pictures, if they are requested, with the user's exposure or else a frame's automatic one.
    fn of(arguments: &DiffArguments, name: &str, frame: &Path) -> Result<Option<Self>, CliError> {
        let Some(out) = &arguments.picture else { return Ok(None) };
        let pattern = OutputPattern::parse_as(out, name, "png", "--picture").map_err(CliError::Usage)?;
        let measured = || frame_file::read(frame).map(|file| file.shown().auto_exposure_stops());
        Ok(Some(Self {
            pattern,
            display: exposure::display(&arguments.display, &RenderSettings::default(), measured)
                .map_err(failure)?,
        }))
    }
}

impl Work<'_> {
    /// Compares two files, and writes their picture.
    fn compare(&self, paths: [&Path; 2], number: i64) -> Result<Comparison, Fault> {
        let mut files = frame_file::read_both(paths)?;
        self.doubts.in_one_space(paths, &mut files);
        let [output, reference] = files;
        let comparison = compare(&output.frame, &reference.frame)?;
        if let Some(Pictures { pattern, display }) = &self.pictures {
            let path = pattern.path(number);
            self.doubts.tell_shown(paths[0], &output);
            let picture = difference_picture(output, reference, display, self.arguments.white)
                .map_err(|reason| FrameFileError::Encode { path: path.clone(), reason });
            picture.and_then(|picture| picture.write(&path)).map_err(Fault::Picture)?;
        }
        Ok(comparison)
    }

    /// Sentence for each exceeded limit, after subtraction of the reference's noise.
    fn too_much(&self, mut comparison: Comparison) -> Vec<String> {
        if let Some(color) = comparison.color.as_mut().filter(|_| self.arguments.reference_noise > 0.0) {
            color.rmse = net_rmse(color.rmse, self.arguments.reference_noise);
        }
        exceeded(&comparison, &self.limits)
    }

    /// Fails if there is a sentence about an exceeded limit.
    fn end(&self, too_far: &str) -> Result<(), CliError> {
        if too_far.is_empty() {
            return Ok(());
        }
        let DiffArguments { output, reference, .. } = self.arguments;
        let found = format!("too far from {}: {too_far}", shown(reference));
        let diagnostic = Diagnostic::error(Place::File(output.clone()), found)
            .expected("errors within the limits given, in frames and channels that both have")
            .remedy("see which channels differ in the table, or raise the limit of theirs, such as --max-rmse diffuse.*=0.01");
        Err(CliError::Frame(diagnostic.to_string()))
    }
}

impl LimitArguments {
    /// Limits of every measure, in the order of the command line.
    fn all(&self) -> Vec<Limit> {
        let given = [
            (Measure::Rmse, &self.max_rmse),
            (Measure::RelativeMse, &self.max_relmse),
            (Measure::MaxError, &self.max_error),
            (Measure::Ids, &self.max_ids),
        ];
        let limit =
            |measure, given: &ChannelsLimit| Limit { measure, channels: given.0.clone(), most: given.1 };
        given.iter().flat_map(|(measure, given)| given.iter().map(|given| limit(*measure, given))).collect()
    }
}
