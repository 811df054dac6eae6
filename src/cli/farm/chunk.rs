//! Default number of frames in a task. In go machines and times, out comes a chunk. Invariant: it is a closed
//! form of the farm that `tools/tests/farm_simulation.py` simulates.

use super::super::parse::LARGEST_CHUNK;

/// Standard deviation of a frame's time relative to its mean, typical of sequences.
const SPREAD: f64 = 0.25;
/// Failures of a machine per hour: one in four days, typical of preemptible machines.
const FAILURES_PER_H: f64 = 0.01;

/// Time from a manager's decision to the program's start; managers poll every second or so.
pub(super) const MANAGER_S: f64 = 2.0;
/// Time for a script to start the program.
pub(super) const PROGRAM_S: f64 = 0.1;
/// Time of a manager for each task: Slurm starts 500 a second (its High Throughput Computing Administration
/// Guide).
const DISPATCH_S: f64 = 0.002;
/// Rate of the shared disk.
const DISK_BYTES_PER_S: f64 = 5e9;

/// Serial time of a task, in which no other machine can start one, from the bytes of the scene.
pub(super) fn serial_seconds(scene_bytes: u64) -> f64 {
    DISPATCH_S + scene_bytes as f64 / DISK_BYTES_PER_S
}

/// Machines, and the times of their tasks.
pub(super) struct Farm {
    pub(super) machines: u32,
    /// Time of a task until its first frame, without contention.
    pub(super) start_s: f64,
    /// Serialized time of a task, for the manager and the shared disk.
    pub(super) serial_s: f64,
    pub(super) frame_s: f64,
}

/// Chunk, and its cost in machine time.
#[derive(Debug)]
pub(super) struct Choice {
    pub(super) chunk: u32,
    /// Share of starting tasks.
    pub(super) starting: f64,
    /// Share of waiting: for the manager, for the last task, after failures.
    pub(super) waiting: f64,
}

impl Farm {
    /// Chunk with the most frames per hour, and the smallest of equal ones.
    pub(super) fn best_chunk(&self, frames: usize) -> Choice {
        let frames = frames as f64;
        let (seconds, chunk) = (1..=LARGEST_CHUNK)
            .map(|chunk| (self.seconds(frames, f64::from(chunk)), chunk))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((f64::INFINITY, 1));
        let all = seconds * f64::from(self.machines);
        let starting = (frames / f64::from(chunk)).ceil() * self.start_s / all;
        let rendering = frames * self.frame_s / all;
        Choice { chunk, starting, waiting: (1.0 - starting - rendering).max(0.0) }
    }

    /// Time for these frames in chunks of a size. Work is shared evenly, except for the last tasks, the
    /// longest of which ends the job (C. P. Kruskal and A. Weiss, Allocating independent subtasks on parallel
    /// processors, IEEE Transactions on Software Engineering 11, 1985). Machines stay in step, wave by wave,
    /// or their times spread until they end anywhere within a task; the smaller waiting time counts. The
    /// serial resources are a lower bound (P. J. Denning and J. P. Buzen, The operational analysis of
    /// queueing network models, Computing Surveys 10, 1978).
    ///
    /// A failure costs a start and the current frame, for any chunk, as whole frames are never rendered
    /// again: each frame ends with a checkpoint (J. T. Daly, Future Generation Computer Systems 22, 2006).
    /// But when one of the last tasks fails, half of its frames wait for another machine.
    fn seconds(&self, frames: f64, chunk: f64) -> f64 {
        let machines = f64::from(self.machines);
        let tasks = (frames / chunk).ceil();
        let (busy, waves) = (tasks.min(machines), tasks / machines);
        let task_s = self.start_s + chunk.min(frames) * self.frame_s;
        let even_s = (tasks * self.start_s + frames * self.frame_s) / machines;
        let frame_deviation_s = SPREAD * self.frame_s;
        let in_step_s =
            waves.ceil() * task_s - even_s + frame_deviation_s * (frames / busy).sqrt() * highest_of(busy);
        let last_s = if waves <= 1.0 {
            in_step_s
        } else {
            let deviation_s = frame_deviation_s * chunk.sqrt();
            // Only tasks that end within a deviation of the last one count.
            let late = highest_of(busy * deviation_s / task_s);
            in_step_s.min(task_s / 2.0 * (busy - 1.0) / (busy + 1.0) + deviation_s * late)
        };
        let failing = -(-FAILURES_PER_H / 3600.0 * busy * task_s).exp_m1();
        let shared_s = even_s + last_s + failing * task_s / 2.0 + busy * self.serial_s;
        shared_s.max(tasks * self.serial_s + task_s)
    }
}

/// Expected maximum of `count` normal deviates, in standard deviations: the quantile of G. Blom (Statistical
/// estimates and transformed beta-variables, 1958), by the lambda distribution of J. W. Tukey.
fn highest_of(count: f64) -> f64 {
    const LAMBDA: f64 = 0.135;
    if count <= 1.0 {
        return 0.0;
    }
    let quantile = (count - 0.375) / (count + 0.25);
    (quantile.powf(LAMBDA) - (1.0 - quantile).powf(LAMBDA)) / 0.1975
}

#[cfg(test)]
mod tests {
    use super::*;

    const FARM: Farm = Farm { machines: 10, start_s: 3.0, serial_s: 0.002, frame_s: 60.0 };

    #[test]
    fn the_highest_of_some_deviates_is_where_tables_have_it() {
        // H. L. Harter, Expected values of normal order statistics, Biometrika 48, 1961.
        for (count, expected) in [(1.0, 0.0), (2.0, 0.564), (10.0, 1.539), (100.0, 2.508), (400.0, 2.968)] {
            assert!((highest_of(count) - expected).abs() < 0.03, "{count}: {}", highest_of(count));
        }
    }

    #[test]
    fn one_machine_renders_as_much_as_it_may_at_a_time() {
        assert_eq!(Farm { machines: 1, ..FARM }.best_chunk(100_000).chunk, LARGEST_CHUNK);
    }

    #[test]
    fn as_many_machines_as_frames_have_one_each() {
        for frames in [1, 5, 10] {
            assert_eq!(FARM.best_chunk(frames).chunk, 1);
        }
    }

    #[test]
    fn longer_starts_want_larger_chunks_and_longer_frames_smaller_ones() {
        let chunk = |start_s, frame_s| Farm { start_s, frame_s, ..FARM }.best_chunk(10_000).chunk;
        let by_start = [0.01, 0.1, 1.0, 10.0, 100.0].map(|start_s| chunk(start_s, 60.0));
        assert!(by_start.is_sorted() && by_start[0] < by_start[4], "{by_start:?}");
        let by_frame = [600.0, 60.0, 6.0, 0.6].map(|frame_s| chunk(3.0, frame_s));
        assert!(by_frame.is_sorted() && by_frame[0] < by_frame[3], "{by_frame:?}");
    }

    #[test]
    fn shares_are_shares_at_all_ends() {
        for (start_s, frame_s) in [(0.0, 1e-6), (1e6, 1e-6), (0.0, 1e6), (1e6, 1e6)] {
            for (machines, frames) in [(1, 1), (1, 1_000_000), (100_000, 1), (100_000, 1_000_000)] {
                let choice = Farm { machines, start_s, frame_s, ..FARM }.best_chunk(frames);
                assert!((0.0..=1.0).contains(&choice.starting), "{choice:?}");
                assert!((0.0..=1.0).contains(&choice.waiting), "{choice:?}");
            }
        }
    }
}
