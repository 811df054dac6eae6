//! Runs over frames: what is written, what is skipped, and what is there after things went wrong.

use glam::DAffine3;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex};
use sunfleck::color::Display;
use sunfleck::film::{Channel, Frame, Precision};
use sunfleck::frame_file::{self, Provenance};
use sunfleck::render::{Progress, Rendered, Statistics};
use sunfleck::scene::{FrameRate, Sampling, Size, Window};
use sunfleck::sequence::{
    Event, FrameList, Job, OutputPattern, SequenceError, Skip, SkipReason, Summary, run,
};

static GO_ON: AtomicBool = AtomicBool::new(false);

fn provenance(frame: i64) -> Provenance {
    Provenance {
        frame,
        sequence_frames: (1, 3),
        frame_rate: FrameRate { numerator: 24, denominator: 1 },
        exposure_s: 0.0,
        camera_from_world: DAffine3::IDENTITY,
        scene_hash: String::from("scene"),
        settings_hash: String::from("settings"),
        seed: 0,
        sampling: Sampling::Exactly(1),
        owner: None,
        comments: None,
        object_names: std::collections::BTreeMap::new(),
    }
}

fn picture(frame: i64) -> Frame {
    let full = Size { width: 5, height: 3 };
    let channels =
        ["R", "G", "B", "A"].map(|name| Channel::new(name, Precision::Half, vec![frame as f32; 15]));
    Frame { full, window: Window::whole(full), channels: channels.to_vec() }
}

/// The frame as a renderer hands it over.
fn done(frame: Frame) -> Option<Rendered> {
    Some(Rendered { frame, statistics: Statistics::default() })
}

fn pattern(folder: &Path) -> OutputPattern {
    OutputPattern::parse(format!("{}/", folder.display()), "x").unwrap()
}

fn job<'a>(frames: &'a FrameList, output: &'a OutputPattern, skip: Skip) -> Job<'a> {
    Job { frames, output, skip, preview: None, stop: &GO_ON, workers: &|_| 1 }
}

fn frames(text: &str) -> FrameList {
    FrameList::parse(text, 1..=9).unwrap()
}

/// Runs over `list` and says which frames were rendered.
fn rendered(folder: &Path, list: &str, skip: Skip) -> (Vec<i64>, Summary) {
    let (list, output) = (frames(list), pattern(folder));
    let rendered = Mutex::new(Vec::new());
    let summary = run(
        job(&list, &output, skip),
        provenance,
        |_, frame, _| {
            rendered.lock().unwrap().push(frame);
            Ok::<_, String>(done(picture(frame)))
        },
        &|_| {},
    );
    (rendered.into_inner().unwrap(), summary.unwrap())
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn every_frame_is_written_under_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let (_, summary) = rendered(folder.path(), "1-3", Skip::None);
    assert_eq!((summary.written, summary.stopped), (3, false));
    assert_eq!(names(folder.path()), ["x.0001.exr", "x.0002.exr", "x.0003.exr"]);
    let file = frame_file::read(&folder.path().join("x.0002.exr")).unwrap();
    assert_eq!(file.frame.channel("R").unwrap().pixels, [2.0; 15]);
    assert_eq!(file.attributes.get("imageCounter"), Some("2"));
}

#[test]
fn valid_frames_are_skipped_and_others_are_not() {
    let folder = tempfile::tempdir().unwrap();
    rendered(folder.path(), "1-4", Skip::None);
    // A frame of another scene, a truncated one, and a missing one.
    let other = Provenance { scene_hash: String::from("other"), ..provenance(2) };
    frame_file::write(&folder.path().join("x.0002.exr"), &picture(2), &other).unwrap();
    std::fs::write(folder.path().join("x.0003.exr"), b"").unwrap();
    let (again, summary) = rendered(folder.path(), "1-5", Skip::Valid);
    assert_eq!(again, [2, 3, 5]);
    assert_eq!((summary.written, summary.skipped_valid), (3, 2));
}

#[test]
fn existing_frames_are_skipped_whatever_they_hold() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.0001.exr"), b"").unwrap();
    let (new, summary) = rendered(folder.path(), "1-2", Skip::Exists);
    assert_eq!(new, [2]);
    assert_eq!(summary.skipped_existing, 1);
}

#[test]
fn a_resumed_run_gives_the_bytes_of_a_run_at_once() {
    let (at_once, resumed) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    rendered(at_once.path(), "1-4", Skip::None);
    rendered(resumed.path(), "3,1", Skip::None);
    rendered(resumed.path(), "all", Skip::Valid);
    for name in names(at_once.path()) {
        let bytes = |folder: &Path| std::fs::read(folder.join(&name)).unwrap();
        assert_eq!(bytes(at_once.path()), bytes(resumed.path()), "{name}");
    }
}

