//! The program `sunfleck`; everything it does is in the library's `cli`.

use std::process::ExitCode;

fn main() -> ExitCode {
    sunfleck::cli::run()
}
