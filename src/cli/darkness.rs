//! Frames that look black. In go the events of a run, out comes one warning with the likeliest cause.
//! Invariant: the frames are written all the same.

use super::tell;
use std::sync::{Mutex, PoisonError};
use sunfleck::api::Plan;
use sunfleck::diagnostic::{Diagnostic, Loss, Place};
use sunfleck::film::Dark;
use sunfleck::scene::{DarkCause, dark_cause};
use sunfleck::sequence::Event;

#[derive(Default)]
pub(super) struct DarkFrames(Mutex<Counted>);

#[derive(Clone, Copy, Default)]
struct Counted {
    frames: usize,
    dark: usize,
    first: Option<(i64, Dark)>,
}

impl DarkFrames {
    /// Counts written frames that look black. Any thread may call it.
    pub(super) fn report(&self, event: &Event) {
        if let Event::FrameWritten { frame, dark, .. } = event {
            self.count(*frame, *dark);
        }
    }

    pub(super) fn count(&self, frame: i64, dark: Option<Dark>) {
        let mut counted = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        counted.frames += 1;
        if let Some(dark) = dark {
            counted.dark += 1;
            // Threads may finish out of order.
            let first = counted.first.filter(|(earlier, _)| *earlier < frame);
            counted.first = Some(first.unwrap_or((frame, dark)));
        }
    }

    /// Reports the cause, if there were any.
    pub(super) fn tell_of(&self, plan: &Plan) {
        let Counted { frames, dark, first } = *self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((frame, Dark { covered })) = first else { return };
        let scene = plan.scene.resolved();
        let cause = if plan.settings.shafts_alone && scene.fogs.is_empty() {
            DarkCause::NoFog
        } else {
            dark_cause(scene, plan.camera, plan.shutter(frame).middle_s(), covered)
        };
        let which = match (dark, frames) {
            (1, 1) => format!("frame {frame} is next to black"),
            (1, _) => format!("1 of {frames} frames is next to black, frame {frame}"),
            _ => format!("{dark} of {frames} frames are next to black, the first is frame {frame}"),
        };
        let found = format!("{which}: {cause}");
        let warning = Diagnostic::warning(Loss::DarkFrame, Place::Nowhere, found);
        tell(&warning.counting(dark).remedy(cause.remedy()).to_string());
    }
}
