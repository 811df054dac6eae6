//! Frames, rate and size, and the true times of keys. Invariant: a key that Blender set on a whole
//! frame gets exactly that frame's time.

use super::extras::Sunfleck;
use crate::description::gltf::GltfScene;
use crate::description::gltf::report::Report;
use crate::diagnostic::{Diagnostic, Loss};
use crate::passes::Pass;
use crate::scene::{FrameRate, PixelFilter, RenderSettings, Sampling, Size};

/// Frames a second of a file that does not say.
const DEFAULT_FPS: u32 = 24;
/// Frame rates as near to a fraction as this are that fraction: Blender stores them in single precision.
const RATE_TOLERANCE: f64 = 1e-6;
/// Largest frame number, so that frame times keep sub-frame digits in single precision.
const MAX_FRAME: f64 = 1e7;

/// Turns key times of the file into true seconds.
pub(super) struct Clock {
    frame_rate: FrameRate,
    /// Frames a second by which the exporter divided, if that was the wrong number.
    exporter_fps: Option<f64>,
}

impl Clock {
    /// The true time of a key, seconds.
    pub(super) fn seconds(&self, key_time_s: f32) -> f64 {
        let time_s = f64::from(key_time_s);
        let Some(exporter_fps) = self.exporter_fps else { return time_s };
        let frame = time_s * exporter_fps;
        let whole = frame.round();
        let rounding = 4.0 * f64::from(f32::EPSILON) * whole.abs();
        self.frame_rate.seconds(if (frame - whole).abs() <= rounding { whole } else { frame })
    }
}

