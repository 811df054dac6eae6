//! Job bundles of Open Job Description (2023-09), for AWS Deadline Cloud and `openjd`. In goes a job, out
//! come the template and the list of files to transfer. Invariant: the template contains no path of this
//! machine; the manager maps the given ones.

use super::super::CliError;
use super::super::error::usage;
use super::job::{BAKES, FRAMES, Job, Names, Step, ranges};
use super::quoting::quoted;
use super::{FLAGS, JobFile};
use serde_json::{Value, json};

/// Maximum length of a parameter's value, and of a job's name.
const LONGEST_VALUE: usize = 1024;
const LONGEST_NAME: usize = 128;

const NAMES: Names<'static> = Names {
    input: "{{Param.Input}}",
    frames: "{{Param.Frames}}",
    chunk: "{{Task.Param.Frame}}",
    output: "{{Param.Output}}",
    bakes: "{{Param.Bakes}}",
    progress: "openjd",
};

pub(super) fn files(job: &Job) -> Result<Vec<JobFile>, CliError> {
    let outputs = json!([format!("{}/{FRAMES}", job.folder)]);
    let inputs = json!({ "filenames": job.files, "directories": [] });
    let references =
        json!({ "assetReferences": { "inputs": inputs, "outputs": { "directories": outputs } } });
    let values = json!({ "parameterValues": [{ "name": "Input", "value": job.input }] });
    let files = [
        ("template.json", template(job)?),
        ("parameter_values.json", values),
        ("asset_references.json", references),
    ];
    Ok(files.map(|(name, value)| (name.to_owned(), format!("{value:#}\n"))).into())
}

pub(super) fn how_to_submit(job: &Job) -> String {
    let Job { folder, input, .. } = job;
    format!(
        "submit it by `deadline bundle submit {}`, or run it here by\n\
         `openjd run {} --step Check --run-dependencies -p {}`",
        quoted(folder),
        quoted(&format!("{folder}/template.json")),
        quoted(&format!("Input={input}")),
    )
}

fn template(job: &Job) -> Result<Value, CliError> {
    let frames = ranges(&job.frames, Some(':'));
    if frames.len() > LONGEST_VALUE {
        let found = format!("the list has {} characters in its shortest form", frames.len());
        return Err(usage(
            "--frames",
            found,
            "at most 1024, which the format allows: several jobs of fewer ranges",
        ));
    }
    if let Some(flag) = job.flags.iter().find(|flag| flag.contains("{{")) {
        let found = format!("`{flag}` has the sign {{{{, by which the format knows its parameters");
        return Err(usage(FLAGS, found, "a name without it"));
    }
    let steps = job.steps(&NAMES);
    let before = [None].into_iter().chain(steps.iter().map(Some));
    let name = job.name.replace("{{", "{");
    let name: String = name.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
    Ok(json!({
        "specificationVersion": "jobtemplate-2023-09",
        "extensions": ["TASK_CHUNKING"],
        "name": name,
        "parameterDefinitions": parameters(job, &frames),
        "steps": steps.iter().zip(before).map(|(step, before)| as_json(job, step, before)).collect::<Vec<_>>(),
    }))
}

fn parameters(job: &Job, frames: &str) -> Value {
    let folder = |name, flow, default, description| {
        json!({
            "name": name, "type": "PATH", "objectType": "DIRECTORY", "dataFlow": flow, "default": default,
            "description": description,
        })
    };
    let text = |name, default, description| json!({ "name": name, "type": "STRING", "default": default, "description": description });
    json!([
        { "name": "Input", "type": "PATH", "objectType": "FILE", "dataFlow": "IN", "description": "What is rendered." },
        text("Frames", frames, "Frames, such as 1-48 or 1-47:2."),
        {
            "name": "ChunkSize", "type": "INT", "default": job.chunk, "minValue": 1, "maxValue": 150,
            "description": "Frames that a task renders.",
        },
        folder("Output", "OUT", FRAMES, "Where frames go."),
        folder("Bakes", "IN", BAKES, "Falls of leaves that are baked already."),
        text("Sunfleck", "sunfleck", "The program sunfleck, or a path to it."),
        text("Tools", "sunfleck-tools", "The program sunfleck-tools, or a path to it."),
    ])
}

fn as_json(job: &Job, step: &Step, before: Option<&Step>) -> Value {
    let command = if step.program == "sunfleck" { "{{Param.Sunfleck}}" } else { "{{Param.Tools}}" };
    // A signal first, so that finished frames are kept.
    let run = json!({
        "command": command, "args": step.arguments, "cancelation": { "mode": "NOTIFY_THEN_TERMINATE" },
    });
    let mut value = json!({
        "name": step.name,
        "hostRequirements": { "amounts": [
            { "name": "amount.worker.vcpu", "min": 1 },
            { "name": "amount.worker.memory", "min": job.memory_mib },
        ] },
        "script": { "actions": { "onRun": run } },
    });
    if step.is_chunked {
        let chunks = json!({ "defaultTaskCount": "{{Param.ChunkSize}}", "rangeConstraint": "NONCONTIGUOUS" });
        let frame =
            json!({ "name": "Frame", "type": "CHUNK[INT]", "range": "{{Param.Frames}}", "chunks": chunks });
        value["parameterSpace"] = json!({ "taskParameterDefinitions": [frame] });
    }
    if let Some(before) = before {
        value["dependencies"] = json!([{ "dependsOn": before.name }]);
    }
    value
}
