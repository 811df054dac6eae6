//! Plan of a picture. In go a scene, settings and options, out comes a job with the exposure of any frame.
//! Invariant: a plan that exists is valid. It alone prepares the motion and names that passes need.

use super::error::{RenderError, Setting};
use super::scene::Scene;
use crate::diagnostic::{Diagnostic, Diagnostics, Place};
use crate::film;
use crate::frame_file::Provenance;
use crate::passes::{Needs, Pass, any_needs};
use crate::render::{self, Choice, Job, Method, Rendered, Watch};
use crate::scanline;
use crate::scene::{self, RenderSettings, Sampling, Size, Window, matte_id};
use crate::snapshot::{Exposure, MotionField, Shutter, Snapshot, View};
use crate::transport::MarchSteps;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// 16384 x 8192.
const MOST_PIXELS: usize = 1 << 27;

/// Side in pixels of the square that one ray of a rough preview covers.
const ROUGH_PX: usize = 8;

/// Everything that the frames of a picture share.
pub struct Plan<'scene> {
    /// Scene to render.
    pub scene: &'scene Scene,
    /// Settings as requested.
    pub settings: RenderSettings,
    /// Index into the scene's cameras.
    pub camera: usize,
    /// Settings of each frame.
    pub job: Job,
    /// Requests of the scene that are not honoured in the rendered frames.
    pub remarks: Diagnostics,
}

impl<'scene> Plan<'scene> {
    /// Creates a plan with `settings` for the part inside `crop`.
    pub(super) fn new(
        scene: &'scene Scene,
        settings: RenderSettings,
        crop: Option<Window>,
        method: Method,
    ) -> Result<Self, RenderError> {
        check_size(settings.size)?;
        let camera = find_camera(&scene.resolved, settings.camera.as_deref())?;
        let window = find_window(crop, settings.size)?;
        check_sampling(settings.sampling)?;
        check_shutter(&settings)?;
        check_method(method)?;
        let mut remarks = scene.resolved.remarks.clone();
        remarks.0.extend(Exposure::remark(&scene.resolved, settings.shutter));
        remarks.0.extend(scene.resolved.held_fog(settings.shutter));
        remarks.0.extend(scene.resolved.shared_grid_name());
        let job = Job {
            size: settings.size,
            window,
            passes: settings.passes.clone(),
            sampling: settings.sampling,
            filter: settings.filter,
            seed: settings.seed,
            mirror_depth: settings.mirror_depth,
            bounces: settings.bounces,
            method,
        };
        Ok(Self { scene, settings, camera, job, remarks })
    }

    /// Time interval in which the shutter is open for a frame.
    pub fn shutter(&self, frame: i64) -> Shutter {
        Shutter::of(&self.settings, frame as f64)
    }

