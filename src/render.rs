//! The loop that joins transport and film. In go an exposure and a job, out comes a frame. Invariant: every
//! picture is a pure function of (exposure, job), independent of the number of threads and of their order.

mod bearings;
mod choice;
mod correction;
mod draws;
mod error_left;
mod grid_error;
mod importance;
mod lattice;
mod layout;
mod map;
mod moments;
mod places;
mod probes;
mod refine;
mod rings;
mod rounds;
mod shares;
mod slices;
mod sum;
mod survey;
mod tiles;
mod watch;

use crate::film::{self, Film, Frame};
use crate::indirect::{Indirect, KeptLight};
use crate::math::{Ray, Sampler};
use crate::passes::{Needs, Pass, any_needs};
use crate::scene::{Bounces, PixelFilter, Sampling, Size, Window};
use crate::snapshot::{Exposure, Snapshot};
use crate::transport::{Component, MarchSteps, OneLight, Transport, VolumeMethod};
pub use choice::{Choice, Reason, choose};
use correction::Correction;
use glam::DVec2;
use grid_error::GridError;
use refine::{Budget, Goal, Refined};
use sum::Sum;
use survey::Survey;
pub use watch::{Look, Progress, Stage, Watch};

/// Settings by which an exposure is rendered.
#[derive(Clone, Debug)]
pub struct Job {
    /// The whole picture.
    pub size: Size,
    /// The wanted part of it.
    pub window: Window,
    /// Passes other than the beauty.
    pub passes: Vec<Pass>,
    /// Number of samples of a pixel.
    pub sampling: Sampling,
    /// Reconstruction filter.
    pub filter: PixelFilter,
    /// Seed of the sample points.
    pub seed: u32,
    /// Maximum number of reflections by mirrors.
    pub mirror_depth: u32,
    /// Maximum number of scatterings after the first.
    pub bounces: Bounces,
    /// Method: places of samples, and light in fog.
    pub method: Method,
}

/// Places of a picture's samples, and the method for light that fog scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// Slices or segments, whichever is cheaper for the frame.
    Auto,
    /// Samples on epipolar slices, each solved as a whole, exactly; one picture for each light, added up.
    /// Segments where the camera has no slices.
    Slices,
    /// Rays in each pixel; a single one goes through its centre. Light in fog is exact along each.
    Segments,
    /// Rays in each pixel, with shadow rays at steps along each.
    March(MarchSteps),
    /// Rays in each pixel, with equiangular shadow rays along each.
    Equiangular {
        /// Points a ray and light, at least 1.
        points: u32,
    },
    /// As `Segments`, with light of more than one scattering by random walks and not from a grid: unbiased
    /// and noisy.
    Paths,
}

impl Method {
    /// Method for light in fog along one ray.
    fn volume(self, bounces: Bounces) -> VolumeMethod {
        match self {
            Self::Auto | Self::Slices | Self::Segments => VolumeMethod::Segments,
            Self::March(steps) => VolumeMethod::March(steps),
            Self::Equiangular { points } => VolumeMethod::Equiangular { points },
            Self::Paths => VolumeMethod::Paths(bounces),
        }
    }

    /// The method as one with a ray for each sample.
    pub fn by_rays(self) -> Self {
        match self {
            Self::Auto | Self::Slices => Self::Segments,
            other => other,
        }
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Slices => "slices",
            Self::Segments => "segments",
            Self::March(_) => "march",
            Self::Equiangular { .. } => "equiangular",
            Self::Paths => "paths",
        }
    }

    /// Whether the frame comes from slices.
    fn takes_slices(self, exposure: &Exposure) -> bool {
        match self {
            Self::Auto => choose(exposure).method == Self::Slices,
            Self::Slices => choice::obstacle(exposure).is_none(),
            Self::Segments | Self::March(_) | Self::Equiangular { .. } | Self::Paths => false,
        }
    }
}

/// A frame, and its statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct Rendered {
    /// The frame.
    pub frame: Frame,
    /// Statistics of the rendering.
    pub statistics: Statistics,
}

/// Statistics of a frame: effort and quality. They are the same for any number of threads.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Statistics {
    /// Samples, over all pixels and components; those of slices count by their worth.
    pub samples: u64,
    /// Number of rounds of the component with the most rounds.
    pub rounds: u32,
    /// Whether it came from slices, each light from its own, or every sample was a ray.
    pub from_slices: bool,
    /// Slices that were solved, over all lights.
    pub slices: u64,
    /// Segments that they gathered: cuts of triangles by their planes.
    pub segments: u64,
    /// Blocks of pixels that were judged.
    pub blocks: usize,
    /// Number of blocks above the tolerance whose pixels have the maximum number of samples.
    pub unconverged_blocks: usize,
    /// Largest estimated relative error of a block, if blocks were judged.
    pub error: Option<f64>,
    /// Error of indirect light, if blocks were judged: root mean square over the picture of twice the
    /// standard error that random walks find, as a share of its mean.
    pub grid_error: Option<f64>,
    /// Whether indirect light is hardly absorbed, so that its series is cut short and the picture too dark.
    pub endless_light: bool,
    /// Noise of the picture, if blocks were judged: the root mean square of the estimated standard error
    /// over all blocks but the hundredth with most of it, as a share of their mean.
    pub noise: Option<f64>,
}

