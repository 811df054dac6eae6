//! What goes wrong around the program: streams that take nothing, files that are none, outputs that would be
//! lost, viewers that do not read. Frames are written, and the exit code is the right one.
#![cfg(unix)]

use crate::checkout;
use crate::program::{Studio, outcome};
use std::ffi::OsStr;
use std::net::TcpListener;
use std::os::unix::ffi::OsStrExt;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const USAGE: i32 = 2;
const SCENE: i32 = 3;
const INPUT_OUTPUT: i32 = 4;

/// Names of files are bytes; some have none of a text's meaning.
#[test]
fn bytes_of_names_that_are_no_text_are_kept() {
    let studio = Studio::new();
    let name = |bytes: &[u8]| studio.path("").join(OsStr::from_bytes(bytes));
    std::fs::create_dir(name(b"in\xff")).unwrap();
    std::fs::write(name(b"in\xff/s.ron"), studio.bytes("scene.ron")).unwrap();
    let render = "render tiny.ron --frames 1 --size 8x4 --samples 1 --preview png";
    for (line, last, written) in [
        (&format!("{render} --out")[..], &b"x\xff/f\xfe.####.exr"[..], &b"x\xff/f\xfe.0001.exr"[..]),
        (&format!("{render} --skip exists --out"), b"x\xff/f\xfe.####.exr", b"x\xff/f\xfe.0001.png"),
        (&format!("{render} --out"), b"folder\xff/", b"folder\xff/tiny.0001.exr"),
        (&format!("{render} --out a/ --stats"), b"s\xff.jsonl", b"s\xff.jsonl"),
        ("export tiny.ron", b"e\xff.glb", b"e\xff.glb"),
        ("preview tiny.ron --frames 1-2 --size 8x4 --out", b"p\xff.#.png", b"p\xff.2.png"),
        ("preview tiny.ron --frames 1-2 --size 8x4 --out", b"sheet\xff.png", b"sheet\xff.png"),
        ("preview tiny.ron --frames 1-2 --size 8x4 --out", b"play\xff.webp", b"play\xff.webp"),
        ("inspect", b"in\xff/s.ron", b"in\xff/s.ron"),
        ("preview --out q.png", b"x\xff", b"q.png"),
    ] {
        let outcome = outcome(studio.command(line).arg(OsStr::from_bytes(last)).output().unwrap());
        assert_eq!(outcome.code, 0, "{line}: {}", outcome.err);
        assert!(name(written).is_file(), "{line}: {}", outcome.err);
        assert!(!outcome.err.contains('\u{fffd}'), "{line}: {}", outcome.err);
    }
    let refusal = studio.command("export tiny.ron").arg(OsStr::from_bytes(b"e\xff.gltf")).output().unwrap();
    assert!(String::from_utf8(refusal.stderr).unwrap().contains("`e\\xff.gltf`"));
}

/// Exit code of a line of the shell in the studio's folder.
fn shell(studio: &Studio, line: &str) -> i32 {
    studio.shell(line).status().unwrap().code().unwrap()
}

#[test]
fn frames_are_written_whatever_becomes_of_the_streams() {
    let studio = Studio::new();
    // It has warnings to tell.
    std::fs::copy(checkout::file("tests/data/blender/b_leafcards.glb"), studio.path("cards.glb")).unwrap();
    let render = "sunfleck render cards.glb --frames 1 --size 8x4 --samples 1";
    let streams =
        ["2>&-", "2>/dev/full", "2>&1 >/dev/null | true", ">&-", ">/dev/full", "--progress jsonl >/dev/full"];
    for (index, streams) in streams.iter().enumerate() {
        let status = if streams.contains('|') { "; test -e stopped || exit 0" } else { "" };
        assert_eq!(shell(&studio, &format!("{render} --out {index}/ {streams}{status}")), 0, "{streams}");
        assert!(studio.frame(&format!("{index}/cards.0001.exr")).is_intact(), "{streams}");
    }
}

