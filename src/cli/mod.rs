//! The command line: arguments in, exit code out. Invariant: every failure names its cause and a remedy on
//! the error stream, and has the exit code of its kind.

// Its comments are the help, whose brackets are no links.
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

/// Runs the program on its command line.
pub(crate) fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            // Help and version are answers, not failures; a closed pipe is nobody's concern.
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

/// Ends a program whose thread cannot be started.
pub(crate) fn no_stack(error: &std::io::Error) -> ExitCode {
    tell(&format!(
        "error: a thread with 8 MB of stack cannot be started: {error}\n  expected: room for it\n  \
         remedy: raise the limits of memory and processes (ulimit -v, -u)"
    ));
    ExitCode::from(error::INPUT_OUTPUT)
}

/// Passes for reading, as `--passes` takes them.
fn pass_names(passes: &[Pass]) -> String {
    if passes.is_empty() {
        return String::from("beauty alone");
    }
    format!("beauty and {}", passes.iter().map(|pass| pass.name()).collect::<Vec<_>>().join(","))
}

/// A line on the error stream. That it takes none (closed, full, nobody reads) stops no work.
fn tell(message: &str) {
    let _ = writeln!(std::io::stderr(), "{message}");
}

/// A line on the output stream. That nobody reads on (`| head`) is no failure.
///
/// # Errors
/// The stream takes no more for any other reason: a full disk.
fn answer(message: &str) -> Result<(), CliError> {
    match writeln!(std::io::stdout(), "{message}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::InputOutput(format!(
            "error: the answer cannot be written: {error}\n  expected: an output stream that takes it\n  \
                 remedy: free room where it goes, or send it elsewhere"
        ))),
        _ => Ok(()),
    }
}