/// How the file wants to be rendered.
pub(super) fn settings(
    source: &GltfScene,
    sunfleck: &Sunfleck,
    report: &mut Report,
) -> (RenderSettings, Clock) {
    let at = |name: &str| format!("scenes[{}].extras.sunfleck.{name}", source.scene);
    let mut settings = RenderSettings { camera: sunfleck.camera.clone(), ..RenderSettings::default() };
    if let Some(stem) = source.path.file_stem() {
        settings.name = stem.to_string_lossy().into_owned();
    }

    let fps_base = sunfleck.fps_base.unwrap_or(1.0);
    let mut exporter_fps = None;
    match sunfleck.fps {
        Some(fps) => match as_given(fps, fps_base).or_else(|| frame_rate(fps / fps_base)) {
            Some(rate) if fps_base > 0.0 => {
                settings.frame_rate = rate;
                let by_blender = source.generator.contains("Blender");
                if fps_base != 1.0
                    && by_blender
                    && !(source.channels.is_empty() && source.properties.is_empty())
                {
                    exporter_fps = Some(fps * fps_base);
                    report.push(Diagnostic::note(
                        report.at(at("fps_base")),
                        "Blender's exporter multiplies by fps_base where it should divide: key times are put right",
                    ));
                }
            }
            _ => report.error(
                at("fps"),
                format!("{fps} over {fps_base} is no frame rate"),
                "two numbers above 0",
            ),
        },
        None => report.push(
            Diagnostic::note(
                report.at(format!("scenes[{}].extras", source.scene)),
                format!("the file does not say its frame rate, {DEFAULT_FPS} frames a second are assumed"),
            )
            .remedy("give --fps, or the scene in Blender a custom property `sunfleck` with fps and fps_base"),
        ),
    }
    let clock = Clock { frame_rate: settings.frame_rate, exporter_fps };

    let (first, last) = animated_frames(source, &clock);
    let mut whole = |name: &str, value: f64, min: f64, max: f64| {
        let fits = value.fract() == 0.0 && value >= min && value <= max;
        if !fits {
            report.error(
                at(name),
                format!("{value} is not usable"),
                &format!("a whole number from {min} to {max}"),
            );
        }
        if fits { value } else { min }
    };
    let start = whole("frame_start", sunfleck.frame_start.unwrap_or(first), -MAX_FRAME, MAX_FRAME);
    let end = whole("frame_end", sunfleck.frame_end.unwrap_or(last.max(start)), -MAX_FRAME, MAX_FRAME);
    let samples = sunfleck.samples.map(|samples| whole("samples", samples, 1.0, 65536.0) as u32);
    if let Some(seed) = sunfleck.seed {
        settings.seed = whole("seed", seed, 0.0, f64::from(u32::MAX)) as u32;
    }
    if let Some(depth) = sunfleck.mirror_depth {
        settings.mirror_depth = whole("mirror_depth", depth, 0.0, 64.0) as u32;
    }
    if let Some([width, height]) = sunfleck.resolution {
        let width = whole("resolution[0]", width, 1.0, 65536.0) as usize;
        let height = whole("resolution[1]", height, 1.0, 65536.0) as usize;
        settings.size = Size { width, height };
    }
    let tolerance = sunfleck.tolerance.filter(|&tolerance| {
        let fits = 0.0 < tolerance && tolerance <= 1.0;
        if !fits {
            let expected = "a relative error greater than 0 and at most 1, such as 0.02 for 2 %";
            report.error(at("tolerance"), format!("{tolerance} is not usable"), expected);
        }
        fits
    });
    settings.exposure_stops = sunfleck.exposure.filter(|&stops| {
        let fits = stops.abs() <= 100.0;
        if !fits {
            let expected = "powers of two from -100 to 100, such as 1 for twice as bright";
            report.error(at("exposure"), format!("{stops} is not usable"), expected);
        }
        fits
    });
    settings.sampling = Sampling::said(samples, tolerance).unwrap_or(settings.sampling);
    if end < start {
        report.error(at("frame_end"), format!("frame {end} comes before frame {start}"), "the last frame");
    }
    settings.frames = start as i64..=end as i64;
    settings.only_these_frames = true;
    let is_animated = first < last;
    if is_animated && (end < first || last < start) {
        let found =
            format!("frames {start} to {end} are to be rendered, and keys lie on frames {first} to {last}");
        report.push(
            Diagnostic::warning(Loss::KeysOutsideFrames, report.at(at("frame_start")), found).expected(
                "frames among the keys: before the first and after the last everything keeps still",
            ),
        );
    }
    if let Some(name) = &sunfleck.filter {
        match PixelFilter::ALL.into_iter().find(|filter| filter.name() == name) {
            Some(filter) => settings.filter = filter,
            None => report.error(
                at("filter"),
                format!("`{name}` is no filter"),
                &format!("one of {}", PixelFilter::ALL.map(PixelFilter::name).join(", ")),
            ),
        }
    }
    read_passes(sunfleck, &mut settings, at, report);
    read_shutter(sunfleck, &mut settings, at, report);
    (settings, clock)
}

fn read_passes(
    sunfleck: &Sunfleck,
    settings: &mut RenderSettings,
    at: impl Fn(&str) -> String,
    report: &mut Report,
) {
    for (index, name) in sunfleck.passes.iter().flatten().enumerate() {
        match Pass::named(name) {
            Some(pass) => settings.passes.push(pass),
            None => report.error(
                format!("{}[{index}]", at("passes")),
                format!("`{name}` is no pass"),
                &format!("one of {}", Pass::names()),
            ),
        }
    }
    settings.passes.sort_unstable();
    settings.passes.dedup();
}

fn read_shutter(
    sunfleck: &Sunfleck,
    settings: &mut RenderSettings,
    at: impl Fn(&str) -> String,
    report: &mut Report,
) {
    let Some(shutter) = sunfleck.shutter else { return };
    if !(0.0..=1000.0).contains(&shutter) {
        report.error(at("shutter"), format!("the shutter is open for {shutter} frames"), "0 to 1000 frames");
        return;
    }
    settings.shutter = shutter;
    let Some(offset) = sunfleck.shutter_offset else { return };
    if !(-1000.0..=1000.0).contains(&offset) {
        let found = format!("the shutter opens {offset} frames after the frame");
        report.error(at("shutter_offset"), found, "-1000 to 1000 frames");
        return;
    }
    if shutter > 0.0 {
        settings.shutter_position = offset / shutter + 0.5;
    } else if offset != 0.0 {
        report.not_honoured(Loss::ShutterInstant, "sunfleck.shutter_offset");
    }
}

