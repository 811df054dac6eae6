//! Arrays of numbers with their shape. In go channels, out comes one array. Invariant: one value for each
//! channel of each pixel, pixel by pixel, row by row from the top.

use crate::film::Channel;
use image::{ImageBuffer, Pixel};

/// Channels of a picture: `height` rows of `width` pixels of `channels.len()` values.
///
/// Other crates take the values as they lie, without a copy: `ndarray::Array3::from_shape_vec(array.shape(),
/// array.values)`, or an image of as many channels:
///
/// ```
/// # let scene = sunfleck::Scene::load("scenes/first_leaf/scene.ron")?;
/// # let frame = sunfleck::Renderer::new(&scene).size(48, 27).samples(1).render()?;
/// let beauty = image::Rgba32FImage::try_from(frame.beauty()).map_err(|_| "there is no alpha")?;
/// assert_eq!(beauty.dimensions(), (48, 27));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Array {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Names as in a file, such as `R` or `Normal.X`.
    pub channels: Vec<String>,
    /// Unit of the values, `1` if they have none; for ids `id`.
    pub unit: &'static str,
    /// Pixel by pixel, row by row from the top: `[height][width][channel]`.
    pub values: Vec<f32>,
}

impl Array {
    /// Creates an array of channels of equal size, at least one.
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

    /// Shape: rows, columns, channels.
    pub fn shape(&self) -> [usize; 3] {
        [self.height, self.width, self.channels.len()]
    }

    /// Values of a pixel, one for each channel; `None` outside the array.
    pub fn at(&self, x: usize, y: usize) -> Option<&[f32]> {
        let is_inside = x < self.width && y < self.height;
        let index = y.checked_mul(self.width)?.checked_add(x)?.checked_mul(self.channels.len())?;
        if is_inside { self.values.get(index..index + self.channels.len()) } else { None }
    }

    /// Mean over all pixels, one for each channel.
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

/// Fails with the array itself if its pixels have another number of values.
impl<P: Pixel<Subpixel = f32>> TryFrom<Array> for ImageBuffer<P, Vec<f32>> {
    type Error = Array;

    fn try_from(array: Array) -> Result<Self, Array> {
        let [height, width, channels] = array.shape();
        match (u32::try_from(width), u32::try_from(height)) {
            (Ok(columns), Ok(rows))
                if channels == usize::from(P::CHANNEL_COUNT)
                    && array.values.len() == width * height * channels =>
            {
                Ok(Self::from_raw(columns, rows, array.values).unwrap_or_default())
            }
            _ => Err(array),
        }
    }
}
