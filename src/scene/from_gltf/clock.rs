//! Frame rates, and true times of keys. In go key times of a file, out come seconds. Invariant: a key that
//! Blender set on a whole frame has exactly that frame's time.

use super::extras::Sunfleck;
use crate::description::gltf::GltfScene;
use crate::description::gltf::report::Report;
use crate::description::ron::MAX_FRAME;
use crate::diagnostic::Diagnostic;
use crate::scene::FrameRate;

/// Default frame rate.
const DEFAULT_FPS: u32 = 24;
/// Tolerance of frame rates for simple fractions: Blender stores them in single precision.
const RATE_TOLERANCE: f64 = 1e-6;

/// Conversion of the file's key times to true seconds.
pub(super) struct Clock {
    pub(super) frame_rate: FrameRate,
    /// Frame rate by which the exporter divided, if it differs from the true one.
    exporter_fps: Option<f64>,
    /// Frame at second 0 of the file, whose keys have no negative times.
    frame_at_zero: f64,
}

impl Clock {
    /// Clock of the frame rate in the scene's extras, or else of `default`.
    pub(super) fn new(
        source: &GltfScene,
        sunfleck: &Sunfleck,
        default: FrameRate,
        report: &mut Report,
    ) -> Self {
        let none = Self { frame_rate: default, exporter_fps: None, frame_at_zero: 0.0 };
        let extras = format!("scenes[{}].extras", source.scene);
        let Some(fps) = sunfleck.fps else {
            let found =
                format!("the file does not say its frame rate, {DEFAULT_FPS} frames a second are assumed");
            report.push(Diagnostic::note(report.at(extras), found).remedy(
                "give --fps, or the scene in Blender a custom property `sunfleck` with fps and fps_base",
            ));
            return none;
        };
        let fps_base = sunfleck.fps_base.unwrap_or(1.0);
        let rate = as_given(fps, fps_base).or_else(|| frame_rate(fps / fps_base));
        let Some(frame_rate) = rate.filter(|_| fps_base > 0.0) else {
            let found = format!("{fps} over {fps_base} is no frame rate");
            report.error(format!("{extras}.sunfleck.fps"), found, "two numbers above 0");
            return none;
        };
        let is_animated = !source.channels.is_empty();
        let is_wrong = fps_base != 1.0 && source.generator.contains("Blender") && is_animated;
        if is_wrong {
            report.push(Diagnostic::note(
                report.at(format!("{extras}.sunfleck.fps_base")),
                "Blender's exporter multiplies by fps_base where it should divide: key times are put right",
            ));
        }
        let frame_at_zero = sunfleck.frame_at_zero.unwrap_or(0.0);
        if frame_at_zero.fract() != 0.0 || frame_at_zero.abs() > MAX_FRAME as f64 {
            let found = format!("{frame_at_zero} is no frame to count from");
            report.error(format!("{extras}.sunfleck.frame_at_zero"), found, "a whole number");
            return none;
        }
        Self { frame_rate, exporter_fps: is_wrong.then_some(fps * fps_base), frame_at_zero }
    }

    /// First and last frame with a key; frame 1 without animation.
    pub(super) fn animated_frames(&self, source: &GltfScene) -> (f64, f64) {
        let rate = f64::from(self.frame_rate.numerator) / f64::from(self.frame_rate.denominator);
        let mut frames = source
            .channels
            .iter()
            .map(|channel| &channel.times_s)
            .filter(|times_s| times_s.len() > 1)
            .flat_map(|times_s| times_s.first().into_iter().chain(times_s.last()))
            .map(|&time_s| (self.seconds(time_s) * rate).round());
        let Some(any) = frames.next() else { return (1.0, 1.0) };
        frames.fold((any, any), |(first, last), frame| (first.min(frame), last.max(frame)))
    }

    /// True time of a key, seconds.
    pub(super) fn seconds(&self, key_time_s: f32) -> f64 {
        let time_s = f64::from(key_time_s);
        let rate = f64::from(self.frame_rate.numerator) / f64::from(self.frame_rate.denominator);
        let frames_per_s = match self.exporter_fps {
            Some(exporter_fps) => exporter_fps,
            None if self.frame_at_zero != 0.0 => rate,
            None => return time_s,
        };
        let frame = time_s * frames_per_s;
        let whole = frame.round();
        let rounding = 4.0 * f64::from(f32::EPSILON) * whole.abs();
        let frame = if (frame - whole).abs() <= rounding { whole } else { frame };
        self.frame_rate.seconds(frame + self.frame_at_zero)
    }
}

/// Frame rate of two whole numbers.
fn as_given(fps: f64, fps_base: f64) -> Option<FrameRate> {
    let is_whole = |number: f64| number.fract() == 0.0 && (1.0..=1e6).contains(&number);
    (is_whole(fps) && is_whole(fps_base))
        .then_some(FrameRate { numerator: fps as u32, denominator: fps_base as u32 })
}

/// Fraction of a frame rate: whole, a broadcast rate (a multiple of 1000/1001), or the simplest.
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
        let clock = Clock { frame_rate, exporter_fps: Some(24.0 * base), frame_at_zero: 0.0 };
        for frame in (0..100_000).step_by(37) {
            let frame = f64::from(frame);
            assert_eq!(clock.seconds((frame / (24.0 * base)) as f32), frame_rate.seconds(frame));
        }
    }

    #[test]
    fn frames_may_be_counted_from_below_zero() {
        let frame_rate = FrameRate { numerator: 24000, denominator: 1001 };
        let clock = Clock { frame_rate, exporter_fps: None, frame_at_zero: -100.0 };
        for frame in -100..1000 {
            let key_time_s = frame_rate.seconds(f64::from(frame + 100)) as f32;
            assert_eq!(clock.seconds(key_time_s), frame_rate.seconds(f64::from(frame)));
        }
    }
}
