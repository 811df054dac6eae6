//! Common part of scripts of jobs. In goes a job, out come its chunks and its steps as command lines of a
//! shell, which run in the job's folder. Invariant: no path or name is read by a shell as anything else.

use super::super::CliError;
use super::super::error::usage;
use super::FLAGS;
use super::job::{BAKES, FRAMES, Job, Names, ranges};
use super::quoting::command_line;

/// Mark in the words of a step that stands for the frames of a task.
const MARK: char = '\u{1}';
/// File with a line for each chunk.
pub(super) const CHUNKS: &str = "chunks.txt";

/// The four steps. That which renders a chunk takes its frames from the variable `frames`.
pub(super) struct Lines {
    pub(super) render: String,
    pub(super) validate: String,
    pub(super) render_again: String,
    pub(super) check: String,
}

/// Refuses what cannot be said in a line.
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
        // Other programs than those on the search path, if need be.
        let program = if step.program == "sunfleck" { "SUNFLECK" } else { "SUNFLECK_TOOLS" };
        let words = command_line(&step.arguments, MARK, "frames");
        format!("\"${{{program}:-{}}}\" {words}", step.program)
    });
    Ok(Lines { render, validate, render_again, check })
}

/// The chunks, and how many there are.
pub(super) fn chunks(job: &Job) -> (String, usize) {
    let chunks: Vec<String> =
        job.frames.chunks(job.chunk as usize).map(|each| ranges(each, Some('x'))).collect();
    (chunks.join("\n") + "\n", chunks.len())
}
