//! Windows of EXR files. In go headers' windows, out come channels in one window. Invariant: a pixel keeps
//! its place in the picture, whichever part it comes from.

use crate::film::{Channel, Precision};
use crate::scene::{Size, Window};
use exr::image::{AnyChannel, FlatSamples};
use exr::math::Vec2;
use exr::meta::header::Header;

/// Rectangle of the plane of all windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Region {
    left: i64,
    top: i64,
    pub(super) size: Size,
}

impl Region {
    /// Display window.
    pub(super) fn displayed(header: &Header) -> Self {
        let window = header.shared_attributes.display_window;
        Self::new(window.position, window.size)
    }

    /// Data window.
    pub(super) fn stored(header: &Header) -> Self {
        Self::new(header.own_attributes.layer_position, header.layer_size)
    }

    fn new(Vec2(x, y): Vec2<i32>, Vec2(width, height): Vec2<usize>) -> Self {
        Self { left: x.into(), top: y.into(), size: Size { width, height } }
    }

    /// Bounding rectangle of both.
    pub(super) fn joined(self, other: Self) -> Self {
        let right = |region: Self| region.left + region.size.width as i64;
        let bottom = |region: Self| region.top + region.size.height as i64;
        let (left, top) = (self.left.min(other.left), self.top.min(other.top));
        let width = right(self).max(right(other)) - left;
        let height = bottom(self).max(bottom(other)) - top;
        Self { left, top, size: Size { width: width as usize, height: height as usize } }
    }

    /// Intersection with a part's data window, relative to this region's corner; without pixels if it is
    /// empty.
    pub(super) fn seen(self, header: &Header) -> Window {
        let part = Self::stored(header);
        let side = |start: i64, length: usize, full: usize| {
            let end = (start + length as i64).clamp(0, full as i64);
            let begin = start.clamp(0, end);
            (begin as usize, (end - begin) as usize)
        };
        let (x, width) = side(part.left - self.left, part.size.width, self.size.width);
        let (y, height) = side(part.top - self.top, part.size.height, self.size.height);
        if width == 0 || height == 0 {
            Window { x: 0, y: 0, width: 0, height: 0 }
        } else {
            Window { x, y, width, height }
        }
    }

    /// Channel of a part in a window, padded with 0.
    pub(super) fn channel(
        self,
        header: &Header,
        window: Window,
        name: String,
        stored: AnyChannel<FlatSamples>,
    ) -> Channel {
        let place = |values: usize| Placed { region: self, header, window, values };
        let (precision, pixels) = match stored.sample_data {
            FlatSamples::F16(values) => {
                (Precision::Half, place(values.len()).pixels(|index| values[index].to_f32()))
            }
            FlatSamples::F32(values) => (Precision::Float, place(values.len()).pixels(|index| values[index])),
            FlatSamples::U32(values) => {
                (Precision::Float, place(values.len()).pixels(|index| values[index] as f32))
            }
        };
        Channel { name, precision, pixels }
    }
}

/// Values of a part that are copied into a window.
struct Placed<'a> {
    region: Region,
    header: &'a Header,
    window: Window,
    values: usize,
}

impl Placed<'_> {
    fn pixels(&self, value: impl Fn(usize) -> f32) -> Vec<f32> {
        let part = Region::stored(self.header);
        let mut pixels = vec![0.0; self.window.width * self.window.height];
        let seen = self.region.seen(self.header);
        for y in seen.y..seen.y + seen.height {
            let row = (y as i64 + self.region.top - part.top) as usize;
            let column = (seen.x as i64 + self.region.left - part.left) as usize;
            let from = row * part.size.width + column;
            let to = (y - self.window.y) * self.window.width + seen.x - self.window.x;
            for step in 0..seen.width.min(self.values.saturating_sub(from)) {
                pixels[to + step] = value(from + step);
            }
        }
        pixels
    }
}

/// Bounding window of both, one of which may be empty.
pub(super) fn around(a: Window, b: Window) -> Window {
    match (a.width, b.width) {
        (0, _) => b,
        (_, 0) => a,
        _ => {
            let (x, y) = (a.x.min(b.x), a.y.min(b.y));
            let right = (a.x + a.width).max(b.x + b.width);
            let bottom = (a.y + a.height).max(b.y + b.height);
            Window { x, y, width: right - x, height: bottom - y }
        }
    }
}