#[test]
fn a_frame_with_nan_is_refused_by_name_and_the_frames_before_stay() {
    let folder = tempfile::tempdir().unwrap();
    let (list, output) = (frames("1-9"), pattern(folder.path()));
    let render = |_: usize, frame, _: &(dyn Fn(Progress) + Sync)| {
        let mut picture = picture(frame);
        if frame == 2 {
            picture.channels[1].pixels[7] = f32::NAN;
        }
        Ok::<_, String>(done(picture))
    };
    let error = run(job(&list, &output, Skip::None), provenance, render, &|_| {}).unwrap_err();
    assert!(matches!(error, SequenceError::Defective { frame: 2, .. }));
    let text = error.to_string();
    assert!(text.contains("frame 2") && text.contains("channel G at pixel 2, 1"), "{text}");
    assert_eq!(names(folder.path()), ["x.0001.exr"]);
}

#[test]
fn a_failed_rendering_ends_the_run_after_the_frame_before_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let (list, output) = (frames("1-9"), pattern(folder.path()));
    let render = |_: usize, frame, _: &(dyn Fn(Progress) + Sync)| {
        if frame == 3 { Err("no light") } else { Ok(done(picture(frame))) }
    };
    let error = run(job(&list, &output, Skip::None), provenance, render, &|_| {}).unwrap_err();
    assert_eq!(error.to_string(), "frame 3: no light");
    assert_eq!(names(folder.path()), ["x.0001.exr", "x.0002.exr"]);
}

#[test]
fn a_frame_that_is_given_up_keeps_no_other_from_being_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let (list, output) = (frames("1-4"), pattern(folder.path()));
    let render = |_: usize, frame, _: &(dyn Fn(Progress) + Sync)| {
        Ok::<_, String>(if frame == 2 { None } else { done(picture(frame)) })
    };
    let summary = run(job(&list, &output, Skip::None), provenance, render, &|_| {}).unwrap();
    assert_eq!((summary.written, &summary.given_up[..], summary.stopped), (3, &[2][..], false));
    assert!(summary.to_string().contains("given up, for they took too long: 2"), "{summary}");
    assert_eq!(names(folder.path()), ["x.0001.exr", "x.0003.exr", "x.0004.exr"]);
}

#[test]
fn a_disk_that_refuses_ends_the_run_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("file"), b"").unwrap();
    let (list, output) = (frames("1-9"), pattern(&folder.path().join("file")));
    let render = |_: usize, frame, _: &(dyn Fn(Progress) + Sync)| Ok::<_, String>(done(picture(frame)));
    let error = run(job(&list, &output, Skip::None), provenance, render, &|_| {}).unwrap_err();
    let SequenceError::Write { frame: 1, source } = error else { panic!("{error}") };
    assert!(source.remedy().contains("--out"));
}

#[test]
fn a_signal_stops_the_run_between_whole_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (list, output) = (frames("1-9"), pattern(folder.path()));
    let stop = AtomicBool::new(false);
    let render = |_: usize, frame, _: &(dyn Fn(Progress) + Sync)| {
        if frame == 3 {
            stop.store(true, Ordering::Relaxed);
            return Err("given up half-way");
        }
        Ok(done(picture(frame)))
    };
    let job = Job { stop: &stop, ..job(&list, &output, Skip::None) };
    let summary = run(job, provenance, render, &|_| {}).unwrap();
    assert_eq!((summary.written, summary.not_reached, summary.stopped), (2, 7, true));
    assert_eq!(names(folder.path()), ["x.0001.exr", "x.0002.exr"]);
}

/// Runs over nine frames by three workers, after the first; frame 2 is done once frame `other` is. What is
/// rendered comes of `render`.
fn by_workers(
    folder: &Path,
    (stop, other): (&AtomicBool, i64),
    render: impl Fn(i64) -> Result<Option<Rendered>, &'static str> + Sync,
) -> (Result<Summary, SequenceError<&'static str>>, Vec<i64>) {
    let (list, output) = (frames("1-9"), pattern(folder));
    let (is_done, news) = (Mutex::new(false), Condvar::new());
    let written = Mutex::new(Vec::new());
    let summary = run(
        Job { stop, workers: &|left| left.min(3), ..job(&list, &output, Skip::None) },
        provenance,
        |_, frame, _| {
            if frame == 2 {
                let is_done = is_done.lock().unwrap();
                drop(news.wait_while(is_done, |is_done| !*is_done).unwrap());
            }
            let rendered = render(frame);
            if frame == other {
                *is_done.lock().unwrap() = true;
                news.notify_all();
            }
            rendered
        },
        &|event| {
            if let Event::FrameWritten { frame, .. } = event {
                written.lock().unwrap().push(frame);
            }
        },
    );
    (summary, written.into_inner().unwrap())
}

