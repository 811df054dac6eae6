//! Render settings of a file. In go the scene's extras, out come settings. Invariant: an invalid number is an
//! error at its own JSON path, and all of them are reported.

use super::clock::Clock;
use super::extras::Sunfleck;
use crate::color::Look;
use crate::description::gltf::GltfScene;
use crate::description::gltf::report::Report;
use crate::description::ron::{MAX_FRAME, Range, RelativeError, Stops};
use crate::diagnostic::{Diagnostic, Loss};
use crate::passes::Pass;
use crate::scene::{Bounces, PixelFilter, RenderSettings, Sampling, Size};

/// Render settings in `sunfleck` of the scene's extras.
pub(super) fn settings(
    source: &GltfScene,
    sunfleck: &Sunfleck,
    report: &mut Report,
) -> (RenderSettings, Clock) {
    let mut settings = RenderSettings { camera: sunfleck.camera.clone(), ..RenderSettings::default() };
    if let Some(stem) = source.path.file_stem() {
        settings.name = stem.to_string_lossy().into_owned();
    }
    let clock = Clock::new(source, sunfleck, settings.frame_rate, report);
    settings.frame_rate = clock.frame_rate;
    let mut reading = Reading { scene: source.scene, sunfleck, report };
    reading.frames(&mut settings, clock.animated_frames(source));
    reading.picture(&mut settings);
    reading.passes(&mut settings);
    reading.shutter(&mut settings);
    (settings, clock)
}

/// Extras, and the report of their faults.
struct Reading<'a> {
    scene: usize,
    sunfleck: &'a Sunfleck,
    report: &'a mut Report,
}

impl Reading<'_> {
    fn at(&self, name: &str) -> String {
        format!("scenes[{}].extras.sunfleck.{name}", self.scene)
    }

    fn error(&mut self, name: &str, found: String, expected: &str) {
        let at = self.at(name);
        self.report.error(at, found, expected);
    }

    /// Integer in a range; `min` after a report if it is not one.
    fn whole(&mut self, name: &str, value: f64, min: f64, max: f64) -> f64 {
        if value.fract() == 0.0 && value >= min && value <= max {
            return value;
        }
        self.error(name, format!("{value} is not usable"), &format!("a whole number from {min} to {max}"));
        min
    }

    /// Frames; by default the range of keys.
    fn frames(&mut self, settings: &mut RenderSettings, (first, last): (f64, f64)) {
        let Sunfleck { frame_start, frame_end, .. } = self.sunfleck;
        let most = MAX_FRAME as f64;
        let start = self.whole("frame_start", frame_start.unwrap_or(first), -most, most);
        let end = self.whole("frame_end", frame_end.unwrap_or(last.max(start)), -most, most);
        if end < start {
            self.error("frame_end", format!("frame {end} comes before frame {start}"), "the last frame");
        }
        settings.frames = start as i64..=end as i64;
        settings.only_these_frames = true;
        let is_animated = first < last;
        if is_animated && (end < first || last < start) {
            let found = format!(
                "frames {start} to {end} are to be rendered, and keys lie on frames {first} to {last}"
            );
            let place = self.report.at(self.at("frame_start"));
            self.report.push(Diagnostic::warning(Loss::KeysOutsideFrames, place, found).expected(
                "frames among the keys: before the first and after the last everything keeps still",
            ));
        }
    }

    /// Size, samples, filter and exposure.
    fn picture(&mut self, settings: &mut RenderSettings) {
        let sunfleck = self.sunfleck;
        let samples = sunfleck.samples.map(|samples| self.whole("samples", samples, 1.0, 65536.0) as u32);
        if let Some(seed) = sunfleck.seed {
            settings.seed = self.whole("seed", seed, 0.0, f64::from(u32::MAX)) as u32;
        }
        if let Some(depth) = sunfleck.mirror_depth {
            settings.mirror_depth = self.whole("mirror_depth", depth, 0.0, 64.0) as u32;
        }
        match sunfleck.bounces.as_ref().map(|bounces| (bounces.as_f64(), bounces.as_str())) {
            None => {}
            Some((Some(count), _)) => {
                settings.bounces = Bounces::UpTo(self.whole("bounces", count, 0.0, 64.0) as u32);
            }
            Some((None, Some("all"))) => settings.bounces = Bounces::All,
            Some(_) => self.error(
                "bounces",
                "neither a number nor a word that is known".into(),
                "a whole number from 0 to 64, or \"all\"",
            ),
        }
        if let Some([width, height]) = sunfleck.resolution {
            let width = self.whole("resolution[0]", width, 1.0, 65536.0) as usize;
            let height = self.whole("resolution[1]", height, 1.0, 65536.0) as usize;
            settings.size = Size { width, height };
        }
        let tolerance =
            sunfleck.tolerance.filter(|&tolerance| self.is_usable::<RelativeError>("tolerance", tolerance));
        settings.exposure_stops =
            sunfleck.exposure.filter(|&stops| self.is_usable::<Stops>("exposure", stops));
        settings.sampling = Sampling::said(samples, tolerance).unwrap_or(settings.sampling);
        let look = self.word("look", sunfleck.look.as_deref(), (&Look::ALL, Look::name));
        settings.look = look.unwrap_or(settings.look);
        let filter = self.word("filter", sunfleck.filter.as_deref(), (&PixelFilter::ALL, PixelFilter::name));
        settings.filter = filter.unwrap_or(settings.filter);
    }

    /// Value of a word in a list of words and values; reports an unknown word.
    fn word<T: Copy>(
        &mut self,
        field: &str,
        said: Option<&str>,
        (all, name): (&[T], fn(T) -> &'static str),
    ) -> Option<T> {
        let said = said?;
        let found = all.iter().copied().find(|&one| name(one) == said);
        if found.is_none() {
            let names: Vec<&str> = all.iter().map(|&one| name(one)).collect();
            self.error(field, format!("`{said}` is no {field}"), &format!("one of {}", names.join(", ")));
        }
        found
    }

    /// Whether a number lies in its range; reports one that does not.
    fn is_usable<R: Range>(&mut self, name: &str, value: f64) -> bool {
        let fits = R::contains(value);
        if !fits {
            self.error(name, format!("{value} is not usable"), R::EXPECTED);
        }
        fits
    }

    fn passes(&mut self, settings: &mut RenderSettings) {
        for (index, name) in self.sunfleck.passes.iter().flatten().enumerate() {
            match Pass::named(name) {
                Some(pass) => settings.passes.push(pass),
                None => {
                    let expected = format!("one of {}", Pass::names());
                    self.error(&format!("passes[{index}]"), format!("`{name}` is no pass"), &expected);
                }
            }
        }
        settings.passes.sort_unstable();
        settings.passes.dedup();
    }

    fn shutter(&mut self, settings: &mut RenderSettings) {
        let Some(shutter) = self.sunfleck.shutter else { return };
        if !(0.0..=1000.0).contains(&shutter) {
            self.error("shutter", format!("the shutter is open for {shutter} frames"), "0 to 1000 frames");
            return;
        }
        settings.shutter = shutter;
        let Some(offset) = self.sunfleck.shutter_offset else { return };
        if !(-1000.0..=1000.0).contains(&offset) {
            let found = format!("the shutter opens {offset} frames after the frame");
            self.error("shutter_offset", found, "-1000 to 1000 frames");
            return;
        }
        if shutter > 0.0 {
            settings.shutter_position = offset / shutter + 0.5;
        } else if offset != 0.0 {
            self.report.not_honoured(Loss::ShutterInstant, "sunfleck.shutter_offset");
        }
    }
}
