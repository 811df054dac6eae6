//! Job of a farm, for any manager. In go the manager's names for its parts, out come the steps as command
//! lines. Invariant: valid frames are kept, so a stopped step is resumed by its own command.

use sunfleck::scene::Sampling;

/// Folder of frames, in the job's folder.
pub(super) const FRAMES: &str = "frames";
/// Folder of baked falls.
pub(super) const BAKES: &str = "bakes";

/// Memory in addition to the picture and the input's files: the program, trees, and the encoding of a frame.
const MIB_BESIDE: u64 = 512;
/// Bytes of a mesh or texture in memory per byte of its file, which may be compressed.
const MEMORY_BY_FILE: u64 = 8;

/// Typical time of a sample on one thread, with all light.
const SECONDS_A_SAMPLE: f64 = 1e-4 / 3.0;
/// Time limit of a task relative to the estimate for its frames.
const PATIENCE: f64 = 3.0;
/// Assumed samples of a picture with a tolerance.
const MOST_USUAL_SAMPLES: u32 = 64;
const FEWEST_MINUTES: u64 = 15;
const MOST_MINUTES: u64 = 24 * 60;

/// Input to render on many machines.
pub(super) struct Job {
    pub(super) name: String,
    /// Absolute path, as all paths here.
    pub(super) input: String,
    /// Every file that the scene reads.
    pub(super) files: Vec<String>,
    pub(super) folder: String,
    /// Frame numbers, ascending.
    pub(super) frames: Vec<i64>,
    /// Number of frames in a task.
    pub(super) chunk: u32,
    /// Reason for the chunk, if the user did not set it.
    pub(super) why: Option<String>,
    /// Flags of `sunfleck render` for every task.
    pub(super) flags: Vec<String>,
    /// Whether the scene is still, so that equal frames are no fault.
    pub(super) is_still: bool,
    /// Memory that a machine should have, MiB.
    pub(super) memory_mib: u64,
    /// Threads of a task, if the flags set them.
    pub(super) threads: Option<u32>,
    /// Time limit of a task, for managers that need one.
    pub(super) minutes: u64,
    /// Number of machines, if the user sets it.
    pub(super) machines: Option<u32>,
}

/// Manager's names for the parts of a command line.
pub(super) struct Names<'a> {
    pub(super) input: &'a str,
    pub(super) frames: &'a str,
    /// Frames of a task.
    pub(super) chunk: &'a str,
    pub(super) output: &'a str,
    pub(super) bakes: &'a str,
    pub(super) progress: &'a str,
}

/// Command line that runs once, or once a chunk. Each step waits for the one before.
pub(super) struct Step {
    pub(super) name: &'static str,
    pub(super) program: &'static str,
    pub(super) arguments: Vec<String>,
    pub(super) is_chunked: bool,
}

impl Job {
    /// Steps of the job: render, check, render faulty frames again, check again. The last one fails if the
    /// job is incomplete.
    pub(super) fn steps(&self, names: &Names) -> [Step; 4] {
        let missing = format!("{}/missing.txt", names.output);
        let listed = format!("@{missing}");
        let step = |name, program, arguments, is_chunked| Step { name, program, arguments, is_chunked };
        [
            step("Render", "sunfleck", self.render(names, names.chunk, "valid"), true),
            step("Validate", "sunfleck-tools", self.validate(names, &["--write-missing", &missing]), false),
            step("RenderAgain", "sunfleck", self.render(names, &listed, "none"), false),
            step("Check", "sunfleck-tools", self.validate(names, &[]), false),
        ]
    }

    fn render(&self, names: &Names, frames: &str, skip: &str) -> Vec<String> {
        // The slash marks a folder that does not exist yet.
        let output = format!("{}/", names.output);
        let flags = [
            ("--frames", frames),
            ("--out", &output),
            ("--skip", skip),
            ("--bake-cache", names.bakes),
            ("--progress", names.progress),
        ];
        let flags = flags.into_iter().map(|(flag, value)| format!("{flag}={value}"));
        let head = ["render", names.input].map(str::to_owned);
        head.into_iter().chain(flags).chain(self.flags.iter().cloned()).collect()
    }

    fn validate(&self, names: &Names, more: &[&str]) -> Vec<String> {
        let frames = format!("--frames={}", names.frames);
        let still: &[&str] = if self.is_still { &["--static"] } else { &[] };
        [&["validate", names.output, &frames], still, more].concat().into_iter().map(str::to_owned).collect()
    }
}

/// Memory for pictures and an input of these sizes; generous, as a machine with too little fails slowly.
pub(super) fn memory_mib(picture_bytes: u64, file_bytes: u64) -> u64 {
    MIB_BESIDE + (picture_bytes + MEMORY_BY_FILE * file_bytes).div_ceil(1 << 20)
}

pub(super) fn frame_seconds(pixels: usize, sampling: Sampling, threads: u32) -> f64 {
    let samples = match sampling {
        Sampling::Exactly(count) => count,
        Sampling::Until { most, .. } => most.min(MOST_USUAL_SAMPLES),
    };
    pixels as f64 * f64::from(samples) * SECONDS_A_SAMPLE / f64::from(threads)
}

/// Time limit of a task. Generous: frames of a task that reaches it go on in another, which starts anew.
pub(super) fn minutes(frames: u32, frame_s: f64) -> u64 {
    let minutes = PATIENCE * f64::from(frames) * frame_s / 60.0;
    (minutes.ceil() as u64).clamp(FEWEST_MINUTES, MOST_MINUTES)
}

/// Shortest list of ranges with these ascending frames. With `step_sign` a range may have a step.
pub(super) fn ranges(frames: &[i64], step_sign: Option<char>) -> String {
    let mut ranges = Vec::new();
    let mut rest = frames;
    while let Some(&first) = rest.first() {
        let (length, step) = progression(rest);
        let last = rest[length - 1];
        let (length, range) = match step_sign {
            _ if length == 1 => (1, first.to_string()),
            _ if step == 1 => (length, format!("{first}-{last}")),
            Some(sign) if length > 2 => (length, format!("{first}-{last}{sign}{step}")),
            _ => (1, first.to_string()),
        };
        ranges.push(range);
        rest = &rest[length..];
    }
    ranges.join(",")
}

/// Length and step of the arithmetic progression at the start.
fn progression(frames: &[i64]) -> (usize, i64) {
    let Some(step) = frames.get(1).map(|second| second - frames[0]) else { return (frames.len(), 1) };
    let equal = frames.windows(2).take_while(|pair| pair[1] - pair[0] == step).count();
    (equal + 1, step)
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn frames_become_the_ranges_that_they_are() {
        let table: [(&[i64], &str, &str); 7] = [
            (&[7], "7", "7"),
            (&[1, 2, 3, 4], "1-4", "1-4"),
            (&[-5, -4, -3], "-5--3", "-5--3"),
            (&[1, 3, 5, 7], "1-7:2", "1,3,5,7"),
            (&[1, 4], "1,4", "1,4"),
            (&[1, 2, 3, 10, 20, 30, 31], "1-3,10-30:10,31", "1-3,10,20,30-31"),
            (&[2, 5, 6, 7], "2,5-7", "2,5-7"),
        ];
        for (frames, stepped, plain) in table {
            assert_eq!(ranges(frames, Some(':')), stepped);
            assert_eq!(ranges(frames, None), plain);
        }
    }
}
