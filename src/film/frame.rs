//! Finished picture of named channels. In go channels, out come parts, sums and defects. Invariant: every
//! channel has one value for each pixel of the window, row by row from the top.

use crate::passes::{MATTE_LAYER, Pass, Precision};
use crate::scene::{Size, Window};
use half::f16;
use std::fmt;

/// Names of the beauty's channels, in the order of the sums.
pub(super) const BEAUTY: [&str; 4] = ["R", "G", "B", "A"];

/// The largest value that a half-precision channel can store.
pub const HALF_MAX: f32 = 65504.0;

/// Finished picture, or its part inside `window`.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Size of the full picture (EXR: the display window).
    pub full: Size,
    /// Part that has pixels.
    pub window: Window,
    /// The channels, in no particular order; names are unique.
    pub channels: Vec<Channel>,
}

/// One named number a pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Name as in the file, such as `R` or `Normal.X`.
    pub name: String,
    /// Precision in a file.
    pub precision: Precision,
    /// Values row by row from the top of the window, not yet rounded to `precision`.
    pub pixels: Vec<f32>,
}

impl Channel {
    /// Creates a channel.
    pub fn new(name: &str, precision: Precision, pixels: Vec<f32>) -> Self {
        Self { name: name.to_owned(), precision, pixels }
    }

    /// Whether values are ids, which compare only as equal or different.
    pub fn holds_ids(&self) -> bool {
        // In a Cryptomatte layer the channels alternate between ids and coverages.
        self.name == "leaf_id.X" || self.name.starts_with(MATTE_LAYER) && self.name.ends_with(['R', 'B'])
    }
}

/// Defects of a frame's values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameDefects {
    /// Values that are not a number.
    pub nan: DefectCount,
    /// Infinite values.
    pub infinite: DefectCount,
    /// Finite values beyond [`HALF_MAX`] in half channels; they are stored as [`HALF_MAX`].
    pub clamped: DefectCount,
}

/// Number of defects of one kind, and the place of the first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DefectCount {
    /// Values concerned, over all channels.
    pub count: usize,
    /// First defect: by channel, then row, then column.
    pub first: Option<PixelPlace>,
}

/// A value's place in a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PixelPlace {
    /// Name of the channel.
    pub channel: String,
    /// Column in the full picture.
    pub x: usize,
    /// Row in the full picture.
    pub y: usize,
}

impl Precision {
    /// Half-precision value as stored. Finite values beyond the range become the largest one; infinity and
    /// NaN stay.
    pub fn half_from(value: f32) -> f16 {
        f16::from_f32(if value.is_finite() { value.clamp(-HALF_MAX, HALF_MAX) } else { value })
    }

    /// Value after storage.
    pub fn stored(self, value: f32) -> f32 {
        match self {
            Self::Half => Self::half_from(value).to_f32(),
            Self::Float => value,
        }
    }
}

impl Frame {
    /// Frame with another window, black outside its own pixels.
    pub fn within(self, window: Window) -> Self {
        if self.window == window { self } else { self.part(window) }
    }

    /// Adds beauty and shafts of another picture with the same passes. Passes of surfaces and fog are the
    /// same in both, and stay.
    pub fn add_light(&mut self, other: &Self) {
        const LIGHT: [&str; 12] = [
            "R",
            "G",
            "B",
            "shafts.R",
            "shafts.G",
            "shafts.B",
            "indirect.R",
            "indirect.G",
            "indirect.B",
            "indirect_shafts.R",
            "indirect_shafts.G",
            "indirect_shafts.B",
        ];
        for channel in self.channels.iter_mut().filter(|channel| LIGHT.contains(&channel.name.as_str())) {
            let Some(added) = other.channel(&channel.name) else { continue };
            for (sum, added) in channel.pixels.iter_mut().zip(&added.pixels) {
                *sum += added;
            }
        }
    }

    /// Part inside another window, black outside its own pixels.
    pub fn part(&self, window: Window) -> Self {
        self.picked(self.full, window, |(x, y)| self.window.index(x, y))
    }

    /// Copy without passes.
    pub fn colors(&self) -> Self {
        let colors = BEAUTY.into_iter().filter_map(|name| self.channel(name).cloned());
        Self { channels: colors.collect(), ..*self }
    }

    /// Frame enlarged to another size, or a part of it inside a window. Each pixel has the value of the one
    /// that contains it.
    pub fn enlarged(&self, full: Size, window: Window) -> Self {
        let own = self.full;
        self.picked(full, window, |(x, y)| {
            Some(y * own.height / full.height * own.width + x * own.width / full.width)
        })
    }

    /// Frame whose pixels are those of given indices in this one, or black.
    fn picked(&self, full: Size, window: Window, index: impl Fn((usize, usize)) -> Option<usize>) -> Self {
        let channels = self.channels.iter().map(|Channel { name, precision, pixels }| {
            let value = |pixel| index(pixel).map_or(0.0, |index| pixels[index]);
            Channel::new(name, *precision, window.pixels().map(value).collect())
        });
        Self { full, window, channels: channels.collect() }
    }

