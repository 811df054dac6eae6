//! Sequences of frames: selection, paths, and skipping of existing files. In go a [`FrameList`], an
//! [`OutputPattern`] and a function that renders a frame; out come files, [`Event`]s and a [`Summary`].
//! Invariant: at any moment and after any failure, the output folder holds only whole frames.

mod event;
mod frame_list;
mod job;
mod output_pattern;
mod queue;
mod run;
mod writer;

pub use event::{Event, SkipReason, Summary};
pub use frame_list::FrameList;
pub use job::{Job, SequenceError, Skip};
pub use output_pattern::OutputPattern;
pub use run::run;
