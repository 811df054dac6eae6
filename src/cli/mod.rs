//! Command line. In go arguments, out comes an exit code. Invariant: every failure names its cause and a
//! remedy on standard error, and has the exit code of its kind.

// Its comments are the program's help, where brackets are not links.
#[allow(rustdoc::broken_intra_doc_links)]
mod arguments;
mod bench;
#[allow(rustdoc::broken_intra_doc_links)]
mod bench_arguments;
mod colors;
mod darkness;
mod diff;
mod doubts;
mod error;
mod export;
mod exposure;
mod farm;
mod inspect;
mod live;
mod loading;
mod parse;
mod plan;
mod preview;
mod process;
mod progress;
mod render;
mod saving;
mod serve;
#[allow(rustdoc::broken_intra_doc_links)]
mod shared_arguments;
mod signals;
mod stats;
mod threads;
mod unshown;
mod words;
mod workers;

use arguments::{Arguments, Command};
use clap::{CommandFactory, Parser};
use signals::Stop;
use std::io::{ErrorKind, Write as _};
use std::process::ExitCode;
use sunfleck::passes::Pass;

use error::CliError;

/// Runs the program with its command line.
pub(crate) fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are not failures, and a closed pipe does not matter.
            let _ = error.print();
            return ExitCode::from(if error.use_stderr() { error::USAGE } else { 0 });
        }
    };
    if let Some(note) = process::tight_memory() {
        tell(&note);
    }
    let stop = match Stop::watch() {
        Ok(stop) => stop,
        Err(error) => {
            tell(&error.to_string());
            return ExitCode::from(error.code());
        }
    };
    let result = match arguments.command {
        Command::Render(arguments) => render::run(&arguments, &stop),
        Command::Preview(arguments) => preview::run(&arguments),
        Command::Inspect(arguments) => inspect::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Diff(arguments) => diff::run(&arguments),
        Command::Farm(arguments) => farm::run(&arguments),
        Command::Serve(arguments) => serve::run(&arguments),
        Command::Export(arguments) => export::run(&arguments),
        Command::Completions { shell } => {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "sunfleck", &mut script);
            answer(String::from_utf8_lossy(&script).trim_end())
        }
    };
    ExitCode::from(stop.code(result))
}

/// Reports that the main thread cannot be started.
pub(crate) fn no_stack(error: &std::io::Error) -> ExitCode {
    tell(&format!(
        "error: a thread with 8 MB of stack cannot be started: {error}\n  expected: room for it\n  \
         remedy: raise the limits of memory and processes (ulimit -v, -u)"
    ));
    ExitCode::from(error::INPUT_OUTPUT)
}

/// List of passes for `--passes`.
fn pass_names(passes: &[Pass]) -> String {
    if passes.is_empty() {
        return String::from("beauty alone");
    }
    format!("beauty and {}", passes.iter().map(|pass| pass.name()).collect::<Vec<_>>().join(","))
}

/// Prints a line on standard error. A failure (closed, full, no reader) is ignored.
fn tell(message: &str) {
    let _ = writeln!(std::io::stderr(), "{message}");
}

/// Prints a line on standard output. A closed pipe (`| head`) is not a failure.
///
/// # Errors
/// If it cannot be written for another reason, such as a full disk.
fn answer(message: &str) -> Result<(), CliError> {
    match writeln!(std::io::stdout(), "{message}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::InputOutput(format!(
            "error: the answer cannot be written: {error}\n  expected: an output stream that takes it\n  \
                 remedy: free room where it goes, or send it elsewhere"
        ))),
        _ => Ok(()),
    }
}