    /// Exposure for an interval of the shutter, without what passes need.
    pub fn exposure_of(&self, shutter: Shutter) -> Exposure<'scene> {
        let aspect = aspect(self.job.size);
        Exposure::new(&self.scene.resolved, self.scene.trees(), self.camera, aspect, shutter)
    }

    /// Exposure of a frame, with everything that passes need.
    pub fn exposure(&self, frame: i64) -> Exposure<'scene> {
        let (scene, size) = (&self.scene.resolved, self.job.size);
        let mut exposure = self.exposure_of(self.shutter(frame));
        if self.needs(Needs::Motion) {
            let rate = self.settings.frame_rate;
            let times_s = [-1.0, 0.0, 1.0].map(|offset| rate.seconds(frame as f64 + offset));
            exposure = exposure.with_motion(MotionField::new(scene, self.camera, size, times_s));
        }
        if self.needs(Needs::Names) {
            exposure = exposure.with_mattes(scene);
        }
        exposure
    }

    /// Renders an exposure of this plan on the current rayon pool.
    pub fn render(&self, exposure: &Exposure, watch: &Watch) -> Rendered {
        self.carry_out(&self.job, exposure, watch)
    }

    /// Renders a rough preview of an exposure: one ray for each square of [`ROUGH_PX`] pixels.
    pub fn rough(&self, exposure: &Exposure, watch: &Watch) -> film::Frame {
        let Size { width, height } = self.job.size;
        let size = Size { width: width.div_ceil(ROUGH_PX), height: height.div_ceil(ROUGH_PX) };
        let rendered = self.carry_out(&self.small(size, 1), exposure, watch);
        rendered.frame.enlarged(self.job.size, self.job.window)
    }

    /// Job for a small picture of a frame, of `size` pixels and `samples` a pixel.
    fn small(&self, size: Size, samples: u32) -> Job {
        Job {
            size,
            window: Window::whole(size),
            passes: Vec::new(),
            sampling: Sampling::Exactly(samples),
            method: self.job.method.by_rays(),
            ..self.job.clone()
        }
    }

    fn carry_out(&self, job: &Job, exposure: &Exposure, watch: &Watch) -> Rendered {
        if !self.settings.shafts_alone {
            return render::render_keeping(exposure, job, self.scene.light(), watch);
        }
        let mut needed = vec![Pass::Shafts, Pass::Transmittance];
        needed.retain(|pass| !job.passes.contains(pass));
        let mut passes = [&job.passes[..], &needed].concat();
        passes.sort_unstable();
        let job = Job { passes, ..job.clone() };
        let mut rendered = render::render_keeping(exposure, &job, self.scene.light(), watch);
        rendered.frame.show_shafts_alone();
        rendered.frame.drop_passes(&needed);
        rendered
    }

    /// Default method for a frame, or for a moment between two frames.
    pub fn choice(&self, frame: f64) -> Choice {
        let (scene, shutter) = (&self.scene.resolved, Shutter::of(&self.settings, frame));
        let aspect = aspect(self.job.size);
        render::choose(&Exposure::middle_of(scene, self.scene.trees(), self.camera, aspect, shutter))
    }

    /// Draws a frame without rays and shadows, at `size` pixels in the picture's aspect.
    pub fn draw(&self, frame: i64, size: Size) -> film::Frame {
        let (scene, aspect) = (&self.scene.resolved, aspect(self.job.size));
        let shutter = self.shutter(frame);
        scanline::draw(&Snapshot::new(scene, self.scene.trees(), self.camera, aspect, shutter), size)
    }

    /// Default exposure of pictures for viewing, in stops: that of a small picture of a frame, with `size`
    /// pixels and `samples` a pixel.
    pub fn auto_exposure_stops(&self, frame: i64, size: Size, samples: u32, watch: &Watch) -> f64 {
        let shutter = Shutter::instant(self.shutter(frame).middle_s());
        let (scene, aspect) = (&self.scene.resolved, aspect(self.job.size));
        let exposure = Exposure::middle_of(scene, self.scene.trees(), self.camera, aspect, shutter);
        let small = self.small(size, samples);
        render::render_keeping(&exposure, &small, self.scene.light(), watch).frame.auto_exposure_stops()
    }

    /// Provenance of a frame.
    pub fn provenance(&self, frame: i64) -> Provenance {
        let shutter = self.shutter(frame);
        Provenance {
            frame,
            sequence_frames: (*self.settings.frames.start(), *self.settings.frames.end()),
            frame_rate: self.settings.frame_rate,
            exposure_s: shutter.close_s - shutter.open_s,
            camera_from_world: self.view(frame).camera_from_world(),
            scene_hash: self.scene.content_hash.clone(),
            settings_hash: self.settings_hash(),
            seed: self.job.seed,
            sampling: self.job.sampling,
            owner: None,
            comments: None,
            object_names: self.object_names(),
        }
    }

    /// Refuses a picture for which there is too little memory, as a failed allocation would abort the
    /// process.
    pub fn check_memory(&self) -> Result<(), RenderError> {
        let bytes = self.job.memory_bytes();
        let mut all: Vec<u8> = Vec::new();
        all.try_reserve_exact(bytes).map_err(|_| {
            let Window { width, height, .. } = self.job.window;
            let gigabytes = bytes as f64 / 1e9;
            let found =
                format!("{width} x {height} pixels take {gigabytes:.1} GB, more memory than can be had");
            let diagnostic = Diagnostic::error(Place::Nowhere, found)
                .expected("a picture that fits")
                .remedy("ask for fewer pixels or passes, or render parts of the picture (crop)");
            RenderError::Memory(Box::new(diagnostic))
        })
    }

    /// Refuses a frame that the sequence does not have.
    pub(super) fn check_frame(&self, frame: i64) -> Result<(), RenderError> {
        let RenderSettings { frames, only_these_frames, .. } = &self.settings;
        if *only_these_frames && !frames.contains(&frame) {
            let expected = format!("{} to {}", frames.start(), frames.end());
            return Err(RenderError::setting(Setting::Frame, format!("there is no frame {frame}"), expected));
        }
        Ok(())
    }

    fn needs(&self, what: Needs) -> bool {
        any_needs(&self.job.passes, |needs| needs == what)
    }

    fn view(&self, frame: i64) -> View {
        let time_s = self.shutter(frame).middle_s();
        let camera = &self.scene.resolved.cameras[self.camera];
        let world_from_camera = self.scene.resolved.placement(camera.node, time_s).world_from_node;
        View::new(camera, world_from_camera, aspect(self.job.size), time_s)
    }

    /// Names of the mattes, if the frames have mattes.
    fn object_names(&self) -> BTreeMap<u32, String> {
        let scene = &self.scene.resolved;
        let instances = 0..if self.needs(Needs::Names) { scene.instances.len() } else { 0 };
        let names = instances.map(|instance| scene.matte_name(instance));
        names.map(|name| (matte_id(name), name.to_owned())).collect()
    }

    /// SHA-256 over everything that changes pixels, except the input's files and the frame's number.
    fn settings_hash(&self) -> String {
        let Self { settings, camera, job, .. } = self;
        let options = &self.scene.options;
        // Included only where it has an effect, so that other hashes stay the same.
        let shutter_position = match settings.shutter * settings.shutter_position {
            0.0 => String::new(),
            _ => format!(" {:?}", settings.shutter_position),
        };
        let default_light = if options.no_default_light { " Off" } else { "" };
        let shafts_alone = if settings.shafts_alone { " shafts alone" } else { "" };
        let sky_sun = if options.keep_sky_suns { " sky sun off" } else { "" };
        let animation =
            options.animation.as_ref().map_or(String::new(), |name| format!(" animation {name:?}"));
        let text = format!(
            "{} {:?} {:?} {camera} {:?}{shutter_position}{default_light}{sky_sun}{animation}{shafts_alone}",
            job.hashed(),
            settings.frame_rate,
            settings.shutter,
            options.light_units
        );
        Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
    }
}

