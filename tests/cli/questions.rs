//! What the program answers without rendering: `inspect`, `diff`, `completions`, `--help`.

use crate::checkout;
use crate::program::Studio;
use crate::schema::violations;
use serde_json::Value;
use std::process::Stdio;

#[test]
fn inspect_tells_people_what_an_input_holds() {
    let answer = Studio::new().succeed("inspect tiny.ron").out;
    for part in [
        "tiny.ron: `tiny`",
        "1 to 12 at 24 a second; frame 1 is 0.041667 s, frame 12 is 0.500000 s",
        "32 x 18, 2 samples a pixel, filter box, seed 0, beauty alone",
        "2 meshes placed 2 times",
        "camera   `main`",
        "sun      `sun`",
        "fog      `haze`",
        "everything that the input asks for is honoured",
    ] {
        assert!(answer.contains(part), "`{part}` is not in\n{answer}");
    }
}

#[test]
fn an_answer_that_nobody_reads_on_is_no_failure_and_one_that_finds_no_room_is() {
    let studio = Studio::new();
    for line in ["inspect tiny.ron --json", "completions bash"] {
        let mut program = studio.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(program.stdout.take());
        let left = program.wait_with_output().unwrap();
        assert_eq!((left.status.code(), left.stderr.as_slice()), (Some(0), &b""[..]), "{line}");
        #[cfg(target_os = "linux")]
        {
            let full = std::fs::File::create("/dev/full").unwrap();
            let left = studio.command(line).stdout(full).output().unwrap();
            let message = String::from_utf8_lossy(&left.stderr);
            assert_eq!(left.status.code(), Some(4), "{line}: {message}");
            assert!(message.contains("cannot be written"), "{line}: {message}");
        }
    }
}

#[test]
fn who_names_samples_or_a_tolerance_has_said_both() {
    let studio = Studio::new();
    let sequence = r#"Sequence(version: 1, scene: "scene.ron", tolerance: 0.1, samples: 64)"#;
    std::fs::write(studio.path("good.ron"), sequence).unwrap();
    for (line, part) in [
        ("scene.ron", "to a relative error of 0.02 by at most 1024 samples a pixel"),
        ("good.ron", "to a relative error of 0.1 by at most 64 samples a pixel"),
        ("good.ron --samples 8", ", 8 samples a pixel"),
        ("good.ron --tolerance 0.3", "to a relative error of 0.3 by at most 1024 samples a pixel"),
        ("tiny.ron --tolerance 0.3 --samples 9", "to a relative error of 0.3 by at most 9 samples a pixel"),
    ] {
        let answer = studio.succeed(&format!("render --dry-run {line}")).out;
        assert!(answer.contains(part), "{line}: `{part}` is not in\n{answer}");
    }
    let answer = studio.succeed("inspect good.ron --json").out;
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!((&answer["tolerance"], &answer["samples"]), (&0.1.into(), &64.into()));
}

#[test]
fn who_names_a_filter_gets_it() {
    let studio = Studio::new();
    let sequence = r#"Sequence(version: 1, scene: "scene.ron", filter: BlackmanHarris)"#;
    std::fs::write(studio.path("soft.ron"), sequence).unwrap();
    for (line, part) in [
        ("scene.ron", ", --filter box,"),
        ("soft.ron", ", --filter blackman-harris,"),
        ("soft.ron --filter box", ", --filter box,"),
        ("scene.ron --filter blackman-harris", ", --filter blackman-harris,"),
    ] {
        let answer = studio.succeed(&format!("render --dry-run {line}")).out;
        assert!(answer.contains(part), "{line}: `{part}` is not in\n{answer}");
    }
    let answer = studio.succeed("inspect soft.ron --json").out;
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["filter"], "blackman-harris");
}

#[test]
fn inspect_answers_programs_at_any_frame() {
    let ranges = Studio::new().succeed("inspect tiny.ron --json --frames 2-6x2,12.5").out;
    let ranges: Value = serde_json::from_str(&ranges).unwrap();
    let ranges = ranges["frames"].as_array().unwrap().iter().map(|each| each["frame"].as_f64().unwrap());
    assert_eq!(ranges.collect::<Vec<_>>(), [2.0, 4.0, 6.0, 12.5]);
    let answer = Studio::new().succeed("inspect tiny.ron --json --frames 1,12.5").out;
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(answer["frame_rate"], serde_json::json!([24, 1]));
    let frames = answer["frames"].as_array().unwrap();
    let seconds: Vec<_> = frames.iter().map(|frame| frame["seconds"].as_f64().unwrap()).collect();
    assert_eq!(seconds, [1.0 / 24.0, 12.5 / 24.0]);
    let leaf = |frame: &Value| frame["nodes"]["leaf"]["world"].clone();
    assert_ne!(leaf(&frames[0]), leaf(&frames[1]), "the leaf turns");
    assert_eq!(leaf(&frames[0]).as_array().unwrap().len(), 16);
}

