//! Exposure of a frame: snapshots of moments between the shutter's opening and closing. In go a scene and a
//! shutter, out come as many moments as the motion needs. Invariants: a still scene, or an instantaneous
//! shutter, has one moment; all moments have the same lights in the same order.
//!
//! Moments are frozen on first use: the solution of higher orders, which comes before, has the memory until
//! then.

use super::middle::Middle;
use super::moment::lights_on;
use super::still::Still;
use super::{Contents, Framing, Instant, MeshTrees, MotionField, SeenFog, Shutter, Snapshot};
use crate::diagnostic::{Diagnostic, Loss, Place};
use crate::scene::{Scene, Size, matte_id};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant as Clock};

/// Number of moments of a shutter with motion. A leaf that crosses 30 pixels is rendered in steps of about a
/// pixel; the number is odd, so that one moment is the middle.
const MOMENTS: usize = 33;

/// Maximum number of instances of all moments together: two gigabytes. Each takes a fifth of a kilobyte, for
/// its place and its share of the tree.
const MOST_PLACED: usize = 1 << 23;
/// Minimum number of moments, for any number of instances: opening, middle and closing.
const FEWEST_MOMENTS: usize = 3;

/// The moments of one frame.
pub struct Exposure<'scene> {
    scene: &'scene Scene,
    trees: &'scene MeshTrees,
    framing: Framing,
    times_s: Vec<f64>,
    middle_s: f64,
    /// Whether each of the scene's lights emits at any moment of the shutter.
    lights_on: Vec<bool>,
    motion: Option<Arc<MotionField>>,
    mattes: Option<Arc<[u32]>>,
    frozen: OnceLock<Frozen<'scene>>,
}

/// Moments, and the time that it took to freeze them.
struct Frozen<'scene> {
    moments: Vec<Snapshot<'scene>>,
    took: Duration,
}

impl<'scene> Exposure<'scene> {
    /// Exposure with the moments of `shutter`; for the other arguments see [`Snapshot::new`].
    pub fn new(
        scene: &'scene Scene,
        trees: &'scene MeshTrees,
        camera: usize,
        aspect: f64,
        shutter: Shutter,
    ) -> Self {
        Self::of(scene, trees, Framing { camera, aspect }, shutter, |times_s| times_s)
    }

    /// Exposure with the middle moment alone, with the lights of all moments. It suffices to choose a method,
    /// and takes a small part of the memory.
    pub fn middle_of(
        scene: &'scene Scene,
        trees: &'scene MeshTrees,
        camera: usize,
        aspect: f64,
        shutter: Shutter,
    ) -> Self {
        Self::of(scene, trees, Framing { camera, aspect }, shutter, |times_s| {
            let middle = times_s.len() / 2;
            &times_s[middle..=middle]
        })
    }

    fn of(
        scene: &'scene Scene,
        trees: &'scene MeshTrees,
        framing: Framing,
        shutter: Shutter,
        chosen: impl Fn(&[f64]) -> &[f64],
    ) -> Self {
        let duration_s = shutter.close_s - shutter.open_s;
        let moments = count(scene, duration_s);
        let times_s: Vec<f64> = (0..moments)
            .map(|moment| shutter.open_s + duration_s * (moment as f64 + 0.5) / moments as f64)
            .collect();
        let either = |a: Vec<bool>, b: Vec<bool>| a.into_iter().zip(b).map(|(a, b)| a | b).collect();
        let lights_on = times_s.iter().map(|time_s| lights_on(scene, *time_s));
        let lights_on = lights_on.reduce(either).unwrap_or_default();
        let middle_s = times_s[moments / 2];
        Self {
            scene,
            trees,
            framing,
            times_s: chosen(&times_s).to_vec(),
            middle_s,
            lights_on,
            motion: None,
            mattes: None,
            frozen: OnceLock::new(),
        }
    }

