//! Renderer of a scene, set up step by step. In go a scene and settings, out comes a frame. Invariant:
//! settings that are not given are the scene's own. All are checked together, when the frame is rendered.

use super::error::RenderError;
use super::frame::Frame;
use super::plan::Plan;
use super::scene::Scene;
use super::sequence::Sequence;
use crate::passes::Pass;
use crate::render::{Method, Progress, Watch};
use crate::scene::{Bounces, PixelFilter, RenderSettings, Sampling, Size, Window};

/// Renders frames of a scene, on the rayon pool that it is called on.
#[derive(Clone)]
#[must_use = "nothing is rendered before `render`"]
pub struct Renderer<'a> {
    scene: &'a Scene,
    settings: RenderSettings,
    frame: i64,
    crop: Option<Window>,
    method: Method,
    samples: Option<u32>,
    tolerance: Option<f64>,
    progress: &'a (dyn Fn(Progress) + Sync),
    cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> Renderer<'a> {
    /// Creates a renderer of the scene's first frame with the scene's own settings. By default these are
    /// 960 x 540 pixels to a tolerance of 0.02, with light of all orders and a closed shutter.
    pub fn new(scene: &'a Scene) -> Self {
        let settings = scene.settings.clone();
        Self {
            scene,
            frame: *settings.frames.start(),
            settings,
            crop: None,
            method: Method::Auto,
            samples: None,
            tolerance: None,
            progress: Watch::NOBODY.progress,
            cancelled: Watch::NOBODY.cancelled,
        }
    }

    /// Sets the number of the frame. Keys are in seconds: see [`Scene::frame_rate`].
    pub fn frame(mut self, frame: i64) -> Self {
        self.frame = frame;
        self
    }

    /// Sets the size of the whole picture in pixels.
    pub fn size(mut self, width: usize, height: usize) -> Self {
        self.settings.size = Size { width, height };
        self
    }

    /// Sets the part of the picture to render. Its pixels are the same as in the whole picture.
    pub fn crop(mut self, window: Window) -> Self {
        self.crop = Some(window);
        self
    }

    /// Sets the passes beside the beauty, in place of the scene's own.
    pub fn passes(mut self, passes: impl IntoIterator<Item = Pass>) -> Self {
        let mut passes: Vec<Pass> = passes.into_iter().collect();
        passes.sort_unstable();
        passes.dedup();
        self.settings.passes = passes;
        self
    }

    /// Sets the number of samples a pixel; with a tolerance it is the maximum.
    pub fn samples(mut self, samples: u32) -> Self {
        self.samples = Some(samples);
        self
    }

    /// Sets the number of scatterings beyond direct light and single scattering.
    pub fn bounces(mut self, bounces: Bounces) -> Self {
        self.settings.bounces = bounces;
        self
    }

    /// Sets the relative error around every pixel at which samples suffice, `0..=1`.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }

    /// Sets the camera by its name.
    pub fn camera(mut self, name: &str) -> Self {
        self.settings.camera = Some(name.to_owned());
        self
    }

    /// Sets the seed of the noise.
    pub fn seed(mut self, seed: u32) -> Self {
        self.settings.seed = seed;
        self
    }

    /// Sets the reconstruction filter.
    pub fn filter(mut self, filter: PixelFilter) -> Self {
        self.settings.filter = filter;
        self
    }

    /// Sets how long the shutter is open, in frames; 0 is an instant, without motion blur.
    pub fn shutter(mut self, frames: f64) -> Self {
        self.settings.shutter = frames;
        self
    }

    /// Sets the offset from the frame to the middle of the shutter's opening, as a fraction of its length:
    /// 0.5 opens at the frame.
    pub fn shutter_position(mut self, position: f64) -> Self {
        self.settings.shutter_position = position;
        self
    }

    /// Sets whether the picture shows only light that fog scatters, with alpha for what fog hides, in place
    /// of the beauty.
    pub fn shafts_alone(mut self, alone: bool) -> Self {
        self.settings.shafts_alone = alone;
        self
    }

    /// Sets the method: places of samples, and integration of light in fog.
    pub fn method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// Sets a callback for progress, which any thread may call.
    pub fn progress(mut self, progress: &'a (dyn Fn(Progress) + Sync)) -> Self {
        self.progress = progress;
        self
    }

    /// Sets a callback that returns true to stop; rendering then ends with [`RenderError::Cancelled`].
    pub fn cancelled(mut self, cancelled: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.cancelled = cancelled;
        self
    }

    /// Renders the frame.
    ///
    /// # Errors
    /// If a setting is invalid, memory does not suffice, or the frame has NaN or infinity.
    pub fn render(&self) -> Result<Frame, RenderError> {
        let mut sequence = self.sequence([self.frame])?;
        sequence.next().unwrap_or(Err(RenderError::Cancelled))
    }

    /// Renders frames one after the other; [`frame`](Self::frame) has no effect. They share the plan, the
    /// trees, and indirect light while only the camera moves.
    ///
    /// # Errors
    /// If a setting is invalid for any frame, or memory does not suffice.
    pub fn sequence(&self, frames: impl IntoIterator<Item = i64>) -> Result<Sequence<'a>, RenderError> {
        let (plan, frames) = (self.plan()?, Vec::from_iter(frames));
        frames.iter().try_for_each(|&frame| plan.check_frame(frame))?;
        plan.check_memory()?;
        let watch = Watch { progress: self.progress, cancelled: self.cancelled, ..Watch::NOBODY };
        Ok(Sequence { plan, frames: frames.into_iter(), watch })
    }

    /// Plan of all frames.
    #[doc(hidden)]
    pub fn plan(&self) -> Result<Plan<'a>, RenderError> {
        let mut settings = self.settings.clone();
        settings.sampling = Sampling::said(self.samples, self.tolerance).unwrap_or(settings.sampling);
        Plan::new(self.scene, settings, self.crop, self.method)
    }
}
