//! The program `sunfleck`. Invariant: all that is not about its command line is in the library.

mod cli;

use std::panic::resume_unwind;
use std::process::ExitCode;
use std::thread::Builder;

/// Bytes of stack, as Linux gives by itself: deeply nested files take most.
const STACK: usize = 8 << 20;

/// On a thread of its own, the stack is as large as it has to be whatever the system's limit (`ulimit -s`).
fn main() -> ExitCode {
    match Builder::new().name(String::from("main")).stack_size(STACK).spawn(cli::run) {
        Ok(run) => run.join().unwrap_or_else(|panic| resume_unwind(panic)),
        Err(error) => cli::no_stack(&error),
    }
}
