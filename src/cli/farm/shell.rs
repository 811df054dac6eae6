//! Jobs for machines with a shared disk and no manager. In goes a job, out come a script for each machine and
//! one that ends the job. Invariant: a chunk is claimed by one machine; the last script renders what failed
//! machines left.

use super::super::CliError;
use super::JobFile;
use super::job::{FRAMES, Job, ranges};
use super::quoting::quoted;
use super::scripts::{CHUNKS, chunks, lines};

/// Default number of machines.
pub(super) const MACHINES: u32 = 2;
/// Maximum number of machines, as there is a script for each.
pub(super) const MOST_MACHINES: u32 = 1000;
const WORK: &str = include_str!("shell_work.sh");
const FINISH: &str = "finish.sh";

pub(super) fn files(job: &Job) -> Result<Vec<JobFile>, CliError> {
    let lines = lines(job)?;
    let folder = quoted(&job.folder);
    let (chunks, _) = chunks(job);
    let machine = |number: u32| {
        let script = WORK
            .replace("@FOLDER@", &folder)
            .replace("@MACHINE@", &number.to_string())
            .replace("@CHUNKS@", CHUNKS)
            .replace("@FINISH@", FINISH)
            .replace("@COMMAND@", &lines.render);
        (format!("machine-{number}.sh"), script)
    };
    let finish = format!(
        "#!/bin/sh\n# Once no machine renders any more: renders what is left, and says whether the sequence is \
         whole.\nset -eu\ncd {folder}\nmkdir -p {FRAMES}\nframes={frames}\n{}\n{}\n{}\n{}\nrm -rf claims\n",
        lines.render,
        lines.validate,
        lines.render_again,
        lines.check,
        frames = quoted(&ranges(&job.frames, Some('x'))),
    );
    let machines = (1..=job.machines.unwrap_or(MACHINES)).map(machine);
    Ok([(CHUNKS.into(), chunks), (FINISH.into(), finish)].into_iter().chain(machines).collect())
}

pub(super) fn how_to_submit(job: &Job) -> String {
    let lines = (1..=job.machines.unwrap_or(MACHINES)).map(|number| {
        let script = quoted(&format!("{}/machine-{number}.sh", job.folder));
        format!("  machine {number}: sh {script}\n")
    });
    let finish = quoted(&format!("{}/{FINISH}", job.folder));
    format!(
        "run a script on each machine:\n{}the last to end also validates; if a machine fails for good, \
         run `sh {finish}`",
        lines.collect::<String>()
    )
}
