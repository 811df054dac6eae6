//! Exposure of pictures for viewing. In go the user's and the input's exposure, out comes one for all frames.
//! Invariant: it depends on scene and settings, and not on the requested frames. So pictures do not flicker,
//! and a frame's picture is the same alone and in a range. EXR frames do not depend on it.

use super::arguments::DisplayArguments;
use super::parse::ExposureArgument;
use super::plan::Plan;
use super::tell;
use std::ops::RangeInclusive;
use sunfleck::color::Display;
use sunfleck::render::Watch;
use sunfleck::scene::{RenderSettings, Size};

/// Rows of the picture that measures the exposure, and samples a pixel.
const ROWS: usize = 36;
const SAMPLES: u32 = 4;

/// Maximum aspect of that picture, wide or high.
const LONGEST: f64 = 8.0;

/// Display of all pictures; `measured` returns the automatic exposure, if none is given.
pub(super) fn display<E>(
    arguments: &DisplayArguments,
    of_input: &RenderSettings,
    measured: impl FnOnce() -> Result<f64, E>,
) -> Result<Display, E> {
    let stops = match (arguments.exposure, of_input.exposure_stops) {
        (Some(ExposureArgument::Stops(stops)), _) | (None, Some(stops)) => stops,
        (Some(ExposureArgument::Auto), _) | (None, None) => {
            let stops = measured()?;
            if stops != 0.0 {
                let (by, way) = (stops.abs(), if stops > 0.0 { "brighter" } else { "darker" });
                let plural = if by == 1.0 { "" } else { "s" };
                tell(&format!(
                    "note: pictures are {way} than the light is by {by} stop{plural}, as a camera would expose it (--exposure 0: as it is)"
                ));
            }
            stops
        }
    };
    Ok(arguments.display(stops, of_input.look))
}

/// Frame that measures the exposure: the middle one, as many sequences begin and end in the dark.
pub(super) fn reference_frame(frames: &RangeInclusive<i64>) -> i64 {
    (frames.start() + frames.end()).div_euclid(2)
}

impl Plan<'_> {
    /// Automatic exposure of a small picture of the input's middle frame. Runs on the current rayon pool.
    pub(super) fn auto_exposure_stops(&self, watch: &Watch) -> f64 {
        let middle = reference_frame(&self.picture.settings.frames);
        self.picture.auto_exposure_stops(middle, small(self.picture.job.size), SAMPLES, watch)
    }
}

/// Size of about [`ROWS`] rows with the picture's aspect.
pub(super) fn small(size: Size) -> Size {
    let aspect = (size.width as f64 / size.height as f64).clamp(1.0 / LONGEST, LONGEST);
    let height = ROWS as f64 / aspect.min(1.0).sqrt();
    Size { width: (height * aspect).ceil() as usize, height: height as usize }
}
