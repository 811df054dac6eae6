//! Program `sunfleck`. In go arguments, out comes an exit code. Invariant: only the command line lives here;
//! all else is in the library.

mod cli;

use std::panic::resume_unwind;
use std::process::ExitCode;
use std::thread::Builder;

/// Stack in bytes, Linux's default: deeply nested files need most.
const STACK: usize = 8 << 20;

/// Runs the program on a thread of its own, whose stack does not depend on the system's limit (`ulimit -s`).
fn main() -> ExitCode {
    match Builder::new().name(String::from("main")).stack_size(STACK).spawn(cli::run) {
        Ok(run) => run.join().unwrap_or_else(|panic| resume_unwind(panic)),
        Err(error) => cli::no_stack(&error),
    }
}
