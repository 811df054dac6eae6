//! The program `sunfleck`. Invariant: all that is not about its command line is in the library.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::run()
}
