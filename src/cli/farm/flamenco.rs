//! Jobs of Flamenco 3. In goes a job, out come its job type, the same for all jobs, and the request to the
//! Manager. Invariant: every path is a setting of its own, so that two-way variables apply.

use super::super::CliError;
use super::super::error::usage;
use super::JobFile;
use super::job::{BAKES, FRAMES, Job, Names, ranges};
use super::quoting::quoted;
use serde_json::json;

/// Placeholders that `flamenco.js` replaces by settings.
const NAMES: Names<'static> = Names {
    input: "<input>",
    frames: "<frames>",
    chunk: "<chunk>",
    output: "<output>",
    bakes: "<bakes>",
    progress: "plain",
};

pub(super) fn files(job: &Job) -> Result<Vec<JobFile>, CliError> {
    if job.frames[0] < 0 {
        return Err(usage(
            "--frames",
            format!("there is frame {}", job.frames[0]),
            "frames from 0 on, for Flamenco",
        ));
    }
    let steps = job.steps(&NAMES).map(|step| {
        // Workers find programs by variables of these names.
        let program = format!("{{{}}}", step.program);
        json!({ "name": step.name, "exe": program, "args": step.arguments, "is_chunked": step.is_chunked })
    });
    let submission = json!({
        "name": job.name,
        "type": "sunfleck",
        "priority": 50,
        "submitter_platform": if cfg!(target_os = "macos") { "darwin" } else { std::env::consts::OS },
        "settings": {
            "input": job.input,
            "frames": ranges(&job.frames, None),
            "chunk_size": job.chunk,
            "output": format!("{}/{FRAMES}", job.folder),
            "bakes": format!("{}/{BAKES}", job.folder),
            "steps": json!(steps).to_string(),
        },
        "metadata": { "files": job.files.join("\n") },
    });
    Ok(vec![
        ("sunfleck.js".to_owned(), include_str!("flamenco.js").to_owned()),
        ("job.json".to_owned(), format!("{submission:#}\n")),
    ])
}

pub(super) fn how_to_submit(job: &Job) -> String {
    format!(
        "copy sunfleck.js to the Manager's folder `scripts` once, then\n\
         `curl -H 'Content-Type: application/json' -d {} http://MANAGER:8080/api/v3/jobs`",
        quoted(&format!("@{}/job.json", job.folder))
    )
}