impl Job {
    /// Approximate memory of a picture: the sums of one component, and the frames that they are added to.
    pub fn memory_bytes(&self) -> usize {
        /// Frames in memory: the sum so far, the one that is added to it, and one that is being written.
        const FRAMES: usize = 3;
        // A frame has a channel of four bytes for each of a film's sums of five.
        let of_pixel = Film::bytes_per_pixel(&self.passes);
        self.window.width * self.window.height * (of_pixel + FRAMES * of_pixel * 4 / 5)
    }

    /// Settings by which rays are followed.
    fn transport<'a>(&self, indirect: Option<&'a Indirect>) -> Transport<'a> {
        Transport {
            volume: self.method.volume(self.bounces),
            mirror_depth: self.mirror_depth,
            indirect,
            features: any_needs(&self.passes, |needs| needs != Needs::Light),
        }
    }

    /// The job as text for the hash in frames. It is written out, so that a name in the source can change and
    /// the hash stays the same.
    pub fn hashed(&self) -> String {
        let Self { size, window, passes, sampling, filter, seed, mirror_depth, bounces, method } = self;
        let Transport { volume, features, .. } = self.transport(None);
        let bounces = if *bounces == Bounces::NONE { String::new() } else { format!(", bounces: {bounces}") };
        let placement = match method {
            Method::Auto => "Auto",
            Method::Slices => "Slices",
            Method::Segments | Method::March(_) | Method::Equiangular { .. } | Method::Paths => "Pixels",
        };
        format!(
            "Job {{ size: {size:?}, window: {window:?}, passes: {passes:?}, sampling: {sampling:?}, filter: {filter:?}, \
             seed: {seed}, transport: Transport {{ volume: {volume:?}, mirror_depth: {mirror_depth}, features: {features} }}, \
             placement: {placement}{bounces} }}"
        )
    }

    /// Light of higher orders, if it is computed on a grid.
    fn indirect(&self, exposure: &Exposure, kept: &KeptLight, watch: &Watch) -> Option<Indirect> {
        let wants_grid = self.bounces != Bounces::NONE && self.method != Method::Paths;
        let aspect = self.size.width as f64 / self.size.height as f64;
        if wants_grid { Indirect::new(exposure, self.bounces, aspect, kept, watch.cancelled) } else { None }
    }

    /// The part of the picture on which the wanted part depends.
    fn needed_window(&self) -> Window {
        self.window.grown(film::REACH_PX, self.size)
    }

    /// Whether errors are estimated.
    fn is_judged(&self) -> bool {
        matches!(self.sampling, Sampling::Until { .. }) || self.passes.contains(&Pass::Error)
    }
}

/// Renders on the current rayon pool.
pub fn render(exposure: &Exposure, job: &Job, watch: &Watch) -> Rendered {
    render_keeping(exposure, job, &KeptLight::default(), watch)
}

/// Renders with the kept solution of another picture, where the contents are the same.
pub fn render_keeping(exposure: &Exposure, job: &Job, kept: &KeptLight, watch: &Watch) -> Rendered {
    // First of all, to save memory: the exposure's other moments are frozen when they are used.
    let indirect = watch.timed(Stage::IndirectLight, || job.indirect(exposure, kept, watch));
    let indirect = indirect.as_ref();
    let middle = exposure.middle();
    if job.method.volume(job.bounces) == VolumeMethod::Segments {
        exposure.see_fog(job.size);
    }
    let components = components(exposure, indirect);
    if !job.is_judged() {
        let survey = Survey::omitted(components);
        return add_up(exposure, job, &Light { indirect, survey: &survey, error: None }, watch);
    }
    let (survey, error) = watch.timed(Stage::Walks, || {
        let survey = Survey::new(middle, job, indirect, components);
        let error = indirect.map(|grid| GridError::found(middle, job, grid, &survey, watch.cancelled));
        (survey, error)
    });
    add_up(exposure, job, &Light { indirect, survey: &survey, error: error.as_ref() }, watch)
}

/// Indirect light and estimates of a picture, made before rendering.
struct Light<'a> {
    indirect: Option<&'a Indirect>,
    survey: &'a Survey,
    /// Error of indirect light, where errors are estimated.
    error: Option<&'a GridError>,
}

