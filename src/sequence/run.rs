//! Loop over frames. In goes a function that renders one, out come files. Workers render several frames at
//! once, while finished ones are encoded and written in order. Invariant: a frame does not depend on the
//! number of workers, and one with NaN or infinity is never written.

use super::job::{Job, SequenceError};
use super::queue::{Queue, Task};
use super::writer::{Finished, Writer};
use super::{Event, Summary};
use crate::frame_file::Provenance;
use crate::render::{Progress, Rendered};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::time::Instant;

/// Function that renders a frame for a worker. Workers are numbered from 0, and worker 0 renders the first
/// frame.
type Render<'a, E> =
    &'a (dyn Fn(usize, i64, &(dyn Fn(Progress) + Sync)) -> Result<Option<Rendered>, E> + Sync);

/// Renders and writes the frames of a job that are not skipped.
///
/// `provenance` is called before rendering, as its hashes decide whether to skip. `render` gets the worker's
/// number and a callback for progress, which any thread may call. An error of `render` after `stop` was set
/// counts as stopping; `None` gives the frame up. `report` gets every event, also from several threads at
/// once.
///
/// # Errors
/// The first failure in the order of frames ends the run: the frames before it are written, and none after
/// it.
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
    std::thread::scope(|scope| {
        // Capacity 0: a worker waits until the writer takes its frame.
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
        // The first frame gets all threads, so that it is ready soon; it also makes shared data.
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
    summary.not_reached = frames - summary.done();
    summary.stopped = summary.not_reached > 0;
    summary.seconds = started.elapsed().as_secs_f64();
    report(Event::Finished(summary.clone()));
    Ok(summary)
}

/// Thread that renders frames until the queue ends.
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

    /// Renders the next frame; returns false at the end of the queue, or without a writer.
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
            // No later frame will be written.
            self.queue.end();
        }
        // Fails only if the writer has ended, whose error is then reported.
        self.to_writer.send(Finished { order, frame, rendered, seconds }).is_ok()
    }
}

impl<E> Drop for Worker<'_, E> {
    /// Ends the queue when a worker panics, so that nobody waits for its frame.
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.queue.end();
        }
    }
}
