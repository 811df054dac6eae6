//! `sunfleck diff`: how far two frames are apart. In go two EXR files, out comes a table.

use super::arguments::DiffArguments;
use super::{CliError, answer};
use crate::diagnostic::{Diagnostic, Diagnostics, Place, shown};
use crate::frame_file::{self, FrameFile};
use crate::frame_file::{compare, net_rmse};
use std::path::Path;

pub(super) fn run(arguments: &DiffArguments) -> Result<(), CliError> {
    let output = read(&arguments.output)?;
    let reference = read(&arguments.reference)?;
    let comparison = compare(&output.frame, &reference.frame).map_err(|error| {
        let diagnostic = Diagnostic::error(Place::File(arguments.output.clone()), error.to_string())
            .expected(format!(
                "a frame of the same size and with channels of {}",
                shown(&arguments.reference)
            ))
            .remedy("render with the same --size, --crop and --passes");
        CliError::Scene(Diagnostics(vec![diagnostic]))
    })?;
    answer(&comparison.to_string())?;
    if let Some(color) = comparison.color.as_ref().filter(|_| arguments.reference_noise > 0.0) {
        answer(&format!("net RMSE {:.6}", net_rmse(color.rmse, arguments.reference_noise)))?;
    }
    Ok(())
}

fn read(path: &Path) -> Result<FrameFile, CliError> {
    frame_file::read(path).map_err(|error| CliError::InputOutput(error.diagnostic().to_string()))
}
