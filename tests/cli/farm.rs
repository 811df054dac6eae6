//! `farm`: what a manager is given. That jobs run, tools/tests/test_farm.py shows.

use crate::program::Studio;
use serde_json::Value;

fn json(studio: &Studio, name: &str) -> Value {
    serde_json::from_slice(&studio.bytes(name)).unwrap()
}

fn text(studio: &Studio, name: &str) -> String {
    String::from_utf8(studio.bytes(name)).unwrap()
}

#[test]
fn a_bundle_names_no_path_of_this_machine_but_where_it_says_so() {
    let studio = Studio::new();
    studio.succeed("farm tiny.ron --out job --frames 1-9x2,12 --chunk 3 -- --samples 1");
    let here = studio.path("").canonicalize().unwrap();
    let template = text(&studio, "job/template.json");
    assert!(!template.contains(here.to_str().unwrap()), "{template}");
    let template = json(&studio, "job/template.json");
    assert_eq!(template["extensions"], serde_json::json!(["TASK_CHUNKING"]));
    assert_eq!(template["parameterDefinitions"][1]["default"], "1-9:2,12");
    assert_eq!(template["parameterDefinitions"][2]["default"], 3);
    let steps = template["steps"].as_array().unwrap();
    let names: Vec<&str> = steps.iter().map(|step| step["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["Render", "Validate", "RenderAgain", "Check"]);
    for (step, before) in steps[1..].iter().zip(names) {
        assert_eq!(step["dependencies"][0]["dependsOn"], before);
    }
    assert_eq!(steps[0]["parameterSpace"]["taskParameterDefinitions"][0]["type"], "CHUNK[INT]");
    let last = |step: &Value| step["script"]["actions"]["onRun"]["args"].as_array().unwrap().last().cloned();
    assert_eq!(last(&steps[0]), Some("1".into()));
    assert_eq!(last(&steps[2]), Some("1".into()));
    let input = &json(&studio, "job/parameter_values.json")["parameterValues"][0];
    assert!(input["value"].as_str().unwrap().ends_with("tiny.ron"), "{input}");
}

#[test]
fn every_file_that_is_read_goes_along() {
    let studio = Studio::new();
    std::fs::create_dir(studio.path("parts")).unwrap();
    std::fs::write(studio.path("parts/leaf.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let scene = text(&studio, "scene.ron")
        .replace("Leaf(length_m: 0.8, width_m: 0.5, curl_deg: 30.0)", "Obj(\"parts/leaf.obj\")");
    std::fs::write(studio.path("scene.ron"), scene).unwrap();
    let told = studio.succeed("inspect tiny.ron --dependencies").out;
    let told: Vec<&str> = told.lines().collect();
    assert_eq!(told.len(), 3, "{told:?}");
    for (path, name) in told.iter().zip(["tiny.ron", "scene.ron", "parts/leaf.obj"]) {
        assert!(path.ends_with(name) && std::path::Path::new(path).is_absolute(), "{path}");
    }
    studio.succeed("farm tiny.ron --out job");
    let references = json(&studio, "job/asset_references.json");
    assert_eq!(references["assetReferences"]["inputs"]["filenames"], serde_json::json!(told));
}

#[test]
fn flamenco_gets_a_job_type_and_a_job() {
    let studio = Studio::new();
    studio.succeed("farm tiny.ron --out job --profile flamenco --frames 1-5x2");
    assert_eq!(studio.names("job"), ["bakes", "job.json", "sunfleck.js"]);
    let job = json(&studio, "job/job.json");
    assert_eq!(job["settings"]["frames"], "1,3,5");
    let steps: Value = serde_json::from_str(job["settings"]["steps"].as_str().unwrap()).unwrap();
    assert_eq!(steps[0]["exe"], "{sunfleck}");
    assert_eq!(steps[0]["args"][2], "--frames=<chunk>");
}

#[test]
fn deadline_renders_no_frame_that_is_not_asked_for() {
    let studio = Studio::new();
    studio.succeed("farm tiny.ron --out job --profile deadline --chunk 4");
    let render = text(&studio, "job/render.job");
    assert!(render.contains("\nFrames=1-12\nChunkSize=4\n"), "{render}");
    let plugin = text(&studio, "job/render.plugin");
    assert!(plugin.contains("<QUOTE>--frames=<STARTFRAME>-<ENDFRAME><QUOTE>"), "{plugin}");
    assert_eq!(studio.names("job").len(), 9);
    // Between first and last there would be others.
    studio.succeed("farm tiny.ron --out job --profile deadline --chunk 4 --frames 1-9x2");
    let render = text(&studio, "job/render.job");
    assert!(render.contains("\nFrames=1-9x2\nChunkSize=1\n"), "{render}");
}

#[test]
fn slurm_gets_an_array_and_three_steps_that_wait() {
    let studio = Studio::new();
    studio.succeed("farm tiny.ron --out job --profile slurm --chunk 5 -- --threads 2");
    let names =
        ["bakes", "check.sh", "chunks.txt", "render.sh", "renderagain.sh", "submit.sh", "validate.sh"];
    assert_eq!(studio.names("job"), names);
    assert_eq!(text(&studio, "job/chunks.txt"), "1-5\n6-10\n11-12\n");
    let submit = text(&studio, "job/submit.sh");
    for part in ["--array=0-2", "--cpus-per-task=2", "--requeue", "--signal=B:USR1@", "afterany$renders"] {
        assert!(submit.contains(part), "{part}\n{submit}");
    }
    assert!(text(&studio, "job/render.sh").contains("--frames=\"${frames}\""));
}

#[test]
fn long_jobs_are_several_arrays() {
    let studio = Studio::new();
    let scene = text(&studio, "tiny.ron").replace("frames: (1, 12)", "frames: (1, 2500)");
    std::fs::write(studio.path("tiny.ron"), scene).unwrap();
    studio.succeed("farm tiny.ron --out job --profile slurm --chunk 1");
    let submit = text(&studio, "job/submit.sh");
    for part in ["--array=0-999 ", "render.sh 1\n", "render.sh 1001\n", "--array=0-499 ", "render.sh 2001\n"]
    {
        assert!(submit.contains(part), "{part}\n{submit}");
    }
}

#[test]
fn a_chunk_is_chosen_and_said() {
    let studio = Studio::new();
    // Starting takes less than a frame, of which each machine has one.
    let told = studio.succeed("farm tiny.ron --out a --chunk auto --machines 12 --frame-seconds 60").out;
    assert!(told.contains("in tasks of 1,"), "{told}");
    assert!(told.contains("chunk 1 gives most") && told.contains("a frame takes 60.000 s\n"), "{told}");
    // Starting takes much longer than all frames.
    let told = studio.succeed("farm tiny.ron --out b --chunk auto --machines 2 --frame-seconds 0.01").out;
    assert!(told.contains("in tasks of 6,"), "{told}");
    let told = studio.succeed("farm tiny.ron --out c --profile shell --chunk auto").out;
    assert!(told.contains("on 2 machines") && told.contains("an estimate: see --frame-seconds"), "{told}");
}

#[test]
fn a_task_has_three_times_what_its_frames_take() {
    let studio = Studio::new();
    studio.succeed("farm tiny.ron --out job --profile slurm --chunk 4 --frame-seconds 600");
    assert!(text(&studio, "job/submit.sh").contains("--time=120 "));
}

#[test]
fn commands_are_quoted_for_a_shell() {
    let studio = Studio::new();
    std::fs::rename(studio.path("tiny.ron"), studio.path("it's.ron")).unwrap();
    for profile in ["openjd", "flamenco", "deadline", "slurm", "shell"] {
        let told = studio.succeed(&format!("farm it's.ron --out a&job's --profile {profile}")).out;
        assert!(told.contains(r"a&job'\''s"), "{profile}: {told}");
        assert!(!told.contains("\"/"), "{profile}: {told}");
    }
}

#[test]
fn what_cannot_be_a_job_is_refused_and_leaves_no_file() {
    let studio = Studio::new();
    std::fs::write(studio.path("taken"), "").unwrap();
    for (line, code, word) in [
        ("farm none.ron --out job", 4, "none.ron"),
        ("farm tiny.ron --out taken", 4, "taken"),
        ("farm tiny.ron", 2, "--out"),
        ("farm tiny.ron --out job --chunk 0", 2, "--chunk"),
        ("farm tiny.ron --out job --chunk 151", 2, "--chunk"),
        ("farm tiny.ron --out job --frames none", 2, "--frames"),
        ("farm tiny.ron --out job --frames 1-99", 2, "frame 13"),
        ("farm tiny.ron --out job --profile sleep", 2, "--profile"),
        ("farm tiny.ron --out job --machines 3", 2, "--machines"),
        ("farm tiny.ron --out job --profile shell --machines 0", 2, "--machines"),
        ("farm tiny.ron --out job --profile shell --machines 1001", 2, "--machines"),
        ("farm tiny.ron --out job --chunk auto", 2, "--machines"),
        ("farm tiny.ron --out job --chunk automatic", 2, "--chunk"),
        ("farm tiny.ron --out job --frame-seconds 9", 2, "--frame-seconds"),
        ("farm tiny.ron --out job --chunk auto --machines 3 --frame-seconds 0", 2, "--frame-seconds"),
        ("farm tiny.ron --out job -- --live localhost", 2, "--live localhost"),
        ("farm tiny.ron --out job -- --stats took.jsonl", 2, "--stats took.jsonl"),
        ("farm tiny.ron --out job -- --out elsewhere", 2, "--out"),
        ("farm tiny.ron --out job -- --frames 1", 2, "--frames"),
        ("farm tiny.ron --out job -- --dry-run", 2, "--dry-run"),
        ("farm tiny.ron --out job -- --camera nobody", 2, "nobody"),
        ("farm tiny.ron --out job -- --sample 4", 2, "--sample"),
    ] {
        let message = studio.fail(line, code);
        assert!(message.contains(word), "{line}\n{message}");
        assert!(studio.names("job").iter().all(|name| name == "bakes"), "{line}");
    }
}

#[test]
fn frames_can_be_listed_in_a_file() {
    let studio = Studio::new();
    std::fs::write(studio.path("missing.txt"), "2,5-6\n").unwrap();
    studio.succeed("render tiny.ron --frames @missing.txt --out a/");
    assert_eq!(studio.names("a"), ["tiny.0002.exr", "tiny.0005.exr", "tiny.0006.exr"]);
    std::fs::write(studio.path("missing.txt"), "none\n").unwrap();
    studio.succeed("render tiny.ron --frames @missing.txt --out b/");
    assert!(studio.names("b").is_empty());
    let message = studio.fail("render tiny.ron --frames @nowhere.txt --out b/", 4);
    assert!(message.contains("nowhere.txt") && message.contains("--frames"), "{message}");
}

#[test]
fn a_manager_is_told_why_a_task_failed() {
    let studio = Studio::new();
    let outcome = studio.run("render tiny.ron --frames 1-99 --out a/ --progress openjd");
    assert_eq!(outcome.code, 2);
    let line = outcome.out.lines().find(|line| line.starts_with("openjd_fail: ")).unwrap();
    assert!(line.contains("frame 13 is not part of the sequence; expected: frames from 1 to 12"), "{line}");
}