#[test]
fn pipes_and_devices_are_no_files() {
    let studio = Studio::new();
    assert_eq!(shell(&studio, "mkfifo pipe.ron pipe.glb pipe.png"), 0);
    std::fs::write(
        studio.path("textured.ron"),
        r#"Scene(version: 1, meshes: {"q": Quad(size_m: 1.0)}, materials: {"m": (texture: "pipe.png")},
            objects: {"q": (mesh: "q", material: "m")}, cameras: {"c": (position_m: (0, 1, 0), look_at_m: (0, 0, 0.1))},
            lights: {"s": Sun(to_sun: (0, 1, 0), irradiance_w_per_m2: 1)})"#,
    )
    .unwrap();
    for input in ["pipe.ron", "pipe.glb"] {
        let message = studio.fail(&format!("render {input} --out a/"), INPUT_OUTPUT);
        assert!(message.contains("pipe or a device"), "{message}");
    }
    // A texture may be missing; the program must not wait for it.
    let message = studio.run("render textured.ron --frames 1 --size 8x4 --samples 1 --out a/").err;
    assert!(message.contains("pipe or a device"), "{message}");
    std::fs::create_dir(studio.path("frames")).unwrap();
    assert_eq!(shell(&studio, "mkfifo frames/x.0001.exr"), 0);
    studio.fail("preview frames --out b/", INPUT_OUTPUT);
    let kept = studio.run("render tiny.ron --frames 1 --out frames/x.####.exr --skip valid");
    assert_eq!(kept.code, 0, "{}", kept.err);
}

#[test]
fn what_is_read_is_not_written_over() {
    let studio = Studio::new();
    studio.succeed("export tiny.ron own.glb");
    studio.succeed("render tiny.ron --frames 1 --size 8x4 --bounces 0 --out sky.exr");
    std::fs::write(
        studio.path("under.ron"),
        r#"Scene(version: 1, cameras: {"c": (position_m: (0, 1, 0), look_at_m: (0, 0, 0.1))},
            sky: Image(image: "sky.exr"))"#,
    )
    .unwrap();
    std::fs::write(
        studio.path("leaf.obj"),
        "mtllib leaf.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl leaf\nf 1/1 2/2 3/3\n",
    )
    .unwrap();
    std::fs::write(studio.path("leaf.mtl"), "newmtl leaf\nmap_Kd leaf.png\n").unwrap();
    studio.succeed("preview tiny.ron --frames 1 --size 8x4 --out leaf.png");
    let files = ["scene.ron", "own.glb", "sky.exr", "leaf.png"];
    let before = files.map(|file| studio.bytes(file));
    for line in [
        "render under.ron --frames 1 --out ./sky.exr",
        "preview leaf.obj --out leaf.png",
        "render leaf.obj --frames 1 --out leaf.exr --preview png",
        "render tiny.ron --out a/ --stats scene.ron",
        "render tiny.ron --out a/ --stats ./tiny.ron",
        "export own.glb own.glb",
        "bench tiny.ron --csv scene.ron",
    ] {
        let message = studio.fail(line, USAGE);
        assert!(
            message.contains("is read by this very command") && message.contains("remedy: "),
            "{line}: {message}"
        );
    }
    for line in [
        "render tiny.ron --frames 1 --out y.exr --stats ./y.exr",
        "render tiny.ron --frames 1-2 --out w/y.####.exr --preview png --stats w/y.0002.png",
    ] {
        let message = studio.fail(line, USAGE);
        assert!(
            message.contains("is a frame of this run") && message.contains("remedy: "),
            "{line}: {message}"
        );
    }
    assert!(before == files.map(|file| studio.bytes(file)));
}

#[test]
fn a_frame_with_any_bit_flipped_is_rendered_again() {
    let studio = Studio::new();
    let render = "render tiny.ron --frames 1 --size 8x4 --out a/ --skip valid --progress jsonl";
    studio.succeed(render);
    let good = studio.bytes("a/tiny.0001.exr");
    assert!(studio.succeed(render).out.contains("frame_skipped"));
    // Bits all over the header, one of the pixels, and a byte too many.
    let flipped = (8..1200.min(good.len())).step_by(97).chain([good.len() - 3]).map(|at| {
        let mut bytes = good.clone();
        bytes[at] ^= 1 << (at % 8);
        bytes
    });
    for (number, damaged) in flipped.chain([[good.clone(), vec![0]].concat()]).enumerate() {
        std::fs::write(studio.path("a/tiny.0001.exr"), &damaged).unwrap();
        assert!(studio.succeed(render).out.contains("frame_written"), "damage {number} is kept");
        assert!(studio.bytes("a/tiny.0001.exr") == good);
    }
}