    /// Channel of the given name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// Replaces the beauty by the shafts, with one minus the mean transmittance as alpha. Both passes are
    /// required.
    pub fn show_shafts_alone(&mut self) {
        let of = |pass: Pass| pass.row().channels.iter().map(|name| Some(self.channel(name)?.pixels.clone()));
        let shafts: Option<Vec<_>> = of(Pass::Shafts).collect();
        let through: Option<Vec<_>> = of(Pass::Transmittance).collect();
        let (Some(shafts), Some(through)) = (shafts, through) else { return };
        let hidden = (0..through[0].len())
            .map(|pixel| 1.0 - through.iter().map(|channel| channel[pixel]).sum::<f32>() / 3.0)
            .collect();
        for (name, pixels) in BEAUTY.into_iter().zip(shafts.into_iter().chain([hidden])) {
            if let Some(channel) = self.channels.iter_mut().find(|channel| channel.name == name) {
                channel.pixels = pixels;
            }
        }
    }

    /// Removes the channels of these passes.
    pub fn drop_passes(&mut self, passes: &[Pass]) {
        let is_dropped = |name: &str| passes.iter().any(|pass| pass.row().channels.contains(&name));
        self.channels.retain(|channel| !is_dropped(&channel.name));
    }

    /// Counts NaN, infinity and values beyond the range of their channel, each with its first place.
    pub fn check(&self) -> FrameDefects {
        let mut defects = FrameDefects::default();
        for channel in &self.channels {
            for (index, &value) in channel.pixels.iter().enumerate() {
                let defect = if value.is_nan() {
                    &mut defects.nan
                } else if value.is_infinite() {
                    &mut defects.infinite
                } else if channel.precision == Precision::Half && value.abs() > HALF_MAX {
                    &mut defects.clamped
                } else {
                    continue;
                };
                defect.count += 1;
                defect.first.get_or_insert_with(|| {
                    let (x, y) = self.window.pixel(index);
                    PixelPlace { channel: channel.name.clone(), x, y }
                });
            }
        }
        defects
    }
}

impl FrameDefects {
    /// Whether the frame is unusable: it holds NaN or infinity.
    pub fn are_fatal(&self) -> bool {
        self.nan.count > 0 || self.infinite.count > 0
    }
}

impl fmt::Display for DefectCount {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.count)?;
        match &self.first {
            Some(place) => {
                write!(f, " (first in channel {} at pixel {}, {})", place.channel, place.x, place.y)
            }
            None => Ok(()),
        }
    }
}

impl fmt::Display for FrameDefects {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "NaN: {}, infinite: {}, beyond half range: {}", self.nan, self.infinite, self.clamped)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn enlarged_pixels_lie_where_they_lay() {
        let (size, full) = (Size { width: 2, height: 1 }, Size { width: 5, height: 3 });
        let channels = vec![Channel::new("R", Precision::Half, vec![1.0, 2.0])];
        let frame = Frame { full: size, window: Window::whole(size), channels };
        let part = frame.enlarged(full, Window { x: 1, y: 1, width: 4, height: 2 });
        assert_eq!(part.channels[0].pixels, [1.0, 1.0, 2.0, 2.0, 1.0, 1.0, 2.0, 2.0]);
        assert_eq!((part.full, part.window.x), (full, 1));
    }

    #[test]
    fn defects_are_told_apart_and_placed_in_the_full_picture() {
        let window = Window { x: 10, y: 20, width: 2, height: 2 };
        let frame = Frame {
            full: Size { width: 100, height: 100 },
            window,
            channels: vec![
                Channel::new("R", Precision::Half, vec![0.0, HALF_MAX, -65505.0, f32::INFINITY]),
                Channel::new("Z", Precision::Float, vec![1e10, f32::NAN, f32::NAN, 0.0]),
            ],
        };
        let defects = frame.check();
        let place = |channel: &str, x, y| Some(PixelPlace { channel: channel.to_owned(), x, y });
        assert_eq!(defects.nan, DefectCount { count: 2, first: place("Z", 11, 20) });
        assert_eq!(defects.infinite, DefectCount { count: 1, first: place("R", 11, 21) });
        assert_eq!(defects.clamped, DefectCount { count: 1, first: place("R", 10, 21) });
        assert!(defects.are_fatal());
    }

    #[test]
    fn storing_as_half_clamps_what_is_finite_only() {
        assert_eq!(Precision::Half.stored(1e9), HALF_MAX);
        assert_eq!(Precision::Half.stored(-1e9), -HALF_MAX);
        assert_eq!(Precision::Half.stored(f32::INFINITY), f32::INFINITY);
        assert!(Precision::Half.stored(f32::NAN).is_nan());
        assert_eq!(Precision::Float.stored(1e9), 1e9);
    }
}
