//! Signals: whatever stops a run, the frames on the disk are whole, and the next run completes them.
#![cfg(unix)]

use crate::program::Studio;
use std::io::{BufRead, BufReader};
use std::process::{Command, ExitStatus, Stdio};

/// Slow enough that a signal finds the run at work.
const RENDER: &str = "render tiny.ron --frames 1-6 --samples 512 --threads 1 --progress jsonl --skip valid";

/// Starts a run and sends it a signal once its second frame is begun.
fn interrupt(studio: &Studio, signal: &str) -> ExitStatus {
    interrupt_by(&mut studio.command(&format!("{RENDER} --out stopped/")), signal)
}

fn interrupt_by(command: &mut Command, signal: &str) -> ExitStatus {
    let mut run = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let lines = BufReader::new(run.stdout.take().unwrap()).lines();
    let mut events = lines.map(Result::unwrap);
    events.find(|line| line.contains("frame_written")).expect("a frame is written");
    let number = run.id().to_string();
    assert!(Command::new("kill").args([signal, &number]).status().unwrap().success());
    events.for_each(drop);
    run.wait().unwrap()
}

fn assert_whole_frames(studio: &Studio) {
    for name in studio.names("stopped").iter().filter(|name| !name.starts_with('.')) {
        assert!(studio.frame(&format!("stopped/{name}")).is_intact(), "{name}");
    }
}

/// Completes the stopped run and compares it with one that was left alone.
fn assert_completes(studio: &Studio) {
    studio.succeed(&format!("{RENDER} --out whole/"));
    let rest = studio.succeed(&format!("{RENDER} --out stopped/"));
    assert!(rest.out.contains("frame_skipped"), "the first run's frames are not used\n{}", rest.out);
    assert_eq!(studio.names("stopped"), studio.names("whole"), "nothing but frames is left");
    for name in studio.names("whole") {
        assert!(studio.bytes(&format!("stopped/{name}")) == studio.bytes(&format!("whole/{name}")), "{name}");
    }
}

#[test]
fn an_interrupted_run_leaves_whole_frames_and_can_go_on() {
    let studio = Studio::new();
    assert_eq!(interrupt(&studio, "-INT").code(), Some(130));
    let names = studio.names("stopped");
    assert!((1..6).contains(&names.len()), "{names:?}");
    assert!(names.iter().all(|name| name.starts_with("tiny.") && name.ends_with(".exr")), "{names:?}");
    assert_whole_frames(&studio);
    assert_completes(&studio);
}

/// Nobody else knows of a run whose reader, such as Blender or an agent of a farm, was killed.
#[test]
fn a_run_ends_with_the_program_that_reads_its_events() {
    let studio = Studio::new();
    for style in ["jsonl", "openjd"] {
        let line = format!(
            "render tiny.ron --frames 1-6 --samples 512 --threads 1 --progress {style} --out {style}/"
        );
        let mut run = studio.command(&line).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        drop(run.stdout.take());
        assert_eq!(run.wait().unwrap().code(), Some(143), "{style}");
        assert!(studio.names(style).len() < 6, "{style}");
    }
}

#[test]
fn a_terminated_run_says_so() {
    let studio = Studio::new();
    assert_eq!(interrupt(&studio, "-TERM").code(), Some(143));
    assert_whole_frames(&studio);
}

/// The terminal goes: nothing but frames is left, unless the program was told to go on without it. Tests may
/// run under `nohup` themselves, so the action of the signal is set in both cases.
#[test]
#[cfg(target_os = "linux")]
fn a_run_hears_that_its_terminal_is_gone_but_not_under_nohup() {
    let studio = Studio::new();
    let hang_up = |launcher: &[&str]| {
        let run = studio.command(&format!("{RENDER} --out stopped/"));
        let mut command = Command::new(launcher[0]);
        command.args(&launcher[1..]).arg(run.get_program()).args(run.get_args()).current_dir(studio.path(""));
        command.envs(run.get_envs().filter_map(|(name, value)| Some((name, value?))));
        interrupt_by(&mut command, "-HUP").code()
    };
    assert_eq!(hang_up(&["env", "--default-signal=HUP"]), Some(129));
    assert!(studio.names("stopped").iter().all(|name| !name.starts_with('.')));
    assert_eq!(hang_up(&["nohup"]), Some(0));
    assert_eq!(studio.names("stopped").len(), 6);
}

#[test]
fn a_killed_run_leaves_whole_frames_and_can_go_on() {
    let studio = Studio::new();
    assert_eq!(interrupt(&studio, "-KILL").code(), None);
    assert_whole_frames(&studio);
    // What a kill in the middle of writing leaves behind.
    std::fs::write(studio.path("stopped/.tiny.0006.exr.abc123.sunfleck-part"), "half").unwrap();
    assert_completes(&studio);
}

/// Memory has no limit here, so that it was not memory.
#[test]
#[cfg(target_os = "linux")]
fn an_aborted_run_ends_by_its_own_signal() {
    use std::os::unix::process::ExitStatusExt;
    let studio = Studio::new();
    assert_eq!(interrupt(&studio, "-ABRT").signal(), Some(6));
    assert_whole_frames(&studio);
}
