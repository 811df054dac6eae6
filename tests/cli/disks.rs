//! Disks that fail: full ones, folders that vanish or take no files, files in folders' places. The exit
//! code is that of input and output, a message helps, older good files stay whole and nothing
//! half-written is left.
#![cfg(unix)]

use crate::program::{Outcome, Studio, outcome};
use std::fs;
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::process::Stdio;

const INPUT_OUTPUT: i32 = 4;

/// Runs the program where no file may grow beyond so many blocks of 512 bytes, which stands in
/// for the end of a disk.
fn with_full_disk(studio: &Studio, blocks: u32, line: &str) -> Outcome {
    let line = format!("ulimit -f {blocks}; exec sunfleck {line}");
    outcome(studio.shell(&line).output().unwrap())
}

fn assert_says_so(outcome: &Outcome, line: &str) {
    assert_eq!(outcome.code, INPUT_OUTPUT, "{line}: {}", outcome.err);
    for part in ["error: ", "expected: ", "remedy: "] {
        assert!(outcome.err.contains(part), "{line}: {}", outcome.err);
    }
}

/// Memory ends while a scene is read, or while it is rendered: no panic, no dead process.
#[test]
#[cfg(target_os = "linux")]
fn memory_that_cannot_be_had_is_said() {
    let studio = Studio::new();
    let leaves = r#"meshes: { "leaf": Leaf(length_m: 0.1, width_m: 0.06) }, cameras: { "main": (position_m: (0.0, 1.0, 4.0)) },
        leaves: { "crown": (count: 400000, meshes: ["leaf"], min_m: (-1.0, 0.0, -1.0), max_m: (1.0, 2.0, 1.0)) }"#;
    fs::write(studio.path("many.ron"), format!("Scene(version: 1, {leaves})")).unwrap();
    for kilobytes in [150_000, 250_000, 400_000] {
        let line = "render many.ron --frames 1 --size 8x4 --samples 1 --threads 1 --bounces 0 --out many/";
        let shell = format!("ulimit -c 0; ulimit -v {kilobytes}; exec sunfleck {line}");
        let outcome = outcome(studio.shell(&shell).output().unwrap());
        assert_eq!(outcome.code, INPUT_OUTPUT, "{kilobytes} kB: {}", outcome.err);
        assert!(outcome.err.contains("memory"), "{kilobytes} kB: {}", outcome.err);
        // Nobody may speak once memory is at its end.
        let is_told = outcome.err.contains("limited to 153 MB") && outcome.err.contains("(ulimit -v)");
        assert_eq!(is_told, kilobytes == 150_000, "{kilobytes} kB: {}", outcome.err);
        assert!(!outcome.err.contains("panicked"), "{kilobytes} kB: {}", outcome.err);
    }
}

/// A small stack is no reason to end: the program has one of its own.
#[test]
#[cfg(target_os = "linux")]
fn a_limit_of_the_stack_changes_nothing() {
    let studio = Studio::new();
    let shell = "ulimit -s 64; exec sunfleck render tiny.ron --frames 1 --size 16x9 --samples 1 --out a/";
    assert_eq!(outcome(studio.shell(shell).output().unwrap()).code, 0);
}

/// The disk is full after a few bytes, in the middle of the file, or near its end.
#[test]
fn a_full_disk_cuts_no_older_file() {
    let studio = Studio::new();
    for (line, name) in [
        ("render tiny.ron --frames 1 --size 64x36 --samples 1 --out a/x.exr", "x.exr"),
        ("render tiny.ron --frames 1 --size 64x36 --samples 1 --preview png --out a/y.exr", "y.png"),
        ("export tiny.ron a/own.glb", "own.glb"),
        ("preview tiny.ron --frames 1 --size 64x36 --out a/z.png", "z.png"),
        ("preview tiny.ron --frames 1-2 --size 64x36 --out a/play.apng", "play.apng"),
    ] {
        studio.succeed(line);
        let names = studio.names("a");
        let good = studio.bytes(&format!("a/{name}"));
        // What is there is other than what comes, and as good.
        let older = [&good[..], b"older"].concat();
        let blocks = good.len() as u32 / 512;
        for blocks in
            [0, 1, blocks / 2, blocks].into_iter().filter(|&blocks| 512 * (blocks as usize) < good.len())
        {
            fs::write(studio.path("a").join(name), &older).unwrap();
            let outcome = with_full_disk(&studio, blocks, line);
            assert_says_so(&outcome, line);
            assert!(studio.bytes(&format!("a/{name}")) == older, "{line}: cut after {blocks} blocks");
            assert_eq!(studio.names("a"), names, "{line}");
        }
    }
}

