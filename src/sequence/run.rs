//! The loop over frames. In goes a way to render one, out come files; frames are rendered several at once,
//! each by a worker of its own, while those that are done are encoded and written in order. Invariant: what
//! comes of a frame does not depend on workers, and a frame with NaN or infinity is never written.

use super::job::{Job, SequenceError};
use super::queue::{Queue, Task};
use super::writer::{Finished, Writer};
use super::{Event, Summary};
use crate::frame_file::Provenance;
use crate::render::{Progress, Rendered};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::time::Instant;

/// Way to render a frame by a worker. These are numbered from 0, and the first frame is the first one's.
type Render<'a, E> =
    &'a (dyn Fn(usize, i64, &(dyn Fn(Progress) + Sync)) -> Result<Option<Rendered>, E> + Sync);

/// Renders and writes the frames of a job that are not skipped.
///
/// `provenance` is asked before rendering, for its hashes decide what is skipped. `render` gets the worker's
/// number and a callback for the fraction done, which it may call from any thread; if it fails after `stop`
/// was set, that counts as stopping, and without a picture the frame is given up. `report` hears of
/// everything and may be called from several threads at once.
///
/// # Errors
/// The first failure in the order of frames ends the run: those before it are written, and none behind it.
pub fn run<E: Send>(
    job: Job<'_>,
    provenance: impl Fn(i64) -> Provenance + Sync,
    render: impl Fn(usize, i64, &(dyn Fn(Progress) + Sync)) -> Result<Option<Rendered>, E> + Sync,
    report: &(dyn Fn(Event) + Sync),
) -> Result<Summary, SequenceError<E>> {
    let started = Instant::now();
    let frames = job.frames.as_slice().len();
    report(Event::Started { frames });
    let queue = Queue::new(job, &provenance, report);
    let written = std::thread::scope(|scope| {
        // Without a buffer: a worker waits until what it hands over is taken.
        let (to_writer, from_workers) = sync_channel(0);
        let writer = Writer { job, report, queue: &queue };
        let writer = scope.spawn(move || writer.write_all(&from_workers));
        let worker = |number: usize| Worker {
            number,
            queue: &queue,
            render: &render,
            report,
            to_writer: to_writer.clone(),
        };
        // Alone, with all threads: it is seen soonest, and makes what all share.
        worker(0).render_next();
        let count = (job.workers)(queue.left()).max(1);
        queue.expect(count);
        for number in 1..count {
            let worker = worker(number);
            scope.spawn(move || worker.render_all());
        }
        let first = worker(0);
        drop(to_writer);
        first.render_all();
        drop(first);
        writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    })?;
    let mut summary = queue.into_summary();
    (summary.written, summary.given_up) = (written.written, written.given_up);
    summary.not_reached = frames - summary.done();
    summary.stopped = summary.not_reached > 0;
    summary.seconds = started.elapsed().as_secs_f64();
    report(Event::Finished(summary.clone()));
    Ok(summary)
}

/// A thread that renders one frame after the other until something stops it.
struct Worker<'a, E> {
    number: usize,
    queue: &'a Queue<'a>,
    render: Render<'a, E>,
    report: &'a (dyn Fn(Event) + Sync),
    to_writer: SyncSender<Finished<E>>,
}

impl<E> Worker<'_, E> {
    fn render_all(&self) {
        while self.render_next() {}
    }

    /// Renders the next frame, if there is one and somebody writes it.
    fn render_next(&self) -> bool {
        let Some(Task { order, frame, provenance }) = self.queue.next() else { return false };
        let report = self.report;
        let frame_started = Instant::now();
        let rendered =
            provenance.map_err(|source| SequenceError::Write { frame, source }).and_then(|provenance| {
                let rendered = (self.render)(self.number, frame, &|progress| {
                    report(Event::FrameProgress { frame, progress })
                });
                let rendered = rendered.map_err(|source| SequenceError::Render { frame, source })?;
                Ok(rendered.map(|rendered| (rendered, provenance)))
            });
        let seconds = frame_started.elapsed().as_secs_f64();
        if rendered.is_err() {
            // No frame behind it is written.
            self.queue.end();
        }
        // Refused only by a writer that has ended; its error is the one to tell.
        self.to_writer.send(Finished { order, frame, rendered, seconds }).is_ok()
    }
}

impl<E> Drop for Worker<'_, E> {
    /// Nobody waits for a frame whose worker is gone.
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.queue.end();
        }
    }
}
