//! Indirect light that outlives a picture. In goes what is there at a moment, out comes its light, solved or
//! kept. Invariant: what is kept changes no bit, as light is solved of the same contents about the same
//! origin wherever the camera stands.

use super::solved::Solved;
use crate::scene::Bounces;
use crate::snapshot::{Contents, Exposure};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Light of a scene's pictures that are being rendered, and of the last one, for the next: where only the
/// camera, size or exposure changes it is the same. Of one scene alone.
#[derive(Default)]
pub struct KeptLight(Mutex<Vec<(Key, Arc<Solved>)>>);

/// Key that light depends on.
#[derive(Clone, Copy, PartialEq)]
struct Key {
    contents: [u8; 32],
    bounces: Bounces,
}

/// Light that is kept for a picture as long as this is.
pub struct HeldLight {
    _light: Option<Arc<Solved>>,
    took: Duration,
}

impl HeldLight {
    /// Time that it took to find it.
    pub fn took(&self) -> Duration {
        self.took
    }
}

impl KeptLight {
    /// `None` where nothing could scatter light. What `cancelled` cut short is not kept.
    pub(super) fn of(
        &self,
        contents: Contents,
        bounces: Bounces,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Option<Arc<Solved>> {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let key = Key { contents: contents.digest(), bounces };
        let known = all().iter().find(|(kept, _)| *kept == key).map(|(_, light)| Arc::clone(light));
        if known.is_some() {
            return known;
        }
        // What nobody holds would only take memory meanwhile.
        all().retain(|(_, light)| Arc::strong_count(light) > 1);
        let light = Arc::new(Solved::new(&contents.frozen(), bounces, cancelled)?);
        if !cancelled() {
            all().push((key, Arc::clone(&light)));
        }
        Some(light)
    }

    /// Finds the light of a picture before that is rendered.
    pub fn hold(
        &self,
        exposure: &Exposure,
        bounces: Bounces,
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> HeldLight {
        let started = Instant::now();
        HeldLight { _light: self.of(exposure.contents(), bounces, cancelled), took: started.elapsed() }
    }
}
