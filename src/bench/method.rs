//! The compared methods, with their efforts. In goes a method and an effort, out comes a picture. Invariant:
//! all methods render the same scene to the same film.

use crate::film::Frame;
use crate::render::{self, Job, Watch, render};
use crate::scene::{Bounces, PixelFilter, Sampling, Size, Window};
use crate::snapshot::{Exposure, Snapshot};
use crate::transport::MarchSteps;
use clap::ValueEnum;
use cpu_time::ProcessTime;

/// A way to make the picture; the baselines come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Every pixel against every triangle at every step of the image plane: where this renderer came from.
    Literal,
    /// Shadow rays at equal steps, through a tree.
    March,
    /// Shadow rays at equal steps, moved by a random part of a step.
    MarchJittered,
    /// Shadow rays at points spread evenly over the angle seen from the light.
    Equiangular,
    /// Exact visibility intervals along every ray.
    Segments,
    /// Exact, on epipolar slices.
    Slices,
    /// Exact, on epipolar slices, to a tolerance: samples where they are needed.
    SlicesUntil,
    /// Light of all orders by random walks: unbiased and noisy.
    Paths,
}

/// Effort of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Maximum number of samples a pixel.
    pub samples: u32,
    /// Shadow rays for each sample and light; `None` for the exact methods.
    pub steps: Option<u32>,
    /// Estimated relative error at which a block of pixels is finished; `None` if every pixel has all
    /// samples.
    pub tolerance: Option<f64>,
}

impl Effort {
    /// Effort of so many samples in every pixel, without further parameters.
    pub fn of_samples(samples: u32) -> Self {
        Self { samples, steps: None, tolerance: None }
    }

    /// Work relative to that of another effort of the same method, approximate.
    pub(super) fn work(&self) -> f64 {
        // Errors fall faster than with the root of the samples, so this overestimates rather than
        // underestimates.
        let samples = self.tolerance.map_or(f64::from(self.samples), |tolerance| tolerance.powi(-2));
        samples * f64::from(self.steps.unwrap_or(1))
    }
}

/// Input that all pictures share.
#[derive(Clone, Copy)]
pub struct Stage<'a> {
    /// The scene while the shutter is open.
    pub exposure: &'a Exposure<'a>,
    /// Picture size.
    pub size: Size,
    /// Maximum number of reflections of a ray.
    pub mirror_depth: u32,
    /// Maximum number of scatterings after the first.
    pub bounces: Bounces,
    /// Depth that the literal method moves its image plane to, and its step, metres.
    pub planes: (f64, f64),
}

impl<'a> Stage<'a> {
    /// The scene in the middle of the shutter.
    pub fn snapshot(&self) -> &'a Snapshot<'a> {
        self.exposure.middle()
    }

    /// Method of the reference, without bias: rays, or random walks where light is scattered more than once.
    pub(super) fn unbiased(&self) -> Method {
        if self.bounces == Bounces::NONE { Method::Segments } else { Method::Paths }
    }
}

impl Method {
    /// Name on the command line and in tables.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// Whether it can render so many bounces: steps along the image plane have single scattering alone, and
    /// walks without bounces are rays.
    pub fn makes(self, bounces: Bounces) -> bool {
        match self {
            Self::Literal => bounces == Bounces::NONE,
            Self::Paths => bounces != Bounces::NONE,
            _ => true,
        }
    }

    /// All efforts of at most so many samples a pixel, from cheap to expensive.
    pub(super) fn ladder(self, most_samples: u32) -> Vec<Effort> {
        let powers = |base: u32, highest: u32| {
            (0..).map(move |n| base.pow(n)).take_while(move |&p| p <= highest.min(most_samples))
        };
        let grid = |steps: [u32; 4]| {
            let mut efforts: Vec<Effort> = powers(4, 1024)
                .flat_map(|samples| {
                    steps.map(|steps| Effort { samples, steps: Some(steps), tolerance: None })
                })
                .collect();
            efforts.sort_by(|a, b| a.work().total_cmp(&b.work()));
            efforts
        };
        match self {
            Self::Literal => Vec::new(),
            Self::March | Self::MarchJittered => grid([4, 16, 64, 256]),
            Self::Equiangular => grid([1, 4, 16, 64]),
            Self::Segments | Self::Slices | Self::Paths => powers(2, 4096).map(Effort::of_samples).collect(),
            Self::SlicesUntil => (1..10)
                .map(|n| Effort {
                    tolerance: Some(0.5_f64.powi(n)),
                    ..Effort::of_samples(most_samples.min(Sampling::MOST))
                })
                .collect(),
        }
    }

    fn of_render(self, effort: Effort, stage: &Stage) -> render::Method {
        let steps = effort.steps.unwrap_or(1);
        match self {
            Self::Literal => {
                let (depth_m, step_m) = stage.planes;
                render::Method::March(MarchSteps::Planes { depth_m, step_m })
            }
            Self::March => render::Method::March(MarchSteps::Count(steps)),
            Self::MarchJittered => render::Method::March(MarchSteps::Jittered(steps)),
            Self::Equiangular => render::Method::Equiangular { points: steps },
            Self::Segments => render::Method::Segments,
            Self::Slices | Self::SlicesUntil => render::Method::Slices,
            Self::Paths => render::Method::Paths,
        }
    }

    /// Renders a picture on the current rayon pool. The literal method's is rendered with a tree, which gives
    /// the same picture faster.
    pub fn picture(self, stage: &Stage, effort: Effort, seed: u32) -> Frame {
        let job = Job {
            size: stage.size,
            window: Window::whole(stage.size),
            passes: Vec::new(),
            sampling: match effort.tolerance {
                Some(tolerance) => Sampling::Until { tolerance, most: effort.samples },
                None => Sampling::Exactly(effort.samples),
            },
            filter: PixelFilter::Box,
            seed,
            mirror_depth: stage.mirror_depth,
            bounces: stage.bounces,
            method: self.of_render(effort, stage),
        };
        render(stage.exposure, &job, &Watch::NOBODY).frame
    }
}

/// Runs `work`; returns its result, and the processor time of the whole process meanwhile, seconds.
pub fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let started = ProcessTime::now();
    let result = work();
    (result, started.elapsed().as_secs_f64())
}
