//! Common part of jobs' scripts. In goes a job, out come its chunks and its steps as shell commands, which
//! run in the job's folder. Invariant: a shell reads every path and name literally.

use super::super::CliError;
use super::super::error::usage;
use super::FLAGS;
use super::job::{BAKES, FRAMES, Job, Names, ranges};
use super::quoting::command_line;

/// Mark in a step's words for the frames of a task.
const MARK: char = '\u{1}';
/// Name of the file with a line a chunk.
pub(super) const CHUNKS: &str = "chunks.txt";

/// The four steps. The one that renders a chunk has its frames in the variable `frames`.
pub(super) struct Lines {
    pub(super) render: String,
    pub(super) validate: String,
    pub(super) render_again: String,
    pub(super) check: String,
}

/// Command lines; refuses names that do not fit into one line.
pub(super) fn lines(job: &Job) -> Result<Lines, CliError> {
    let flags = job.flags.iter().map(|flag| (FLAGS, flag));
    for (owner, text) in [("INPUT", &job.input), ("--out", &job.folder)].into_iter().chain(flags) {
        if text.contains(char::is_control) {
            let found = format!("`{}` has a control character", text.escape_debug());
            return Err(usage(owner, found, "paths and names without them, for scripts"));
        }
    }
    let steps = job.steps(&Names {
        input: &job.input,
        frames: &ranges(&job.frames, Some('x')),
        chunk: &MARK.to_string(),
        output: &format!("{}/{FRAMES}", job.folder),
        bakes: &format!("{}/{BAKES}", job.folder),
        progress: "plain",
    });
    let [render, validate, render_again, check] = steps.map(|step| {
        // An environment variable may name another program.
        let program = if step.program == "sunfleck" { "SUNFLECK" } else { "SUNFLECK_TOOLS" };
        let words = command_line(&step.arguments, MARK, "frames");
        format!("\"${{{program}:-{}}}\" {words}", step.program)
    });
    Ok(Lines { render, validate, render_again, check })
}

/// Lines of the chunks, and their number.
pub(super) fn chunks(job: &Job) -> (String, usize) {
    let chunks: Vec<String> =
        job.frames.chunks(job.chunk as usize).map(|each| ranges(each, Some('x'))).collect();
    (chunks.join("\n") + "\n", chunks.len())
}