#[test]
fn answers_and_statistics_that_a_full_disk_does_not_take_are_failures() {
    let studio = Studio::new();
    studio.succeed("render tiny.ron --frames 1 --size 8x4 --samples 1 --out x.exr");
    assert_says_so(
        &studio.run("render tiny.ron --frames 1 --size 8x4 --samples 1 --out y.exr --stats /dev/full"),
        "--stats",
    );
    for line in ["inspect tiny.ron", "inspect tiny.ron --json", "diff x.exr x.exr"] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let ended = studio.command(line).stdout(full).stderr(Stdio::piped()).output().unwrap();
        assert_eq!(ended.status.code(), Some(INPUT_OUTPUT), "{line}");
        assert!(String::from_utf8(ended.stderr).unwrap().contains("remedy: free room"), "{line}");
    }
}

#[test]
fn a_limit_of_file_sizes_is_called_so() {
    let studio = Studio::new();
    for line in [
        "render tiny.ron --frames 1 --size 64x36 --samples 1 --out a/x.exr",
        "render tiny.ron --frames 1-9 --size 2x2 --samples 1 --out b/ --stats stats.jsonl",
        "export tiny.ron own.glb",
        "preview tiny.ron --frames 1 --size 64x36 --out z.png",
    ] {
        let outcome = with_full_disk(&studio, 1, line);
        assert_says_so(&outcome, line);
        assert!(outcome.err.contains("ulimit -f"), "{line}: {}", outcome.err);
        assert!(!outcome.err.contains("disk"), "{line}: {}", outcome.err);
    }
}

/// A bake that cannot be kept is done without.
#[test]
fn a_cache_that_takes_nothing_stops_no_work() {
    let studio = Studio::new();
    fs::write(studio.path("file"), "").unwrap();
    for cache in ["file", "file/below", "/dev/full"] {
        studio.succeed(&format!(
            "render tiny.ron --frames 1 --size 8x4 --samples 1 --out a/ --bake-cache {cache}"
        ));
    }
}

#[test]
fn things_in_the_way_are_named_and_left() {
    let studio = Studio::new();
    fs::write(studio.path("file"), "mine").unwrap();
    fs::write(studio.path("out"), "mine").unwrap();
    fs::create_dir_all(studio.path("is/own.glb")).unwrap();
    fs::create_dir_all(studio.path("is/x.png")).unwrap();
    fs::create_dir_all(studio.path("is/x.exr/full")).unwrap();
    for (line, named) in [
        ("render tiny.ron --frames 1 --size 8x4 --samples 1 --out file/a/", "file/a"),
        ("render tiny.ron --frames 1 --size 8x4 --samples 1 --out is/ --stats is", "is"),
        ("render tiny.ron --frames 1 --size 8x4 --samples 1 --out is/x.#.exr --stats file/s", "file/s"),
        ("render tiny.ron --frames 1 --size 8x4 --samples 1", "in the folder out: "),
        ("export tiny.ron file/own.glb", "file"),
        ("export tiny.ron is/own.glb", "is/own.glb"),
        ("preview tiny.ron --frames 1 --size 8x4 --out file/x.png", "file"),
    ] {
        let outcome = studio.run(line);
        assert_says_so(&outcome, line);
        assert!(outcome.err.contains(named), "{line}: {}", outcome.err);
    }
    assert_eq!(studio.bytes("file"), b"mine");
    assert_eq!(studio.names("is"), ["own.glb", "x.exr", "x.png"]);
}

/// Whoever tidies up while frames are written loses what was there, and no more.
#[test]
fn a_folder_that_vanishes_meanwhile_is_made_anew() {
    let studio = Studio::new();
    let line = "render tiny.ron --frames 1-4 --size 48x27 --threads 1 --progress jsonl --out a/";
    let mut run = studio.command(line).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let mut events = BufReader::new(run.stdout.take().unwrap()).lines().map(Result::unwrap);
    events.find(|line| line.contains("frame_written")).expect("a frame is written");
    // A frame may be written at this very moment.
    while fs::remove_dir_all(studio.path("a")).is_err() {}
    events.for_each(drop);
    let code = run.wait().unwrap().code();
    assert!(code == Some(0) || code == Some(INPUT_OUTPUT), "{code:?}");
    let names = studio.names("a");
    assert!(code != Some(0) || names.last().is_some_and(|name| name == "tiny.0004.exr"), "{names:?}");
    for name in names {
        assert!(studio.frame(&format!("a/{name}")).is_intact(), "{name}");
    }
}

#[test]
fn a_folder_that_takes_no_files_is_named() {
    let studio = Studio::new();
    fs::create_dir(studio.path("closed")).unwrap();
    fs::set_permissions(studio.path("closed"), fs::Permissions::from_mode(0o555)).unwrap();
    // Root may write everywhere.
    if fs::write(studio.path("closed/probe"), "").is_ok() {
        return;
    }
    for line in [
        "render tiny.ron --frames 1 --size 8x4 --samples 1 --out closed/",
        "export tiny.ron closed/own.glb",
        "preview tiny.ron --frames 1 --size 8x4 --out closed/x.png",
    ] {
        assert_says_so(&studio.run(line), line);
    }
    assert_eq!(studio.names("closed"), [""; 0]);
}
