//! The loop over frames. In goes a way to render one, out come files; the finished frame is encoded
//! and written on a second thread while the next one renders. Invariant: no more than two frames are in
//! memory, and a frame with NaN or infinity is never written.

use super::{Event, FrameList, OutputPattern, SkipReason, Summary};
use crate::color::Display;
use crate::film::FrameDefects;
use crate::frame_file::{self, FrameFileError, Provenance};
use crate::render::{Progress, Rendered};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Instant;

/// Which frames need no rendering.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Skip {
    /// Those that are whole and were made by this version from this scene and these settings.
    Valid,
    /// All that exist.
    Exists,
    /// None: render everything again.
    #[default]
    None,
}

/// Task of a run.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// Frames.
    pub frames: &'a FrameList,
    /// Pattern of their paths.
    pub output: &'a OutputPattern,
    /// Frames that need no rendering.
    pub skip: Skip,
    /// Writes a PNG beside each frame, shown so; of frames that are kept, from their files.
    pub preview: Option<Display>,
    /// Set by a signal: the frame in progress is given up unless it gets done, and none is begun.
    pub stop: &'a AtomicBool,
}

/// Why a run failed. Frames written before are whole and stay.
#[derive(Debug, thiserror::Error)]
pub enum SequenceError<E> {
    /// A frame could not be rendered.
    #[error("frame {frame}: {source}")]
    Render {
        /// The frame.
        frame: i64,
        /// The renderer's reason.
        source: E,
    },
    /// A frame holds NaN or infinity and was not written.
    #[error("frame {frame} is not written, for it holds values that are no light: {defects}")]
    Defective {
        /// The frame.
        frame: i64,
        /// Defects: how many, and where first.
        defects: FrameDefects,
    },
    /// A frame could not be written.
    #[error("frame {frame}: {source}")]
    Write {
        /// The frame.
        frame: i64,
        /// The disk's reason, with a remedy.
        source: FrameFileError,
    },
}

/// A finished frame on its way to the disk.
struct Finished {
    frame: i64,
    rendered: Rendered,
    provenance: Provenance,
    seconds: f64,
}

/// Renders and writes the frames of a job that are not skipped, in order.
///
/// `provenance` is asked before rendering, for its hashes decide what is skipped. `render` gets a callback
/// for the fraction done, which it may call from any thread; if it fails after `stop` was set, that counts as
/// stopping, and without a picture the frame is given up and the next one begun. `report` hears of everything
/// and may be called from two threads at once.
///
/// # Errors
/// The first failure ends the run; the frame being rendered meanwhile is finished and dropped.
pub fn run<E: Send>(
    job: Job<'_>,
    provenance: impl Fn(i64) -> Provenance,
    render: impl FnMut(i64, &(dyn Fn(Progress) + Sync)) -> Result<Option<Rendered>, E>,
    report: &(dyn Fn(Event) + Sync),
) -> Result<Summary, SequenceError<E>> {
    let started = Instant::now();
    let frames = job.frames.as_slice();
    report(Event::Started { frames: frames.len() });
    let mut summary = Summary::of_nothing(job.output.folder());
    let writer_failed = AtomicBool::new(false);
    summary.written = std::thread::scope(|scope| {
        // Without a buffer: the renderer waits at the end of a frame until the one before is written.
        let (to_writer, from_renderer) = sync_channel::<Finished>(0);
        let failed = &writer_failed;
        let writer = scope.spawn(move || {
            let result = write_all(job, &from_renderer, report);
            failed.store(result.is_err(), Ordering::Relaxed);
            result
        });
        let renderer = FrameLoop { job, report, writer_failed: failed, to_writer };
        let rendered = renderer.render_all(provenance, render, &mut summary);
        // A frame that was handed over is written whatever became of the next one.
        let written = writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
        rendered.map(|()| written)
    })?;
    summary.not_reached = frames.len() - summary.done();
    summary.stopped = summary.not_reached > 0;
    summary.seconds = started.elapsed().as_secs_f64();
    report(Event::Finished(summary.clone()));
    Ok(summary)
}

/// The thread that renders, frame by frame, until something stops it.
struct FrameLoop<'a> {
    job: Job<'a>,
    report: &'a (dyn Fn(Event) + Sync),
    writer_failed: &'a AtomicBool,
    to_writer: SyncSender<Finished>,
}