/// First and last frame that a key is on; frame 1 if nothing moves.
fn animated_frames(source: &GltfScene, clock: &Clock) -> (f64, f64) {
    let rate = f64::from(clock.frame_rate.numerator) / f64::from(clock.frame_rate.denominator);
    let of_nodes = source.channels.iter().map(|channel| &channel.times_s);
    let of_others = source.properties.iter().map(|channel| &channel.times_s);
    let mut frames = of_nodes
        .chain(of_others)
        .filter(|times_s| times_s.len() > 1)
        .flat_map(|times_s| times_s.first().into_iter().chain(times_s.last()))
        .map(|&time_s| (clock.seconds(time_s) * rate).round());
    let Some(any) = frames.next() else { return (1.0, 1.0) };
    frames.fold((any, any), |(first, last), frame| (first.min(frame), last.max(frame)))
}

/// The rate of two whole numbers.
fn as_given(fps: f64, fps_base: f64) -> Option<FrameRate> {
    let is_whole = |number: f64| number.fract() == 0.0 && (1.0..=1e6).contains(&number);
    (is_whole(fps) && is_whole(fps_base))
        .then_some(FrameRate { numerator: fps as u32, denominator: fps_base as u32 })
}

/// The fraction that is meant by a number of frames a second: whole, a broadcast rate (a multiple of
/// 1000/1001), or the simplest.
fn frame_rate(fps: f64) -> Option<FrameRate> {
    if !(fps.is_finite() && fps > 1e-3 && fps < 1e6) {
        return None;
    }
    let near =
        |numerator: f64, denominator: f64| (numerator / denominator / fps - 1.0).abs() < RATE_TOLERANCE;
    let broadcast = (fps * 1.001).round() * 1000.0;
    let (numerator, denominator) = if near(fps.round(), 1.0) {
        (fps.round(), 1.0)
    } else if near(broadcast, 1001.0) {
        (broadcast, 1001.0)
    } else {
        (2..=1000)
            .map(f64::from)
            .map(|denominator| ((fps * denominator).round(), denominator))
            .find(|&(numerator, denominator)| near(numerator, denominator))
            .unwrap_or(((fps * 1000.0).round(), 1000.0))
    };
    (numerator >= 1.0).then_some(FrameRate { numerator: numerator as u32, denominator: denominator as u32 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_rates_are_the_fractions_that_are_meant() {
        let cases = [
            (24.0, (24, 1)),
            (24.0 / f64::from(1.001_f32), (24000, 1001)),
            (29.97, (2997, 100)),
            (60.0 / 1.001, (60000, 1001)),
            (12.5, (25, 2)),
            (0.5, (1, 2)),
        ];
        for (fps, (numerator, denominator)) in cases {
            assert_eq!(frame_rate(fps), Some(FrameRate { numerator, denominator }), "{fps}");
        }
        for fps in [0.0, -24.0, f64::NAN, f64::INFINITY, 1e9] {
            assert_eq!(frame_rate(fps), None, "{fps}");
        }
    }

    #[test]
    fn keys_on_whole_frames_get_the_frames_own_time() {
        let frame_rate = FrameRate { numerator: 24000, denominator: 1001 };
        let base = f64::from(1.001_f32);
        let clock = Clock { frame_rate, exporter_fps: Some(24.0 * base) };
        for frame in (0..100_000).step_by(37) {
            let frame = f64::from(frame);
            assert_eq!(clock.seconds((frame / (24.0 * base)) as f32), frame_rate.seconds(frame));
        }
    }
}
