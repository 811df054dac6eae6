//! Workers that render frames simultaneously. In go threads, memory and a requested number, out come pools.
//! Invariant: all pools together have the requested number of threads.
//!
//! A single frame leaves threads idle: a third of the time for indirect light is serial. Two frames, each
//! with half of the threads, leave almost none idle (docs/decisions/frames-at-once.md).

use super::process::{is_there_any, peak_memory_bytes, times_more};
use super::threads;
use rayon::ThreadPool;
use std::sync::OnceLock;

/// Default threads for each frame; more frames would take more memory.
const THREADS_A_FRAME: usize = 4;

/// Pools of workers, and one of all threads for the first frame.
pub(super) struct Workers<'a> {
    all: &'a ThreadPool,
    pools: OnceLock<Vec<ThreadPool>>,
    asked: Option<usize>,
}

impl<'a> Workers<'a> {
    /// Creates `asked` workers, or as many as threads and memory allow.
    pub(super) fn new(all: &'a ThreadPool, asked: Option<usize>) -> Self {
        Self { all, pools: OnceLock::new(), asked }
    }

    /// Starts workers for the remaining frames; returns their number.
    pub(super) fn start(&self, left: usize) -> usize {
        let threads = self.all.current_num_threads();
        let count = self.asked.unwrap_or_else(|| usual(threads, room())).min(threads).min(left);
        if count < 2 {
            return 1;
        }
        let share = |number: usize| (number + 1) * threads / count - number * threads / count;
        // If threads cannot be started, frames are rendered one by one.
        let pools = (0..count).map(|number| threads::pool(u32::try_from(share(number)).ok()));
        match pools.collect::<Result<Vec<_>, _>>() {
            Ok(pools) => self.pools.get_or_init(|| pools).len(),
            Err(_) => 1,
        }
    }

    pub(super) fn pool(&self, worker: usize) -> &ThreadPool {
        self.pools.get().and_then(|pools| pools.get(worker)).unwrap_or(self.all)
    }
}

/// Number of frames that fit into memory, from the first frame's usage.
fn room() -> usize {
    // A failed allocation would abort the process.
    if is_there_any() {
        return 1;
    }
    1 + peak_memory_bytes().and_then(times_more).unwrap_or(1)
}

/// Default number of simultaneous frames.
fn usual(threads: usize, room: usize) -> usize {
    (threads / THREADS_A_FRAME).max(2).min(room)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn two_threads_have_a_frame_each_where_there_is_memory() {
        assert_eq!([usual(2, 9), usual(2, 1), usual(16, 9), usual(16, 3)], [2, 1, 4, 3]);
    }

    #[test]
    fn workers_share_the_threads() {
        let all = threads::pool(Some(5)).unwrap();
        let threads_of = |asked: usize, left: usize| {
            let workers = Workers::new(&all, Some(asked));
            let count = workers.start(left);
            (0..count).map(|number| workers.pool(number).current_num_threads()).collect::<Vec<_>>()
        };
        assert_eq!(threads_of(2, 9), [2, 3]);
        assert_eq!(threads_of(9, 9), [1; 5]);
        assert_eq!(threads_of(9, 2), [2, 3]);
        assert_eq!(threads_of(2, 1), [5]);
        assert_eq!(threads_of(2, 0), [5]);
    }
}