impl<'a> Light<'a> {
    /// Correction of indirect light, where errors are estimated.
    fn correction(&self) -> Option<&'a Correction> {
        self.error.map(|error| &error.correction)
    }
}

/// Renders the picture's components, and adds them up.
fn add_up(exposure: &Exposure, job: &Job, light: &Light, watch: &Watch) -> Rendered {
    let &Light { indirect, survey, error } = light;
    let mut sum = Sum::default();
    let from_slices = job.method.takes_slices(exposure);
    sum.statistics.from_slices = from_slices;
    sum.statistics.endless_light = indirect.is_some_and(Indirect::is_endless);
    if from_slices {
        let tally = slices::Tally::default();
        let components = survey.components.len();
        // The brightest first: the others are judged by their part of the sum.
        let mut share_so_far = 0.0;
        for (number, (&component, &share)) in survey.components.iter().zip(&survey.shares).enumerate() {
            let range = (number as f64 / components as f64, (number + 1) as f64 / components as f64);
            share_so_far += share;
            let budget = Budget { share, share_so_far, before: sum.estimates() };
            let before = sum.frame();
            let developed = watch.part(range, None, |watch| match component {
                Component::Light(one) => {
                    let picture = slices::LightPicture::new(exposure, job, light, one, &tally);
                    develop(&Watched { picture, job, before }, job, survey, &budget, watch)
                }
                component => {
                    let picture = tiles::RayPicture::new(exposure, job, light, component);
                    develop(&Watched { picture, job, before }, job, survey, &budget, watch)
                }
            });
            sum.add(developed);
        }
        (sum.statistics.slices, sum.statistics.segments) = tally.totals();
    } else {
        let picture = tiles::RayPicture::new(exposure, job, light, Component::All);
        let picture = Watched { picture, job, before: None };
        sum.add(develop(&picture, job, survey, &Budget::WHOLE, watch));
    }
    sum.finish(job, survey, error)
}

/// Components whose sum is the picture: that of each light, and that of the sky if it lights anything and
/// indirect light does not include it. Without any, one component has emission and indirect light.
fn components(exposure: &Exposure, indirect: Option<&Indirect>) -> Vec<Component> {
    // The rest belongs to one of the lights: as a component of its own it would trace the same rays again.
    let lights = (0..exposure.middle().lights.len())
        .map(|number| Component::Light(OneLight { number, with_rest: number == 0 }));
    let has_sky = exposure.has_sky_light() && !indirect.is_some_and(Indirect::has_sky);
    let components: Vec<_> = lights.chain(has_sky.then_some(Component::Sky)).collect();
    if components.is_empty() { vec![Component::All] } else { components }
}

/// The ray of a sample at a place of the picture, in pixels, and the snapshot of its moment.
fn camera_ray<'a, 'scene>(
    exposure: &'a Exposure<'scene>,
    size: Size,
    film_px: DVec2,
    sampler: &mut Sampler,
) -> (&'a Snapshot<'scene>, Ray) {
    let snapshot = if exposure.is_instant() { exposure.middle() } else { exposure.at(sampler.next_1d()) };
    let view = &snapshot.view;
    let lens_point = if view.has_lens() { view.lens_point(sampler.next_2d().into()) } else { DVec2::ZERO };
    let ray = view.ray_from(lens_point, film_px.x / size.width as f64, film_px.y / size.height as f64);
    (snapshot, ray)
}

/// A picture that shows its rounds to an observer.
struct Watched<'a, P> {
    picture: P,
    job: &'a Job,
    /// Sum of the components before.
    before: Option<&'a Frame>,
}

impl<P: rounds::Picture> rounds::Picture for Watched<'_, P> {
    fn film(&self, job: &Job, window: Window) -> Film {
        self.picture.film(job, window)
    }

    fn convergence(&self) -> f64 {
        self.picture.convergence()
    }

    fn fewest_samples(&self) -> u32 {
        self.picture.fewest_samples()
    }

    fn add_round(&self, round: &rounds::Round, film: &mut Film, watch: &Watch) {
        self.picture.add_round(round, film, watch);
        if let Some(look) = watch.look {
            look(&|| {
                let mut so_far = film.look();
                if let Some(before) = self.before {
                    so_far.add_light(before);
                }
                so_far.part(self.job.window)
            });
        }
    }

    fn fill_holes(&self, film: &mut Film, watch: &Watch) {
        self.picture.fill_holes(film, watch);
    }
}

/// Renders a component and returns it with its estimates.
fn develop(
    picture: &impl rounds::Picture,
    job: &Job,
    survey: &Survey,
    budget: &Budget,
    watch: &Watch,
) -> Refined {
    match job.sampling {
        Sampling::Exactly(_) => refine::once(picture, job, watch),
        Sampling::Until { tolerance, most } => {
            refine::refine(picture, job, &Goal { tolerance, most, survey, budget }, watch)
        }
    }
}
