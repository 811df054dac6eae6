//! Cache of the solution of indirect light, from picture to picture. In go the contents of a moment, out
//! comes their solution, new or kept. Invariant: a kept solution has the same bits as a new one, as it
//! belongs to equal contents about the same origin, wherever the camera is.

use super::solved::Solved;
use crate::scene::Bounces;
use crate::snapshot::Contents;
use std::sync::{Arc, Mutex, PoisonError};

/// Solution of the last picture of one scene, for the next: it is the same where only camera, size or
/// exposure change.
#[derive(Default)]
pub struct KeptLight {
    last: Mutex<Option<(Key, Arc<Solved>)>>,
}

/// All input on which the solution depends.
#[derive(Clone, Copy, PartialEq)]
struct Key {
    contents: [u8; 32],
    bounces: Bounces,
}

impl KeptLight {
    /// Returns the solution; `None` where nothing can scatter light. A cancelled solution is not kept.
    pub(super) fn of(
        &self,
        contents: Contents,
        bounces: Bounces,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Arc<Solved>> {
        let last = || self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let key = Key { contents: contents.digest(), bounces };
        if let Some((kept, light)) = &*last()
            && *kept == key
        {
            return Some(Arc::clone(light));
        }
        // Dropped first, as two of them take twice the memory.
        *last() = None;
        let light = Arc::new(Solved::new(&contents.frozen(), bounces, cancelled)?);
        if !cancelled() {
            *last() = Some((key, Arc::clone(&light)));
        }
        Some(light)
    }
}
