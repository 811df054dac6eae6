//! Numbers of a frame with their shape. In go channels, out comes one array. Invariant: one value for each
//! channel of each pixel, pixel by pixel, row by row from the top.

use crate::film::Channel;

/// Channels of a picture: `height` rows of `width` pixels of `channels.len()` values.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Names as in a file, such as `R` or `Normal.X`.
    pub channels: Vec<String>,
    /// What values are measured in, `1` if in nothing; for ids `id`.
    pub unit: &'static str,
    /// Pixel by pixel, row by row from the top: `[height][width][channel]`.
    pub values: Vec<f32>,
}

impl Array {
    /// Of channels of equal size, at least one.
    pub(super) fn of(channels: &[&Channel], width: usize, height: usize, unit: &'static str) -> Self {
        let pixel = |index: usize| channels.iter().map(move |channel| channel.pixels[index]);
        Self {
            width,
            height,
            channels: channels.iter().map(|channel| channel.name.clone()).collect(),
            unit,
            values: (0..width * height).flat_map(pixel).collect(),
        }
    }

    /// The values of a pixel, one for each channel; none beyond the array.
    pub fn at(&self, x: usize, y: usize) -> Option<&[f32]> {
        let is_inside = x < self.width && y < self.height;
        let index = y.checked_mul(self.width)?.checked_add(x)?.checked_mul(self.channels.len())?;
        if is_inside { self.values.get(index..index + self.channels.len()) } else { None }
    }

    /// The mean over all pixels, one for each channel.
    pub fn mean(&self) -> Vec<f64> {
        let count = self.channels.len();
        let sum =
            |channel| self.values.iter().skip(channel).step_by(count).map(|&value| f64::from(value)).sum();
        (0..count)
            .map(|channel| -> f64 { sum(channel) })
            .map(|sum| sum / (self.width * self.height) as f64)
            .collect()
    }
}