impl FrameLoop<'_> {
    /// Renders all frames; once this is over, the writer gets no more.
    fn render_all<E>(
        self,
        provenance: impl Fn(i64) -> Provenance,
        mut render: impl FnMut(i64, &(dyn Fn(Progress) + Sync)) -> Result<Option<Rendered>, E>,
        summary: &mut Summary,
    ) -> Result<(), SequenceError<E>> {
        let Self { job, report, writer_failed, to_writer } = self;
        let stopped = || job.stop.load(Ordering::Relaxed);
        for &frame in job.frames.as_slice() {
            if stopped() || writer_failed.load(Ordering::Relaxed) {
                break;
            }
            let path = job.output.path(frame);
            remove_abandoned(job, &path, report);
            let provenance = provenance(frame);
            if let Some(reason) = skip_reason(job.skip, &path, &provenance) {
                summary.count_skipped(reason);
                keep(job, frame, reason, report).map_err(|source| SequenceError::Write { frame, source })?;
                continue;
            }
            report(Event::FrameStarted { frame });
            let frame_started = Instant::now();
            let rendered = render(frame, &|progress| report(Event::FrameProgress { frame, progress }));
            let seconds = frame_started.elapsed().as_secs_f64();
            match rendered {
                Ok(None) => {
                    summary.given_up.push(frame);
                    report(Event::FrameGivenUp { frame, seconds });
                }
                // Refused only by a writer that has failed; its error is the one to tell.
                Ok(Some(rendered)) => {
                    if to_writer.send(Finished { frame, rendered, provenance, seconds }).is_err() {
                        break;
                    }
                }
                Err(_) if stopped() => break,
                Err(source) => return Err(SequenceError::Render { frame, source }),
            }
        }
        Ok(())
    }
}

/// Removes what killed runs left of a frame and of its preview.
fn remove_abandoned(job: Job<'_>, path: &Path, report: &(dyn Fn(Event) + Sync)) {
    let targets = [path.to_owned(), path.with_extension("png")];
    for path in frame_file::remove_abandoned(job.output.folder(), |name| is_name_of(name, &targets)) {
        report(Event::AbandonedRemoved { path });
    }
}

/// Keeps a frame, and makes its preview from its file.
fn keep(
    job: Job<'_>,
    frame: i64,
    reason: SkipReason,
    report: &(dyn Fn(Event) + Sync),
) -> Result<(), FrameFileError> {
    report(Event::FrameSkipped { frame, reason });
    let Some(display) = &job.preview else { return Ok(()) };
    if let Some(reason) = preview_of_file(&job.output.path(frame), display)? {
        report(Event::PreviewOmitted { frame, reason });
    }
    Ok(())
}

fn is_name_of(name: &[u8], paths: &[PathBuf]) -> bool {
    paths.iter().any(|path| path.file_name().is_some_and(|own| own.as_encoded_bytes() == name))
}

fn skip_reason(skip: Skip, path: &Path, provenance: &Provenance) -> Option<SkipReason> {
    match skip {
        Skip::Valid => frame_file::is_valid(path, provenance).then_some(SkipReason::Valid),
        Skip::Exists => path.is_file().then_some(SkipReason::Exists),
        Skip::None => None,
    }
}

/// Makes a kept frame's picture from its file, or says why the file gives none.
fn preview_of_file(path: &Path, display: &Display) -> Result<Option<String>, FrameFileError> {
    let file = match frame_file::read(path) {
        Ok(file) => file,
        Err(error) => return Ok(Some(error.to_string())),
    };
    match frame_file::write_preview(&path.with_extension("png"), &file.frame, display) {
        Err(FrameFileError::Encode { reason, .. }) => Ok(Some(reason)),
        done => done.map(|()| None),
    }
}

/// Writes frames as they come, and counts them.
fn write_all<E>(
    job: Job<'_>,
    finished: &Receiver<Finished>,
    report: &(dyn Fn(Event) + Sync),
) -> Result<usize, SequenceError<E>> {
    let mut written = 0;
    for Finished { frame, rendered, provenance, seconds } in finished {
        let Rendered { frame: picture, statistics } = rendered;
        let defects = picture.check();
        if defects.are_fatal() {
            return Err(SequenceError::Defective { frame, defects });
        }
        let (dark, write_started) = (picture.darkness(), Instant::now());
        let path = job.output.path(frame);
        let write_error = |source| SequenceError::Write { frame, source };
        frame_file::write(&path, &picture, &provenance).map_err(write_error)?;
        if let Some(display) = &job.preview {
            frame_file::write_preview(&path.with_extension("png"), &picture, display).map_err(write_error)?;
        }
        written += 1;
        let clamped = defects.clamped.count;
        let write_seconds = write_started.elapsed().as_secs_f64();
        report(Event::FrameWritten { frame, path, seconds, write_seconds, clamped, dark, statistics });
    }
    Ok(written)
}
