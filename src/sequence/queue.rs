//! Frames that are still to be rendered. In goes a list, out comes one task after the other. Invariant: tasks
//! are numbered in the order of the list without those that are skipped, and no worker is far ahead of what
//! is written.

use super::job::{Job, Skip};
use super::{Event, SkipReason, Summary};
use crate::color::Display;
use crate::frame_file::{self, FrameFileError, Provenance};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// A frame that is to be rendered.
pub(super) struct Task {
    /// Number among the tasks, from 0.
    pub(super) order: usize,
    pub(super) frame: i64,
    /// What its file says; or why nothing can be written where it belongs.
    pub(super) provenance: Result<Provenance, FrameFileError>,
}

/// Frames of a job, shared by its workers.
pub(super) struct Queue<'a> {
    job: Job<'a>,
    provenance: &'a (dyn Fn(i64) -> Provenance + Sync),
    report: &'a (dyn Fn(Event) + Sync),
    state: Mutex<State>,
    news: Condvar,
}

struct State {
    /// Frames taken from the list, and tasks made of them.
    taken: usize,
    begun: usize,
    /// Tasks that the writer is done with.
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

    /// Frames that nobody has taken.
    pub(super) fn left(&self) -> usize {
        self.job.frames.as_slice().len() - self.lock().taken
    }

    /// Expects so many workers.
    pub(super) fn expect(&self, workers: usize) {
        self.lock().workers = workers;
    }

    /// The next task; `None` at the end, after a signal and once nothing is written any more.
    pub(super) fn next(&self) -> Option<Task> {
        let job = &self.job;
        // A picture that waits for one before it takes memory.
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

    /// Tells that so many tasks are done with.
    pub(super) fn done(&self, count: usize) {
        self.lock().done = count;
        self.news.notify_all();
    }

    /// Lets no worker begin another frame.
    pub(super) fn end(&self) {
        self.lock().has_ended = true;
        self.news.notify_all();
    }

    /// What was skipped.
    pub(super) fn into_summary(self) -> Summary {
        self.state.into_inner().unwrap_or_else(PoisonError::into_inner).summary
    }
}

/// Removes what killed runs left of a frame and of its preview.
fn remove_abandoned(job: &Job<'_>, path: &Path, report: &(dyn Fn(Event) + Sync)) {
    let targets = [path.to_owned(), path.with_extension("png")];
    for path in frame_file::remove_abandoned(job.output.folder(), |name| is_name_of(name, &targets)) {
        report(Event::AbandonedRemoved { path });
    }
}

/// Keeps a frame, and makes its preview from its file.
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