fn aspect(size: Size) -> f64 {
    size.width as f64 / size.height as f64
}

/// Refuses a picture without pixels.
fn check_size(size: Size) -> Result<(), RenderError> {
    let Size { width, height } = size;
    if width == 0 || height == 0 {
        let found = format!("{width} x {height} is no picture");
        return Err(RenderError::setting(Setting::Size, found, "at least one pixel"));
    }
    Ok(())
}

/// Camera of the given name, or the first one without a name.
fn find_camera(scene: &scene::Scene, name: Option<&str>) -> Result<usize, RenderError> {
    let Some(name) = name else { return Ok(0) };
    scene.cameras.iter().position(|camera| camera.name == name).ok_or_else(|| {
        let names: Vec<_> = scene.cameras.iter().map(|camera| format!("`{}`", camera.name)).collect();
        let found = format!("there is no camera `{name}`");
        RenderError::setting(Setting::Camera, found, format!("one of {}", names.join(", ")))
    })
}

/// Window to render, unless its film needs more memory than common machines have.
fn find_window(crop: Option<Window>, size: Size) -> Result<Window, RenderError> {
    let window = crop.unwrap_or(Window::whole(size));
    let Window { x, y, width, height } = window;
    let (right, bottom) = (x.saturating_add(width), y.saturating_add(height));
    if width == 0 || height == 0 {
        let found = format!("{width} x {height} is no part of a picture");
        return Err(RenderError::setting(Setting::Crop, found, "at least one pixel"));
    }
    if right > size.width || bottom > size.height {
        let found = format!("{x},{y},{right},{bottom} reaches beyond the picture");
        let expected = format!("x1 up to {} and y1 up to {}", size.width, size.height);
        return Err(RenderError::setting(Setting::Crop, found, expected));
    }
    if width.saturating_mul(height) > MOST_PIXELS {
        let found = format!("{width} x {height} pixels are too many at once");
        let expected = format!("at most {MOST_PIXELS} pixels, or a part of them (crop, by --crop)");
        return Err(RenderError::setting(Setting::Size, found, expected));
    }
    Ok(window)
}

fn check_sampling(sampling: Sampling) -> Result<(), RenderError> {
    let (Sampling::Exactly(samples) | Sampling::Until { most: samples, .. }) = sampling;
    if samples == 0 {
        let found = String::from("no sample shows nothing");
        return Err(RenderError::setting(Setting::Samples, found, "at least 1"));
    }
    match sampling {
        Sampling::Until { tolerance, .. } if !(tolerance > 0.0 && tolerance <= 1.0) => {
            let found = format!("{tolerance} is no relative error");
            Err(RenderError::setting(Setting::Tolerance, found, "more than 0, at most 1"))
        }
        _ => Ok(()),
    }
}

fn check_shutter(settings: &RenderSettings) -> Result<(), RenderError> {
    let RenderSettings { shutter, shutter_position, .. } = *settings;
    if shutter.is_finite() && shutter >= 0.0 && shutter_position.is_finite() {
        return Ok(());
    }
    let found = format!("open for {shutter} frames, at {shutter_position}");
    Err(RenderError::setting(Setting::Shutter, found, "finite numbers, the first of them not negative"))
}

fn check_method(method: Method) -> Result<(), RenderError> {
    let is_good = match method {
        Method::Auto | Method::Slices | Method::Segments | Method::Paths => true,
        Method::March(MarchSteps::Planes { depth_m, step_m }) => {
            depth_m.is_finite() && step_m.is_finite() && depth_m >= 0.0 && step_m > 0.0
        }
        Method::March(MarchSteps::Count(steps) | MarchSteps::Jittered(steps)) => steps > 0,
        Method::Equiangular { points } => points > 0,
    };
    if is_good {
        return Ok(());
    }
    let found = format!("{method:?} takes no step");
    Err(RenderError::setting(Setting::Method, found, "at least one step of a length"))
}