#[test]
fn frames_that_are_done_early_are_written_in_their_turn() {
    let (folder, one) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (most, now) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let (summary, written) = by_workers(folder.path(), (&GO_ON, 5), |frame| {
        most.fetch_max(now.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
        let picture = picture(frame);
        now.fetch_sub(1, Ordering::SeqCst);
        Ok(done(picture))
    });
    assert_eq!(summary.unwrap().written, 9);
    assert_eq!(written, (1..=9).collect::<Vec<_>>());
    assert!(most.into_inner() <= 3);
    rendered(one.path(), "1-9", Skip::None);
    for name in names(one.path()) {
        let bytes = |folder: &Path| std::fs::read(folder.join(&name)).unwrap();
        assert_eq!(bytes(folder.path()), bytes(one.path()), "{name}");
    }
}

/// It has failed before frame 2 is done.
#[test]
fn behind_a_frame_that_fails_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let fails = |frame| if frame == 3 { Err("no light") } else { Ok(done(picture(frame))) };
    let (summary, written) = by_workers(folder.path(), (&GO_ON, 3), fails);
    assert_eq!(summary.unwrap_err().to_string(), "frame 3: no light");
    assert_eq!((written, names(folder.path()).len()), (vec![1, 2], 2));
}

#[test]
fn a_signal_stops_all_workers() {
    let folder = tempfile::tempdir().unwrap();
    let stop = AtomicBool::new(false);
    let stopped = |frame| {
        stop.fetch_or(frame == 4, Ordering::Relaxed);
        if frame == 4 { Err("given up half-way") } else { Ok(done(picture(frame))) }
    };
    let (summary, written) = by_workers(folder.path(), (&stop, 4), stopped);
    let summary = summary.unwrap();
    assert!(summary.stopped && summary.written == 3, "{summary:?}");
    assert_eq!(written, [1, 2, 3]);
}

#[test]
fn what_a_killed_run_left_behind_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let abandoned = folder.path().join(".x.0002.exr.q1W2e3.sunfleck-part");
    std::fs::write(&abandoned, b"half a frame").unwrap();
    rendered(folder.path(), "1-2", Skip::None);
    assert_eq!(names(folder.path()), ["x.0001.exr", "x.0002.exr"]);
}

#[test]
fn previews_stand_beside_the_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (list, output) = (frames("1"), pattern(folder.path()));
    let job = Job { preview: Some(Display::default()), ..job(&list, &output, Skip::None) };
    run(job, provenance, |_, frame, _| Ok::<_, String>(done(picture(frame))), &|_| {}).unwrap();
    assert_eq!(names(folder.path()), ["x.0001.exr", "x.0001.png"]);
}

/// Frames that are kept have pictures too, the same as if they had been rendered; a file
/// that gives none is told.
#[test]
fn kept_frames_get_previews_from_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let output = pattern(folder.path());
    let events = Mutex::new(Vec::new());
    let go = |list: &str, skip: Skip| {
        let list = frames(list);
        let job = Job { preview: Some(Display::default()), ..job(&list, &output, skip) };
        let render =
            |_: usize, frame: i64, _: &(dyn Fn(Progress) + Sync)| Ok::<_, String>(done(picture(frame)));
        run(job, provenance, render, &|event| events.lock().unwrap().push(event)).unwrap();
        std::mem::take(&mut *events.lock().unwrap())
    };
    go("1-2", Skip::None);
    let rendered = std::fs::read(path("x.0001.png")).unwrap();
    std::fs::remove_file(path("x.0001.png")).unwrap();
    std::fs::write(path("x.0002.png"), "of other settings").unwrap();
    let skipped = go("1-2", Skip::Valid);
    assert!(skipped.contains(&Event::FrameSkipped { frame: 2, reason: SkipReason::Valid }), "{skipped:?}");
    assert_eq!(std::fs::read(path("x.0001.png")).unwrap(), rendered);
    assert!(image::open(path("x.0002.png")).is_ok());

    std::fs::write(path("x.0003.exr"), "no frame").unwrap();
    let told = go("3", Skip::Exists);
    assert!(
        told.iter().any(|event| matches!(event, Event::PreviewOmitted { frame: 3, reason } if reason.contains("x.0003.exr"))),
        "{told:?}"
    );
    assert!(!path("x.0003.png").exists());
}

#[test]
fn events_tell_the_whole_story() {
    let folder = tempfile::tempdir().unwrap();
    rendered(folder.path(), "1", Skip::None);
    let (list, output) = (frames("1-2"), pattern(folder.path()));
    let events = Mutex::new(Vec::new());
    run(
        job(&list, &output, Skip::Valid),
        provenance,
        |_, frame, progress| {
            progress(Progress::new(0.5, None));
            Ok::<_, String>(done(picture(frame)))
        },
        &|event| events.lock().unwrap().push(event),
    )
    .unwrap();
    let events = events.into_inner().unwrap();
    assert_eq!(events[0], Event::Started { frames: 2 });
    assert_eq!(events[1], Event::FrameSkipped { frame: 1, reason: SkipReason::Valid });
    assert_eq!(events[2], Event::FrameStarted { frame: 2 });
    assert_eq!(events[3], Event::FrameProgress { frame: 2, progress: Progress::new(0.5, None) });
    assert!(matches!(&events[4], Event::FrameWritten { frame: 2, clamped: 0, .. }));
    assert!(matches!(&events[5], Event::Finished(summary) if summary.written == 1));
    assert_eq!(events.len(), 6);
}
