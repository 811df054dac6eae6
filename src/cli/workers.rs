//! Frames that are rendered at once. In go threads, memory and what was asked for, out come pools. Invariant:
//! all together have the threads that were asked for.
//!
//! A frame alone leaves threads idle: a third of what indirect light takes is done by one. Two frames, each
//! on half of the threads, leave next to none (docs/decisions/frames-at-once.md).

use super::process::{is_there_any, peak_memory_bytes, times_more};
use super::threads;
use rayon::ThreadPool;
use std::sync::OnceLock;

/// Threads for each frame where nobody says how many frames: more take memory.
const THREADS_A_FRAME: usize = 4;

/// Pools of workers, and the one of all threads, for as long as there is but one frame.
pub(super) struct Workers<'a> {
    all: &'a ThreadPool,
    pools: OnceLock<Vec<ThreadPool>>,
    asked: Option<usize>,
}

impl<'a> Workers<'a> {
    /// As many as `asked`, or as threads and memory allow.
    pub(super) fn new(all: &'a ThreadPool, asked: Option<usize>) -> Self {
        Self { all, pools: OnceLock::new(), asked }
    }

    /// Starts workers for so many frames that are left; tells how many.
    pub(super) fn start(&self, left: usize) -> usize {
        let threads = self.all.current_num_threads();
        let count = self.asked.unwrap_or_else(|| usual(threads, room())).min(threads).min(left);
        if count < 2 {
            return 1;
        }
        let share = |number: usize| (number + 1) * threads / count - number * threads / count;
        // Where threads cannot be had frames come one after the other.
        let pools = (0..count).map(|number| threads::pool(u32::try_from(share(number)).ok()));
        match pools.collect::<Result<Vec<_>, _>>() {
            Ok(pools) => self.pools.get_or_init(|| pools).len(),
            Err(_) => 1,
        }
    }

    /// Threads of a worker.
    pub(super) fn pool(&self, worker: usize) -> &ThreadPool {
        self.pools.get().and_then(|pools| pools.get(worker)).unwrap_or(self.all)
    }
}

/// Frames for which there is memory, by what the first has taken.
fn room() -> usize {
    // Where the system may refuse memory the process would end.
    if is_there_any() {
        return 1;
    }
    1 + peak_memory_bytes().and_then(times_more).unwrap_or(1)
}

/// Frames at once where nobody says.
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
