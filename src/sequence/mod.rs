//! Sequences of frames: which are rendered, where they go and what becomes of those that are there
//! already. In go a [`FrameList`], an [`OutputPattern`] and a way to render a frame; out come files,
//! [`Event`]s and a [`Summary`]. Invariant: whatever happens, and whenever, the output folder holds whole
//! frames only.

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
