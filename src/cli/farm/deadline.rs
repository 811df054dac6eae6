//! Jobs of Deadline 10 for its plug-in CommandLine. In goes a job, out come two files a step. Invariant: only
//! requested frames are rendered, although Deadline gives a task only its first and last frame.

use super::super::CliError;
use super::super::error::usage;
use super::JobFile;
use super::job::{BAKES, FRAMES, Job, Names, Step, ranges};
use super::quoting::quoted;

pub(super) fn files(job: &Job) -> Result<Vec<JobFile>, CliError> {
    let output = format!("{}/{FRAMES}", job.folder);
    let steps = steps(job, &output);
    let mut files = Vec::new();
    for step in &steps {
        let name = step.name.to_lowercase();
        files.push((format!("{name}.job"), job_info(job, step, &output)));
        files.push((format!("{name}.plugin"), plugin_info(step)?));
    }
    Ok(files)
}

pub(super) fn how_to_submit(job: &Job) -> String {
    let names = ["render", "validate", "renderagain", "check"];
    let jobs = names
        .map(|name| {
            let file = |kind| quoted(&format!("{}/{name}.{kind}", job.folder));
            format!(" -job {} {}", file("job"), file("plugin"))
        })
        .concat();
    format!("submit it by `deadlinecommand -SubmitMultipleJobs -dependent{jobs}`")
}

fn steps(job: &Job, output: &str) -> [Step; 4] {
    job.steps(&Names {
        input: &job.input,
        frames: &ranges(&job.frames, Some('x')),
        chunk: "<STARTFRAME>-<ENDFRAME>",
        output,
        bakes: &format!("{}/{BAKES}", job.folder),
        progress: "plain",
    })
}

fn job_info(job: &Job, step: &Step, output: &str) -> String {
    let name = job.name.replace(char::is_control, " ");
    // There may be other frames between a task's first and last.
    let is_one_range = job.frames.windows(2).all(|pair| pair[1] == pair[0] + 1);
    let (frames, chunk) = match step.is_chunked {
        true => (ranges(&job.frames, Some('x')), if is_one_range { job.chunk } else { 1 }),
        false => (String::from("0"), 1),
    };
    let mut lines = vec![
        String::from("Plugin=CommandLine"),
        format!("Name={name}: {}", step.name),
        format!("BatchName={name}"),
        format!("Frames={frames}"),
        format!("ChunkSize={chunk}"),
        format!("OutputDirectory0={output}"),
    ];
    // Deadline's list has no escape for commas.
    if !job.files.iter().any(|file| file.contains(',')) {
        lines.push(format!("RequiredAssets={}", job.files.join(",")));
    }
    lines.join("\n") + "\n"
}

fn plugin_info(step: &Step) -> Result<String, CliError> {
    let mut arguments = Vec::new();
    for argument in &step.arguments {
        if argument.contains(['"', '\n', '\r']) {
            let found = format!("`{}` has a quotation mark or a line break", argument.escape_debug());
            return Err(usage(
                "the job's paths and flags",
                found,
                "paths and names without them, for Deadline",
            ));
        }
        arguments.push(format!("<QUOTE>{argument}<QUOTE>"));
    }
    let Step { program, .. } = step;
    let arguments = arguments.join(" ");
    Ok(format!(
        "Executable={program}\nArguments={arguments}\nShell=default\nShellExecute=False\nSingleFramesOnly=False\n"
    ))
}
