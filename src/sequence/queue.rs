//! Queue of frames to render. In goes a list, out comes one task after the other. Invariant: tasks are
//! numbered in the list's order without skipped frames. Workers are at most two tasks each ahead of the
//! writer.

use super::job::{Job, Skip};
use super::{Event, SkipReason, Summary};
use crate::color::Display;
use crate::frame_file::{self, FrameFileError, Provenance};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Frame to render.
pub(super) struct Task {
    /// Index among the tasks, from 0.
    pub(super) order: usize,
    pub(super) frame: i64,
    /// Provenance for the frame's file, or the error of a preview that could not be written.
    pub(super) provenance: Result<Provenance, FrameFileError>,
}

/// Queue of a job's frames, shared by its workers.
pub(super) struct Queue<'a> {
    job: Job<'a>,
    provenance: &'a (dyn Fn(i64) -> Provenance + Sync),
    report: &'a (dyn Fn(Event) + Sync),
    state: Mutex<State>,
    news: Condvar,
}

struct State {
    /// Number of frames taken from the list, and number of tasks made from them.
    taken: usize,
    begun: usize,
    /// Number of tasks that the writer has finished.
    done: usize,
    workers: usize,
    has_ended: bool,
    summary: Summary,
}

impl<'a> Queue<'a> {
    pub(super) fn new(
        job: Job<'a>,
        provenance: &'a (dyn Fn(i64) -> Provenance + Sync),
        report: &'a (dyn Fn(Event) + Sync),
    ) -> Self {
        let summary = Summary { folder: job.output.folder().to_owned(), ..Summary::default() };
        let state = State { taken: 0, begun: 0, done: 0, workers: 1, has_ended: false, summary };
        Self { job, provenance, report, state: Mutex::new(state), news: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of frames that no worker has taken.
    pub(super) fn left(&self) -> usize {
        self.job.frames.as_slice().len() - self.lock().taken
    }

    /// Sets the number of workers.
    pub(super) fn expect(&self, workers: usize) {
        self.lock().workers = workers;
    }

    /// Next task; `None` at the end of the list, after a signal and after a failure.
    pub(super) fn next(&self) -> Option<Task> {
        let job = &self.job;
        // Pictures that wait for an earlier one occupy memory.
        let is_far_ahead =
            |state: &mut State| !state.has_ended && state.begun >= state.done + 2 * state.workers;
        let state = self.lock();
        let mut state = self.news.wait_while(state, is_far_ahead).unwrap_or_else(PoisonError::into_inner);
        loop {
            if state.has_ended || job.stop.load(Ordering::Relaxed) {
                return None;
            }
            let frame = *job.frames.as_slice().get(state.taken)?;
            state.taken += 1;
            let path = job.output.path(frame);
            remove_abandoned(job, &path, self.report);
            let mut provenance = Ok((self.provenance)(frame));
            if let Ok(made) = &provenance
                && let Some(reason) = skip_reason(job.skip, &path, made)
            {
                state.summary.count_skipped(reason);
                match keep(job, frame, reason, self.report) {
                    Ok(()) => continue,
                    Err(error) => provenance = Err(error),
                }
            } else {
                (self.report)(Event::FrameStarted { frame });
            }
            let order = state.begun;
            state.begun += 1;
            return Some(Task { order, frame, provenance });
        }
    }

    /// Sets the number of tasks that the writer has finished.
    pub(super) fn done(&self, count: usize) {
        self.lock().done = count;
        self.news.notify_all();
    }

    /// Ends the queue, so that no worker starts another frame.
    pub(super) fn end(&self) {
        self.lock().has_ended = true;
        self.news.notify_all();
    }

    /// Changes the counts of frames.
    pub(super) fn count(&self, change: impl FnOnce(&mut Summary)) {
        change(&mut self.lock().summary);
    }

    /// Counts of frames.
    pub(super) fn into_summary(self) -> Summary {
        self.state.into_inner().unwrap_or_else(PoisonError::into_inner).summary
    }
}

/// Removes temporary files that killed runs left of a frame and of its preview.
fn remove_abandoned(job: &Job<'_>, path: &Path, report: &(dyn Fn(Event) + Sync)) {
    let targets = [path.to_owned(), path.with_extension("png")];
    let is_target = |name: &[u8]| {
        targets.iter().any(|path| path.file_name().is_some_and(|own| own.as_encoded_bytes() == name))
    };
    for path in frame_file::remove_abandoned(job.output.folder(), is_target) {
        report(Event::AbandonedRemoved { path });
    }
}

/// Skips a frame, and makes its preview from its file.
fn keep(
    job: &Job<'_>,
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

fn skip_reason(skip: Skip, path: &Path, provenance: &Provenance) -> Option<SkipReason> {
    match skip {
        Skip::Valid => frame_file::is_valid(path, provenance).then_some(SkipReason::Valid),
        Skip::Exists => path.is_file().then_some(SkipReason::Exists),
        Skip::None => None,
    }
}

/// Writes the preview of a skipped frame, or returns why its file gives none.
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
