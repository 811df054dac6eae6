//! Job of a farm, whoever manages it. In go the manager's names for its parts, out come the steps as
//! command lines. Invariant: frames that are there and whole are kept, so a step that was stopped anywhere
//! is done again by its own command.

use sunfleck::scene::Sampling;

/// Frames are in this folder of the job's.
pub(super) const FRAMES: &str = "frames";
/// Falls that were baked are in this one.
pub(super) const BAKES: &str = "bakes";

/// Memory beside that of the picture and the input's files: the program itself, its trees, the encoding of
/// a frame.
const MIB_BESIDE: u64 = 512;
/// A mesh or a texture in memory, by its bytes in a file, which may be compressed.
const MEMORY_BY_FILE: u64 = 8;

/// Time of a sample on one thread, with all light, in most scenes.
const SECONDS_A_SAMPLE: f64 = 1e-4 / 3.0;
/// Time that a task may take, over the estimate for its frames.
const PATIENCE: f64 = 3.0;
/// Samples that are assumed of a picture that is rendered until it is good enough.
const MOST_USUAL_SAMPLES: u32 = 64;
const FEWEST_MINUTES: u64 = 15;
const MOST_MINUTES: u64 = 24 * 60;

/// An input that is to be rendered on many machines.
pub(super) struct Job {
    pub(super) name: String,
    /// Absolute, as are all paths here.
    pub(super) input: String,
    /// Every file that the scene reads.
    pub(super) files: Vec<String>,
    pub(super) folder: String,
    /// Ascending.
    pub(super) frames: Vec<i64>,
    /// Frames that a task renders.
    pub(super) chunk: u32,
    /// Why so many, if nobody said.
    pub(super) why: Option<String>,
    /// Flags of `sunfleck render`, for every task.
    pub(super) flags: Vec<String>,
    /// Nothing moves, so that frames may look like the ones before.
    pub(super) is_still: bool,
    /// Memory that a machine should have.
    pub(super) memory_mib: u64,
    /// Threads that a task renders with, if the flags say.
    pub(super) threads: Option<u32>,
    /// Time that a task is given, where a manager wants a limit.
    pub(super) minutes: u64,
    /// Number of machines that share the work, if somebody says.
    pub(super) machines: Option<u32>,
}

/// Names that a manager has for the parts of a command line.
pub(super) struct Names<'a> {
    pub(super) input: &'a str,
    pub(super) frames: &'a str,
    /// Frames of a task.
    pub(super) chunk: &'a str,
    pub(super) output: &'a str,
    pub(super) bakes: &'a str,
    pub(super) progress: &'a str,
}

/// A command line, run once, or once for every chunk of frames. Each step waits for the one before.
pub(super) struct Step {
    pub(super) name: &'static str,
    pub(super) program: &'static str,
    pub(super) arguments: Vec<String>,
    pub(super) is_chunked: bool,
}

impl Job {
    /// Steps of the job: render; look at what is there; render again what is not as it should be; and look
    /// again. The last one fails if the job is not whole.
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
        // The slash says that it is a folder before there is one.
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

/// Memory for pictures and an input of so many bytes; generous, as a machine without it fails slowly.
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

/// Time limit of a task of so many frames. Generous: a task that reaches its limit goes on in another,
/// which starts anew.
pub(super) fn minutes(frames: u32, frame_s: f64) -> u64 {
    let minutes = PATIENCE * f64::from(frames) * frame_s / 60.0;
    (minutes.ceil() as u64).clamp(FEWEST_MINUTES, MOST_MINUTES)
}

/// The shortest list of ranges that these ascending frames are; every nth frame is a range with a step if
/// there is a sign for that.
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

/// Number of frames from the first on that are the same step apart, and that step.
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
