//! The one loop that joins transport and film. In go a snapshot and a job, out comes a frame.
//! Invariant: every picture is a pure function of (snapshot, job), so neither the number of threads
//! nor their order reaches it.

mod slices;
mod tiles;

use crate::film::Frame;
use crate::scene::{Pass, Size, Window};
use crate::snapshot::Snapshot;
use crate::transport::Transport;
use std::sync::atomic::AtomicBool;

/// What is to be rendered of a snapshot.
#[derive(Clone, Debug)]
pub struct Job {
    /// The whole picture.
    pub size: Size,
    /// The part of it that is wanted.
    pub window: Window,
    /// Passes beside the beauty.
    pub passes: Vec<Pass>,
    /// Samples a pixel, at least 1.
    pub samples: u32,
    /// Seed of the sample points.
    pub seed: u32,
    /// How rays are followed.
    pub transport: Transport,
    /// Where the samples lie.
    pub placement: Placement,
}

/// Where the samples of a picture lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// In each pixel, each a ray of its own; a single one at the pixel's centre.
    Pixels,
    /// On epipolar slices, each slice solved as a whole; a picture for each light, added up.
    Slices,
}

/// Renders on the current rayon pool. `progress` is told the finished fraction now and then;
/// once `cancelled` is true the frame comes back unfinished.
pub fn render(
    snapshot: &Snapshot,
    job: &Job,
    progress: &(dyn Fn(f64) + Sync),
    cancelled: &AtomicBool,
) -> Frame {
    match job.placement {
        Placement::Slices if slices::can_serve(snapshot) => {
            slices::render(snapshot, job, progress, cancelled)
        }
        Placement::Slices | Placement::Pixels => tiles::render(snapshot, job, progress, cancelled),
    }
}
