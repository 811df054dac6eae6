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
    /// The scene's first frame as the scene wants to be rendered.
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

    /// Number of the frame.
    pub fn frame(mut self, frame: i64) -> Self {
        self.frame = frame;
        self
    }

    /// Pixels of the whole picture.
    pub fn size(mut self, width: usize, height: usize) -> Self {
        self.settings.size = Size { width, height };
        self
    }

    /// The part of the picture that is wanted, its pixels the same as in the whole.
    pub fn crop(mut self, window: Window) -> Self {
        self.crop = Some(window);
        self
    }

    /// Pictures beside the beauty, in place of those that the scene asks for.
    pub fn passes(mut self, passes: impl IntoIterator<Item = Pass>) -> Self {
        let mut passes: Vec<Pass> = passes.into_iter().collect();
        passes.sort_unstable();
        passes.dedup();
        self.settings.passes = passes;
        self
    }

    /// Number of samples a pixel; with a tolerance the maximum.
    pub fn samples(mut self, samples: u32) -> Self {
        self.samples = Some(samples);
        self
    }

    /// Number of scatterings beyond direct light and single scattering.
    pub fn bounces(mut self, bounces: Bounces) -> Self {
        self.settings.bounces = bounces;
        self
    }

    /// Relative error around every pixel at which samples suffice, `0..=1`.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = Some(tolerance);
        self
    }

    /// Name of the camera.
    pub fn camera(mut self, name: &str) -> Self {
        self.settings.camera = Some(name.to_owned());
        self
    }

    /// Seed of the noise.
    pub fn seed(mut self, seed: u32) -> Self {
        self.settings.seed = seed;
        self
    }

    /// Reconstruction filter.
    pub fn filter(mut self, filter: PixelFilter) -> Self {
        self.settings.filter = filter;
        self
    }

    /// Time that the shutter is open, in frames; 0 is an instant, without motion blur.
    pub fn shutter(mut self, frames: f64) -> Self {
        self.settings.shutter = frames;
        self
    }

    /// Offset from the frame to the middle of the time that the shutter is open, in parts of it: 0.5 opens
    /// at the frame.
    pub fn shutter_position(mut self, position: f64) -> Self {
        self.settings.shutter_position = position;
        self
    }

    /// Light that fog scatters alone in place of the beauty, with alpha for what fog hides.
    pub fn shafts_alone(mut self, alone: bool) -> Self {
        self.settings.shafts_alone = alone;
        self
    }

    /// Method: places of samples, and light in fog.
    pub fn method(mut self, method: Method) -> Self {
        self.method = method;
        self
    }

    /// Is told now and then how far the frame is, from any thread.
    pub fn progress(mut self, progress: &'a (dyn Fn(Progress) + Sync)) -> Self {
        self.progress = progress;
        self
    }

    /// Tells whether to stop; rendering then ends with [`RenderError::Cancelled`].
    pub fn cancelled(mut self, cancelled: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.cancelled = cancelled;
        self
    }

    /// Renders.
    ///
    /// # Errors
    /// If a wish cannot be met, there is too little memory, or the frame has pixels that are no light.
    pub fn render(&self) -> Result<Frame, RenderError> {
        let mut sequence = self.sequence([self.frame])?;
        sequence.next().unwrap_or(Err(RenderError::Cancelled))
    }

    /// Frames one after the other, whatever [`frame`](Self::frame) says. What they share is made once: the
    /// plan, trees, and light of more than one scattering while only the camera moves.
    ///
    /// # Errors
    /// If a wish cannot be met, of any frame, or there is too little memory.
    pub fn sequence(&self, frames: impl IntoIterator<Item = i64>) -> Result<Sequence<'a>, RenderError> {
        let (plan, frames) = (self.plan()?, Vec::from_iter(frames));
        frames.iter().try_for_each(|&frame| plan.check_frame(frame))?;
        plan.check_memory()?;
        let watch = Watch { progress: self.progress, cancelled: self.cancelled, ..Watch::NOBODY };
        Ok(Sequence { plan, frames: frames.into_iter(), watch })
    }

    /// The plan of all frames.
    #[doc(hidden)]
    pub fn plan(&self) -> Result<Plan<'a>, RenderError> {
        let mut settings = self.settings.clone();
        settings.sampling = Sampling::said(self.samples, self.tolerance).unwrap_or(settings.sampling);
        Plan::new(self.scene, settings, self.crop, self.method)
    }
}