#[test]
fn numbers_that_would_never_end_are_refused() {
    let studio = Studio::new();
    let write = |name: &str, text: &str| std::fs::write(studio.path(name), text).unwrap();
    write("steps.ron", r#"Sequence(version: 1, scene: "scene.ron", march: (depth_m: 10, step_m: 1e-15))"#);
    write("far.obj", "v 3e38 0 0\nv 1 0 0\nv 0 1 1\nf 1 2 3\n");
    let far =
        |at: usize| format!("\"o{at}\": (mesh: \"a\", rotation_deg: ({at}, 35, 50), scale: {}),", at + 1);
    let rest = r#"cameras: {"m": (position_m: (0, 0, 5))}, lights: {"s": Sun(to_sun: (0, 1, 1), irradiance_w_per_m2: 1)})"#;
    let objects: String = (0..6).map(far).collect();
    write(
        "far.ron",
        &format!("Scene(version: 1, meshes: {{\"a\": Obj(\"far.obj\")}}, objects: {{{objects}}}, {rest}"),
    );
    let fall = r#"meshes: {"leaf": Leaf(length_m: 1e-9, width_m: 0.05)}, objects: {}, cameras: {"main": ()},
        fall: {"autumn": (count: 3, species: [(meshes: ["leaf"], length_m: 0.08)],
            emitter: Box(min_m: (-1, 2, -1), max_m: (1, 3, 1)))})"#;
    write("wide.ron", &format!("Scene(version: 1, {fall}"));
    for (input, expected) in [
        ("steps.ron", "march.step_m"),
        ("far.ron", "mesh `"),
        ("wide.ron", "fall.autumn.species[0].meshes[0]"),
    ] {
        let message = studio.fail(&format!("render {input} --size 8x4 --samples 1 --out a/"), SCENE);
        assert!(message.contains(expected) && message.contains("remedy: "), "{input}: {message}");
    }
}

/// A viewer that takes the connection and never reads; by the name whose first address is often another.
#[test]
fn a_viewer_that_does_not_read_holds_nothing_up() {
    let studio = Studio::new();
    let viewer = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = viewer.local_addr().unwrap().port();
    let started = Instant::now();
    let render =
        format!("render tiny.ron --frames 1-3 --size 640x360 --samples 1 --out a/ --live localhost:{port}");
    let outcome = studio.succeed(&render);
    assert!(viewer.accept().is_ok(), "every address of a name is tried");
    assert!(
        !outcome.err.contains("not to be had") || started.elapsed() > Duration::from_secs(3),
        "{}",
        outcome.err
    );
    assert_eq!(studio.names("a").len(), 3);
}

/// Two machines of a farm were given the same frames: neither takes the other's unfinished files away.
#[test]
fn two_runs_on_one_range_both_end_with_whole_frames() {
    let studio = Studio::new();
    let line = "render tiny.ron --frames 1-12 --size 8x4 --out same/ --threads 1";
    let runs: Vec<_> = (0..3).map(|_| studio.command(line).stderr(Stdio::null()).spawn().unwrap()).collect();
    for mut run in runs {
        assert_eq!(run.wait().unwrap().code(), Some(0));
    }
    studio.succeed("render tiny.ron --frames 1-12 --size 8x4 --out alone/");
    assert_eq!(studio.names("same"), studio.names("alone"));
    for name in studio.names("alone") {
        assert!(studio.bytes(&format!("same/{name}")) == studio.bytes(&format!("alone/{name}")), "{name}");
    }
}

/// The signal comes at any moment of loading, baking, rendering or writing. How soon the program ends is a
/// figure; that it ends by itself with the right code, and that only whole frames are left, is a promise.
#[test]
fn signals_are_heard_at_any_moment() {
    let studio = Studio::new();
    for (number, delay_ms) in [5, 40, 90, 150, 260, 400].into_iter().enumerate() {
        let line = format!(
            "render tiny.ron --bounces all --samples 4096 --size 640x360 --threads 1 --out {number}/"
        );
        let mut run = studio.command(&line).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_millis(delay_ms));
        let listened = listens_for_term(run.id());
        let id = run.id().to_string();
        assert!(Command::new("kill").args(["-TERM", &id]).status().unwrap().success());
        let code = run.wait().unwrap().code();
        // Before the program listens the system ends it: on a machine with other work that may be late.
        assert!(code == Some(143) || code.is_none() && !listened, "after {delay_ms} ms: {code:?}");
        for name in studio.names(&number.to_string()) {
            assert!(studio.frame(&format!("{number}/{name}")).is_intact(), "{name}");
        }
    }
}

/// Whether a process has a handler for SIGTERM.
fn listens_for_term(process: u32) -> bool {
    const SIGTERM: u32 = 15;
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(caught.trim(), 16).unwrap() >> (SIGTERM - 1) & 1 == 1
}
