//! Threads of a command. In goes a number, out comes a pool. Invariant: a pool has at least one thread.

use super::error::CliError;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::thread::available_parallelism;

/// Maximum number of threads, unless the machine has more processors; more would only take memory.
const MOST: usize = 64;

/// Pool with the requested number of threads, or with one a processor.
pub(super) fn pool(asked: Option<u32>) -> Result<ThreadPool, CliError> {
    let processors = available_parallelism().map_or(1, usize::from);
    let threads = (asked.unwrap_or(0) as usize).min(MOST.max(processors));
    ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
        CliError::InputOutput(format!(
            "error: {threads} threads cannot be started: {error}\n  expected: room for a stack each\n  \
             remedy: ask for fewer with --threads, or raise the limits of memory and processes (ulimit -v, -u)"
        ))
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn more_threads_than_are_of_use_are_not_started() {
        assert_eq!(pool(Some(3)).unwrap().current_num_threads(), 3);
        let processors = available_parallelism().map_or(1, usize::from);
        assert_eq!(pool(Some(1024)).unwrap().current_num_threads(), MOST.max(processors));
    }
}
