//! Jobs of Slurm: an array of chunks, and three dependent steps. In goes a job, out come the scripts of its
//! tasks and one that submits them. Invariant: at its time limit a task ends with whole frames, and continues
//! in another, while tasks finish at least a frame each on average.

use super::super::CliError;
use super::JobFile;
use super::job::Job;
use super::quoting::quoted;
use super::scripts::{CHUNKS, chunks, lines};

/// Maximum number of tasks in an array: Slurm's default limit is 1001 (`MaxArraySize`).
const MOST_TASKS: usize = 1000;
/// Seconds before the time limit at which a task gets a signal; Slurm may add a minute.
const NOTICE_S: u32 = 60;
/// Turns beyond one a frame, for failing nodes.
const MORE_TURNS: u32 = 8;
const SUBMIT: &str = "submit.sh";

const TURN: &str = include_str!("slurm_turn.sh");

pub(super) fn files(job: &Job) -> Result<Vec<JobFile>, CliError> {
    let lines = lines(job)?;
    let threads = if job.threads.is_some() { "" } else { " --threads=\"${SLURM_CPUS_PER_TASK:-1}\"" };
    let (chunks, count) = chunks(job);
    let head = |what: &str| format!("#!/bin/sh\n# {what} submit.sh hands this to Slurm.\nset -u\n");
    let turn = |most: u32, line: &str| {
        TURN.replace("@MOST@", &most.to_string()).replace("@COMMAND@", &format!("{line}{threads}"))
    };
    let render = format!(
        "{}frames=$(sed -n \"$(($1 + SLURM_ARRAY_TASK_ID))p\" {CHUNKS})\n{}",
        head("The frames of a chunk."),
        turn(job.chunk + MORE_TURNS, &lines.render),
    );
    let again = format!(
        "{}# Whole frames of an earlier turn are not rendered twice.\n\
         [ \"${{SLURM_RESTART_COUNT:-0}}\" = 0 ] || {} || exit\n{}",
        head("Frames that are missing or damaged."),
        lines.validate,
        turn(
            u32::try_from(job.frames.len()).unwrap_or(u32::MAX - MORE_TURNS) + MORE_TURNS,
            &lines.render_again
        ),
    );
    let look = |what, line: &str| format!("{}exec {line}\n", head(what));
    Ok(vec![
        (CHUNKS.into(), chunks),
        ("render.sh".into(), render),
        ("validate.sh".into(), look("Which frames are missing or damaged.", &lines.validate)),
        ("renderagain.sh".into(), again),
        ("check.sh".into(), look("Whether the sequence is whole.", &lines.check)),
        (SUBMIT.into(), submit(job, count)),
    ])
}

pub(super) fn how_to_submit(job: &Job) -> String {
    let script = quoted(&format!("{}/{SUBMIT}", job.folder));
    format!("submit it by `sh {script}`; flags of sbatch may follow, such as --partition=NAME")
}

fn submit(job: &Job, count: usize) -> String {
    let Job { memory_mib, minutes, .. } = job;
    let name = quoted(&job.name.replace(char::is_control, " "));
    let arrays: Vec<String> = (0..count).step_by(MOST_TASKS).map(|first| {
        let last = (count - first).min(MOST_TASKS) - 1;
        format!(
            "step Render --array=0-{last} --output=logs/Render.%A_%a.txt --time={minutes} $limit \"$@\" render.sh {}\n\
             renders=$renders:$id\n",
            first + 1
        )
    }).collect();
    let cpus = job.threads.unwrap_or(1);
    // One task may have to render all that is left.
    format!(
        r#"#!/bin/sh
# Submits all steps. Flags given here are flags of sbatch for each, and win over those below.
set -eu
cd {folder}
mkdir -p logs
name={name}
limit=--signal=B:USR1@{NOTICE_S}
step() {{
    step=$1
    shift
    id=$(sbatch --parsable --job-name="$name: $step" --chdir="$PWD" --output="logs/$step.%j.txt" \
        --open-mode=append --requeue --mem={memory_mib}M --cpus-per-task={cpus} "$@")
    id=${{id%%;*}}
    ids="$ids $id"
}}
renders= ids=
# All steps or none.
trap '[ -z "$ids" ] || scancel $ids' EXIT
{arrays}# What a task of the array leaves undone is found and rendered.
step Validate --dependency="afterany$renders" --time={minutes} "$@" validate.sh
set -- --kill-on-invalid-dep=yes --time={minutes} "$@"
step RenderAgain --dependency="afterok:$id" $limit "$@" renderagain.sh
step Check --dependency="afterok:$id" "$@" check.sh
trap - EXIT
echo "submitted; follow it by squeue, end it by: scancel$ids"
echo "the sequence is whole if job $id ends well"
"#,
        folder = quoted(&job.folder),
        arrays = arrays.concat(),
    )
}
