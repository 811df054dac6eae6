//! Render settings of a scene: frames, rate, size, passes, samples. In go values of files and options, out
//! come settings. Invariant: frame times are computed from integers, never accumulated.

use crate::color::Look;
pub use crate::description::ron::{Bounces, FrameRate, PixelFilter};
use crate::passes::Pass;
use std::fmt;
use std::ops::RangeInclusive;

impl Default for FrameRate {
    fn default() -> Self {
        Self { numerator: 24, denominator: 1 }
    }
}

impl FrameRate {
    /// Time of a frame, in seconds: `frame * denominator / numerator`.
    pub fn seconds(self, frame: f64) -> f64 {
        frame * f64::from(self.denominator) / f64::from(self.numerator)
    }

    /// Frame at a time in seconds; need not be an integer.
    pub fn frame(self, time_s: f64) -> f64 {
        time_s * f64::from(self.numerator) / f64::from(self.denominator)
    }
}

/// Picture size in pixels, both at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// A rectangle of pixels of the full picture, y downwards (EXR: the data window).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Window {
    /// Window of a whole picture.
    pub fn whole(full: Size) -> Self {
        Self { x: 0, y: 0, width: full.width, height: full.height }
    }

    /// Index of pixel (`x`, `y`) of the full picture in a channel; `None` outside the window.
    pub fn index(self, x: usize, y: usize) -> Option<usize> {
        let (column, row) = (x.checked_sub(self.x)?, y.checked_sub(self.y)?);
        // The index could overflow far outside.
        (column < self.width && row < self.height).then(|| row * self.width + column)
    }

    /// Pixel of the full picture at `index` in a channel.
    pub fn pixel(self, index: usize) -> (usize, usize) {
        (self.x + index % self.width, self.y + index / self.width)
    }

    /// Pixel and its neighbours, up to eight.
    pub fn around(self, x: usize, y: usize) -> impl Iterator<Item = (usize, usize)> {
        let near =
            |at: usize, from: usize, count: usize| at.saturating_sub(1).max(from)..(at + 2).min(from + count);
        let columns = near(x, self.x, self.width);
        near(y, self.y, self.height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
    }

    /// Window with its neighbouring pixels, inside the picture.
    pub fn with_rim(self, full: Size) -> Self {
        let near = |from: usize, count: usize, all: usize| {
            let first = from.saturating_sub(1);
            (first, (from + count + 1).min(all) - first)
        };
        let (x, width) = near(self.x, self.width, full.width);
        let (y, height) = near(self.y, self.height, full.height);
        Self { x, y, width, height }
    }

    /// Window grown by `px` pixels, inside the picture.
    pub fn grown(self, px: usize, full: Size) -> Self {
        (0..px).fold(self, |window, _| window.with_rim(full))
    }

    /// Pixels in the order of a channel's values.
    pub fn pixels(self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.width * self.height).map(move |index| self.pixel(index))
    }
}

/// Number of samples a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// Exactly this many, at least 1.
    Exactly(u32),
    /// Until the estimated relative error of the pixel's block is at most `tolerance`.
    Until {
        /// Relative error, more than 0, at most 1.
        tolerance: f64,
        /// Maximum number of samples a pixel, at least 1.
        most: u32,
    },
}

impl Sampling {
    /// Default maximum number of samples with a tolerance. The error of edges falls about with the power -3/4
    /// of the number, so that an error of 4 % at eight samples falls below 0.1 %.
    pub const MOST: u32 = 1024;

    /// Sampling from a number of samples, a tolerance, both or neither. Each level of settings replaces both:
    /// an exact number of a lower level is not a limit for a tolerance.
    pub fn said(samples: Option<u32>, tolerance: Option<f64>) -> Option<Self> {
        match (samples, tolerance) {
            (None, None) => None,
            (Some(samples), None) => Some(Self::Exactly(samples)),
            (most, Some(tolerance)) => Some(Self::Until { tolerance, most: most.unwrap_or(Self::MOST) }),
        }
    }
}

impl fmt::Display for Sampling {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exactly(samples) => write!(f, "{samples} samples a pixel"),
            Self::Until { tolerance, most } => {
                write!(f, "to a relative error of {tolerance} by at most {most} samples a pixel")
            }
        }
    }
}

impl PixelFilter {
    /// All filters.
    pub const ALL: [Self; 2] = [Self::Box, Self::BlackmanHarris];

    /// Name on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::BlackmanHarris => "blackman-harris",
        }
    }
}

impl Bounces {
    /// Direct light and single scattering alone.
    pub const NONE: Self = Self::UpTo(0);

    /// Orders of scattering; `None` means all.
    pub fn orders(self) -> Option<u32> {
        match self {
            Self::UpTo(count) => Some(count),
            Self::All => None,
        }
    }
}

impl fmt::Display for Bounces {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::UpTo(count) => write!(f, "{count}"),
            Self::All => f.write_str("all"),
        }
    }
}

/// Settings of the input; the command line overrides them.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Name of the sequence, and of the output: by default the file's stem.
    pub name: String,
    /// Frames a second.
    pub frame_rate: FrameRate,
    /// First and last frame.
    pub frames: RangeInclusive<i64>,
    /// Whether other frames do not exist. A scene without a sequence has any frame; the range is then a
    /// default.
    pub only_these_frames: bool,
    /// Picture size.
    pub size: Size,
    /// Name of the camera; `None` is the first.
    pub camera: Option<String>,
    /// Number of samples of a pixel.
    pub sampling: Sampling,
    /// Reconstruction filter.
    pub filter: PixelFilter,
    /// Passes beside the beauty.
    pub passes: Vec<Pass>,
    /// Whether shafts alone replace the beauty.
    pub shafts_alone: bool,
    /// Seed of the sample points.
    pub seed: u32,
    /// Time for which the shutter is open, in frames; 0 is an instant.
    pub shutter: f64,
    /// Offset from the frame to the middle of that time, in parts of it: 0 is centred on the frame, 0.5
    /// opens at it.
    pub shutter_position: f64,
    /// Exposure of pictures for viewing in stops, -100 to 100; `None` is automatic. Frames do not depend on
    /// it.
    pub exposure_stops: Option<f64>,
    /// Look of pictures for viewing.
    pub look: Look,
    /// Maximum number of mirror reflections.
    pub mirror_depth: u32,
    /// Number of scatterings beyond the first.
    pub bounces: Bounces,
    /// Depth to which the stepped method moves the image plane, and its step, metres.
    pub march_depth_m: f64,
    /// See `march_depth_m`.
    pub march_step_m: f64,
}

impl RenderSettings {
    /// Times at which the shutter opens and closes for a frame, in frames.
    pub fn shutter_around(&self, frame: f64) -> [f64; 2] {
        [-0.5, 0.5].map(|end| frame + self.shutter * (self.shutter_position + end))
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            name: String::from("sunfleck"),
            frame_rate: FrameRate::default(),
            frames: 1..=1,
            only_these_frames: false,
            size: Size { width: 960, height: 540 },
            camera: None,
            sampling: Sampling::Until { tolerance: 0.02, most: Sampling::MOST },
            filter: PixelFilter::Box,
            passes: Vec::new(),
            shafts_alone: false,
            seed: 0,
            shutter: 0.0,
            shutter_position: 0.0,
            exposure_stops: None,
            look: Look::None,
            mirror_depth: 4,
            bounces: Bounces::All,
            march_depth_m: 10.0,
            march_step_m: 0.1,
        }
    }
}
