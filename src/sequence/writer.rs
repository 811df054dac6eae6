//! Writer thread. In go frames as workers finish them, out come files, in the order of frames. Invariant:
//! after a failed frame nothing is written.

use super::Event;
use super::job::{Job, SequenceError};
use super::queue::Queue;
use crate::frame_file::{self, Provenance};
use crate::render::Rendered;
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::sync::mpsc::Receiver;
use std::time::Instant;

/// Finished frame for the disk.
pub(super) struct Finished<E> {
    /// Index of its task.
    pub(super) order: usize,
    pub(super) frame: i64,
    /// `None` if the frame was given up.
    pub(super) rendered: Result<Option<(Rendered, Provenance)>, SequenceError<E>>,
    pub(super) seconds: f64,
}

#[derive(Clone, Copy)]
pub(super) struct Writer<'a> {
    pub(super) job: Job<'a>,
    pub(super) report: &'a (dyn Fn(Event) + Sync),
    pub(super) queue: &'a Queue<'a>,
}

impl Writer<'_> {
    /// Writes frames in order until all workers are gone.
    pub(super) fn write_all<E>(self, from_workers: &Receiver<Finished<E>>) -> Result<(), SequenceError<E>> {
        let (mut waiting, mut turn) = (BTreeMap::new(), 0);
        let result = from_workers.iter().try_for_each(|finished| {
            waiting.insert(finished.order, finished);
            while let Some(next) = waiting.remove(&turn) {
                self.write(next)?;
                turn += 1;
                self.queue.done(turn);
            }
            Ok(())
        });
        self.queue.end();
        match result {
            Err(SequenceError::Render { .. }) if self.job.stop.load(Ordering::Relaxed) => Ok(()),
            result => result,
        }
    }

    fn write<E>(self, finished: Finished<E>) -> Result<(), SequenceError<E>> {
        let (Self { job, report, .. }, Finished { frame, rendered, seconds, .. }) = (self, finished);
        let Some((Rendered { frame: picture, statistics }, provenance)) = rendered? else {
            self.queue.count(|summary| summary.given_up.push(frame));
            report(Event::FrameGivenUp { frame, seconds });
            return Ok(());
        };
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
        self.queue.count(|summary| summary.written += 1);
        let clamped = defects.clamped.count;
        let write_seconds = write_started.elapsed().as_secs_f64();
        report(Event::FrameWritten { frame, path, seconds, write_seconds, clamped, dark, statistics });
        Ok(())
    }
}