#[test]
fn answers_to_programs_are_as_their_schema_says() {
    let schema = std::fs::read_to_string(checkout::file("docs/inspect.schema.json")).unwrap();
    let schema: Value = serde_json::from_str(&schema).unwrap();
    let studio = Studio::new();
    let mut described = std::collections::BTreeSet::new();
    for input in [
        "tiny.ron",
        "checkout:tests/data/valid/ron/everything.ron",
        "checkout:tests/data/blender/i_conventions.glb",
        "checkout:tests/data/blender/h_cameras.glb",
    ] {
        let answer = studio.succeed(&format!("inspect {input} --json --frames 1,1.5")).out;
        let answer: Value = serde_json::from_str(&answer).unwrap();
        assert_eq!(violations(&schema, &answer), Vec::<String>::new(), "{input}");
        for kind in ["cameras", "lights"] {
            for thing in answer["frames"][0][kind].as_object().unwrap().values() {
                described.extend(thing.as_object().unwrap().keys().map(|field| format!("{kind}.{field}")));
            }
        }
        // The check can fail.
        let mut wrong = answer.clone();
        wrong["frames"][1]["seconds"] = "late".into();
        wrong["frames"][0]["nodes"]["extra"] = serde_json::json!({ "visible": true });
        wrong["unknown"] = 1.into();
        assert_eq!(violations(&schema, &wrong).len(), 3, "{input}");
    }
    for kind in ["camera", "light"] {
        for field in schema["$defs"][kind]["properties"].as_object().unwrap().keys() {
            assert!(described.contains(&format!("{kind}s.{field}")), "no {kind} has {field}");
        }
    }
}

#[test]
fn namesakes_have_keys_of_their_own() {
    let answer = Studio::new().succeed("inspect checkout:tests/data/blender/e_inst_default.glb --json").out;
    let answer: Value = serde_json::from_str(&answer).unwrap();
    let nodes = answer["frames"][0]["nodes"].as_object().unwrap();
    let namesakes = nodes.keys().filter(|name| name.contains('#')).count();
    assert!(namesakes > 0, "{:?}", nodes.keys());
    assert!(nodes.keys().all(|name| name.split_once('#').is_none_or(|(first, _)| nodes.contains_key(first))));
}

#[test]
fn inspect_says_what_is_not_honoured() {
    let answer = Studio::new().succeed("inspect checkout:tests/data/blender/b_leafcards.glb").out;
    assert!(answer.contains("warning[backface-culling]: backface culling is not honoured"), "{answer}");
    assert!(answer.contains("note: masked meshes are cut out along alpha = cutoff"), "{answer}");
    assert!(answer.contains("give --fps"), "{answer}");
}

/// Whatever a remedy tells people to give to `render` may be asked about first.
#[test]
fn inspect_takes_the_flags_of_render() {
    let studio = Studio::new();
    let line = "inspect tiny.ron --json --fps 24000/1001 --size 50% --tolerance 0.1 --camera low";
    let described: Value = serde_json::from_str(&studio.succeed(line).out).unwrap();
    assert_eq!(described["frame_rate"], serde_json::json!([24000, 1001]));
    assert_eq!(described["size"], serde_json::json!([16, 9]));
    assert_eq!(described["tolerance"], 0.1);
    assert_eq!(described["frames"][0]["camera"]["name"], "low");
    assert!(studio.fail("inspect tiny.ron --camera none", 2).contains("remedy: "));
}

#[test]
fn diff_measures_how_far_frames_are_apart() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --out a.exr");
    studio.succeed("render tiny.ron --frames 1 --seed 9 --out b.exr");
    let same = studio.succeed("diff a.exr a.exr").out;
    let other = studio.succeed("diff a.exr b.exr").out;
    assert_ne!(same, other);
    studio.succeed("render tiny.ron --frames 1 --size 8x4 --out c.exr");
    let refusal = studio.fail("diff a.exr c.exr", 3);
    assert!(refusal.contains("a.exr") && refusal.contains("remedy: "), "{refusal}");
}