    fn freeze(&self) -> Frozen<'scene> {
        let started = Clock::now();
        let is_shared = self.times_s.len() > 1;
        let still = is_shared.then(|| Still::of(self.scene)).flatten();
        let freeze = |&time_s: &f64, middle: &Arc<Middle>| {
            let instant = Instant { time_s, frame_s: self.middle_s, still: still.as_ref() };
            let snapshot = Snapshot::at(self.scene, self.trees, self.framing, instant, &self.lights_on);
            let (motion, mattes) = (self.motion.clone(), self.mattes.clone());
            Snapshot { middle: Arc::clone(middle), motion, mattes, ..snapshot }
        };
        let middle = self.times_s.len() / 2;
        // The middle first: the others share trees that it builds.
        let of_middle = freeze(&self.times_s[middle], &Arc::default());
        let [before, after] = [&self.times_s[..middle], &self.times_s[middle + 1..]];
        let places = if is_shared { Middle::of(&of_middle, still.as_ref()) } else { Middle::default() };
        let places = Arc::new(places);
        let [before, after] =
            [before, after].map(|times_s| times_s.par_iter().map(|time_s| freeze(time_s, &places)));
        let moments = before.chain(rayon::iter::once(of_middle)).chain(after).collect();
        Frozen { moments, took: started.elapsed() }
    }

    /// Contents of the middle moment, independent of the camera.
    pub fn contents(&self) -> Contents<'scene> {
        Contents::apart_from_camera(self.scene, self.trees, self.middle_s, &self.lights_on)
    }

    /// Returns a warning if an open shutter has fewer moments than smooth motion blur needs.
    pub fn remark(scene: &Scene, shutter_frames: f64) -> Option<Diagnostic> {
        let (count, instances) = (count(scene, shutter_frames), scene.instances.len());
        (1 < count && count < MOMENTS).then(|| {
            let found = format!(
                "motion blur is drawn from {count} moments of the shutter in place of {MOMENTS}, for memory: \
                 the scene has {instances} instances"
            );
            let most = MOST_PLACED / MOMENTS;
            Diagnostic::warning(Loss::MotionBlurMoments, Place::Nowhere, found).remedy(format!(
                "for smoother blur have at most {most} instances, or join still ones into meshes"
            ))
        })
    }

    /// Exposure with motion vectors.
    pub fn with_motion(mut self, motion: MotionField) -> Self {
        (self.motion, self.frozen) = (Some(Arc::new(motion)), OnceLock::new());
        self
    }

    /// Exposure with Cryptomatte ids of the scene's objects.
    pub fn with_mattes(mut self, scene: &Scene) -> Self {
        let id = |instance: usize| matte_id(scene.matte_name(instance));
        let ids = (0..scene.instances.len()).map(id).collect();
        (self.mattes, self.frozen) = (Some(ids), OnceLock::new());
        self
    }

    /// Precomputes fog of voxels along camera rays for a picture of that size, if the fog is still.
    pub fn see_fog(&self, size: Size) {
        let middle = self.middle();
        let is_still =
            |moment: &Snapshot| moment.view == middle.view && moment.medium.is_same_voxels(&middle.medium);
        if !self.moments().iter().all(is_still) {
            return;
        }
        let Some(seen) = SeenFog::new(middle, size).map(Arc::new) else { return };
        for moment in self.moments() {
            // A second call has the same size.
            let _ = moment.seen_fog.set(Arc::clone(&seen));
        }
    }

    /// The moments, in order of time.
    pub fn moments(&self) -> &[Snapshot<'scene>] {
        &self.frozen.get_or_init(|| self.freeze()).moments
    }

    /// Time that it took to freeze the moments; 0 before their first use.
    pub fn took(&self) -> Duration {
        self.frozen.get().map_or(Duration::ZERO, |frozen| frozen.took)
    }

    /// The moment in the middle.
    pub fn middle(&self) -> &Snapshot<'scene> {
        &self.moments()[self.times_s.len() / 2]
    }

    /// The moment that a number in `[0, 1)` selects.
    pub fn at(&self, u: f64) -> &Snapshot<'scene> {
        let count = self.times_s.len();
        &self.moments()[((u * count as f64) as usize).min(count - 1)]
    }

    /// Whether the sky lights anything at any of the moments.
    pub fn has_sky_light(&self) -> bool {
        self.moments().iter().any(|moment| moment.sky.is_some_and(|sky| sky.lights_surfaces()))
    }

    /// Whether it has a single moment.
    pub fn is_instant(&self) -> bool {
        self.times_s.len() == 1
    }
}

/// Number of moments of a shutter, given how long it is open, in any unit: always odd, and fewer where each
/// takes much memory.
fn count(scene: &Scene, duration: f64) -> usize {
    if duration <= 0.0 || scene.is_still() {
        return 1;
    }
    let affordable = MOST_PLACED / scene.instances.len().max(1);
    (affordable.saturating_sub(1) | 1).clamp(FEWEST_MOMENTS, MOMENTS)
}
