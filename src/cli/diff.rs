//! `sunfleck diff`: how far two frames are apart. In go two EXR files, out comes a table, and a failure
//! if a limit is not kept.

use super::arguments::{DiffArguments, LimitArguments};
use super::parse::ChannelsLimit;
use super::saving::failure;
use super::{CliError, answer, colors};
use sunfleck::diagnostic::{Diagnostic, Diagnostics, Place, shown};
use sunfleck::frame_file::{self, Limit, Measure, compare, exceeded, net_rmse};

pub(super) fn run(arguments: &DiffArguments) -> Result<(), CliError> {
    let paths = [arguments.output.as_path(), &arguments.reference];
    let [mut output, mut reference] = frame_file::read_both(paths).map_err(failure)?;
    colors::in_one_space(paths, [&mut output, &mut reference]);
    let mut comparison = compare(&output.frame, &reference.frame).map_err(|error| {
        let diagnostic = Diagnostic::error(Place::File(arguments.output.clone()), error.to_string())
            .expected(format!(
                "a frame of the same size and with channels of {}",
                shown(&arguments.reference)
            ))
            .remedy("render with the same --size, --crop and --passes");
        CliError::Scene(Diagnostics(vec![diagnostic]))
    })?;
    answer(&comparison.to_string())?;
    if let Some(color) = comparison.color.as_mut().filter(|_| arguments.reference_noise > 0.0) {
        color.rmse = net_rmse(color.rmse, arguments.reference_noise);
        answer(&format!("net RMSE {:.6}", color.rmse))?;
    }
    check(arguments, &exceeded(&comparison, &arguments.limits.all()))
}

/// Says which limits are not kept.
fn check(arguments: &DiffArguments, too_much: &[String]) -> Result<(), CliError> {
    if too_much.is_empty() {
        return Ok(());
    }
    let found = format!("too far from {}: {}", shown(&arguments.reference), too_much.join("; "));
    let diagnostic = Diagnostic::error(Place::File(arguments.output.clone()), found)
        .expected("errors within the limits given, in channels that both frames have")
        .remedy("see which channels differ in the table, or raise the limit of theirs, such as --max-rmse diffuse.*=0.01");
    Err(CliError::Frame(diagnostic.to_string()))
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
