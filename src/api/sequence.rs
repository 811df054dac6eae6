//! Frames one after the other. In go a renderer's settings and numbers, out come frames. Invariant: each
//! frame equals the one rendered alone; shared data are made once.

use super::error::RenderError;
use super::frame::Frame;
use super::plan::Plan;
use crate::diagnostic::{Diagnostic, Place};
use crate::render::Watch;

/// Iterator over the frames of [`Renderer::sequence`](super::Renderer::sequence), which renders each when it
/// is taken.
#[must_use = "frames are rendered as they are taken"]
pub struct Sequence<'a> {
    pub(super) plan: Plan<'a>,
    pub(super) frames: std::vec::IntoIter<i64>,
    pub(super) watch: Watch<'a>,
}

impl Iterator for Sequence<'_> {
    type Item = Result<Frame, RenderError>;

    fn next(&mut self) -> Option<Self::Item> {
        let frame = self.frames.next()?;
        Some(rendered(&self.plan, frame, &self.watch))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        self.frames.size_hint()
    }
}

impl ExactSizeIterator for Sequence<'_> {}

pub(super) fn rendered(plan: &Plan, frame: i64, watch: &Watch) -> Result<Frame, RenderError> {
    let rendered = plan.render(&plan.exposure(frame), watch);
    if (watch.cancelled)() {
        return Err(RenderError::Cancelled);
    }
    let defects = rendered.frame.check();
    if defects.are_fatal() {
        let diagnostic = Diagnostic::error(Place::Nowhere, format!("frame {frame}: {defects}"))
            .expected("finite light everywhere")
            .remedy("report this scene; a crop around the pixel shows it");
        return Err(RenderError::Defective(Box::new(diagnostic)));
    }
    Ok(Frame::new(plan, frame, rendered))
}