#[test]
fn diff_of_folders_has_a_line_for_every_number() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1-3 --samples 1 --out a/");
    studio.succeed("render tiny.ron --frames 2-4 --samples 1 --out b/");
    let found = studio.run("diff a b --max-error 0 --picture d/");
    let lines: Vec<&str> = found.out.lines().collect();
    assert_eq!((found.code, lines.len()), (5, 4), "{}", found.err);
    assert!(lines[0].starts_with("frame 1: b has no such frame"), "{}", lines[0]);
    assert!(lines[1].starts_with("frame 2: RGB  mean ratio 1.000000"), "{}", lines[1]);
    assert!(lines[3].starts_with("frame 4: a has no such frame"), "{}", lines[3]);
    assert!(found.err.contains("2 of 4 frames"), "{}", found.err);
    assert_eq!(studio.names("d"), ["difference.0002.png", "difference.0003.png"]);
    studio.succeed("diff a a --max-error 0");
    std::fs::copy(studio.path("a/tiny.0001.exr"), studio.path("b/tiny.0002.exr")).unwrap();
    let found = studio.run("diff b a --max-error 1e-9 --max-relmse 1e30");
    assert!(found.out.contains("; too much: largest difference"), "{}", found.out);
    assert!(studio.fail("diff a a/tiny.0001.exr", 2).contains("is a file"));
    std::fs::create_dir(studio.path("none")).unwrap();
    assert!(studio.fail("diff a none", 2).contains("no frame in none"));
    // What `render` writes by default lies a folder deeper.
    assert!(studio.fail("preview .", 2).contains("there are some in ./a\n"));
}

#[test]
fn diff_shows_where_frames_differ() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --samples 1 --out a.exr");
    studio.succeed("render tiny.ron --frames 1 --samples 1 --crop 1,1,9,5 --out b.exr");
    studio.succeed("diff b.exr a.exr --picture d.png --white 1 --exposure 0");
    let picture = image::open(studio.path("d.png")).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (3 * 8 + 2 * 4, 4));
    assert!((0..4).all(|y| (24..32).all(|x| picture.get_pixel(x, y).0 == [0; 3])), "they do not differ");
    let alike = |x: u32, y: u32| picture.get_pixel(x, y) == picture.get_pixel(x + 12, y);
    assert!((0..4).all(|y| (0..8).all(|x| alike(x, y))), "shown alike");
    assert!(studio.fail("diff a.exr a.exr --picture d.png --white 0", 2).contains("above 0"));
}

#[test]
fn diff_keeps_limits_of_all_channels_and_of_single_ones() {
    let studio = Studio::new();
    let render = "render tiny.ron --frames 1 --passes depth,leaf-id,albedo";
    studio.succeed(&format!("{render} --out a.exr"));
    studio.succeed(&format!("{render} --seed 9 --out b.exr"));
    for (limits, is_kept) in [
        ("--max-rmse 1e-9 --max-relmse 1e-9 --max-error 1e-9 --max-ids 0", false),
        ("--max-rmse 1e30 --max-relmse 1e30 --max-error 1e30 --max-ids 1", true),
        ("--max-error 1e9 --max-error [RG]=1e-9", false),
        ("--max-error 1e-9 --max-error *=inf", false),
        ("--max-error *=1e-9 --max-error *=1e30", true),
        ("--max-ids leaf_id.*=1", true),
        ("--max-rmse diffuse.*=1", false),
    ] {
        let same = studio.run(&format!("diff a.exr a.exr {limits}"));
        assert_eq!(same.code, if limits.contains("diffuse") { 5 } else { 0 }, "{limits}: {}", same.err);
        let other = studio.run(&format!("diff a.exr b.exr {limits}"));
        assert_eq!(other.code, if is_kept { 0 } else { 5 }, "{limits}: {}", other.err);
        let is_said =
            ["a.exr", "error: ", "expected: ", "remedy: "].iter().all(|part| other.err.contains(part));
        assert!(is_kept || is_said, "{}", other.err);
        assert!(other.out.contains("RGB") && other.out.contains("leaf_id"), "{}", other.out);
    }
    for limit in ["--max-rmse -1", "--max-error inf", "--max-error x=-1", "--max-ids 2", "--max-rmse a[=1"] {
        studio.fail(&format!("diff a.exr b.exr {limit}"), 2);
    }
}

#[test]
fn shells_get_completions() {
    let studio = Studio::new();
    for shell in ["bash", "zsh", "fish"] {
        let script = studio.succeed(&format!("completions {shell}")).out;
        assert!(script.contains("volume-steps"), "{shell}");
    }
}

#[test]
fn help_and_version_are_answers() {
    let studio = Studio::new();
    assert!(studio.succeed("render --help").out.contains("--frames"));
    assert_eq!(studio.succeed("--version").out.trim(), concat!("sunfleck ", env!("CARGO_PKG_VERSION")));
}
