//! Samples packed for a film. In go samples, out come the numbers that the film keeps of each. Invariant:
//! samples stay in order, so sums are rounded alike.

use super::frame::BEAUTY;
use super::hues::{self, HueSums};
use super::mattes::{self, MatteList};
use super::pass_value::value;
use super::pixel_sum::{self, PixelSum};
use crate::passes::Pass;
use crate::passes::PixelRule;
use crate::scene::Window;
use crate::transport::Sample;

/// Packed numbers for a sample's fog, see [`Film::fog`](super::Film).
const FOG: usize = 4;

/// Maximum numbers of a sample: the beauty's, four for each pass, fog, hues and mattes.
pub(super) const MOST_CHANNELS: usize =
    BEAUTY.len() + 4 * Pass::ALL.len() + FOG + hues::PACKED + mattes::PACKED;

/// Passes that a film keeps, by the rule that makes pixels from samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct KeptPasses {
    pub(super) mean: Vec<Pass>,
    pub(super) nearest: Vec<Pass>,
    /// Whether shafts are smoothed.
    pub(super) fog: bool,
    /// Whether the light has hues.
    pub(super) hues: bool,
    /// Whether the film lists which objects cover a pixel.
    pub(super) mattes: bool,
}

impl KeptPasses {
    pub(super) fn new(passes: &[Pass], hues: bool) -> Self {
        let mut wanted = passes.to_vec();
        wanted.sort_unstable();
        wanted.dedup();
        let of = |rule: PixelRule| -> Vec<Pass> {
            wanted.iter().copied().filter(|&pass| pass.row().rule == rule).collect()
        };
        let mattes = !of(PixelRule::Ranked).is_empty();
        Self { mean: of(PixelRule::Mean), nearest: of(PixelRule::Nearest), fog: false, hues, mattes }
    }

    /// Number of channels of the beauty and of averaged passes.
    pub(super) fn mean_channels(&self) -> usize {
        BEAUTY.len() + 3 * self.mean.len()
    }

    /// Number of channels of passes that show the sample nearest to the pixel's centre.
    pub(super) fn nearest_channels(&self) -> usize {
        self.nearest.iter().map(|&pass| pass.row().channels.len()).sum()
    }

    /// Number of values that are kept of a sample.
    fn packed(&self) -> usize {
        let parts = [(self.fog, FOG), (self.hues, hues::PACKED), (self.mattes, mattes::PACKED)];
        let parts: usize = parts.iter().map(|&(is_kept, packed)| if is_kept { packed } else { 0 }).sum();
        self.mean_channels() + self.nearest_channels() + parts
    }

    /// Passes the values of all channels to `put` in order, from the means to the mattes.
    #[inline(always)]
    pub(super) fn pack(&self, sample: &Sample, mut put: impl FnMut(&[f32])) {
        let [red, green, blue] = sample.radiance.to_array();
        put(&[red, green, blue, sample.alpha].map(|value| value as f32));
        for &pass in &self.mean {
            put(&value(pass, sample).map(|value| value as f32)[..3]);
        }
        for &pass in &self.nearest {
            put(&value(pass, sample).map(|value| value as f32)[..pass.row().channels.len()]);
        }
        if self.fog {
            let [red, green, blue] = sample.shafts.to_array();
            put(&[red, green, blue, sample.transmittance.element_sum() / 3.0].map(|value| value as f32));
        }
        if self.hues {
            put(&hues::packed(sample));
        }
        if self.mattes {
            put(&mattes::packed(&sample.mattes));
        }
    }
}

/// Packed samples.
#[derive(Clone, Debug)]
pub struct Splats {
    window: Window,
    passes: KeptPasses,
    /// Whether they belong to the fresh half, see [`Film::add_fresh`](super::Film::add_fresh).
    pub(super) is_fresh: bool,
    places: Vec<SplatPlace>,
    samples: u32,
    /// Values of each sample, one after the other.
    values: Vec<f32>,
}

/// Pixel of a sample, with its weight there.
#[derive(Clone, Copy, Debug)]
pub(super) struct SplatPlace {
    pub(super) weight: f64,
    /// Index within the film's window.
    pub(super) pixel: u32,
    pub(super) from_centre_px: f32,
    /// Index of the sample.
    pub(super) sample: u32,
}

/// Weight of a sample in one pixel of the full picture.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// Column and row, y downwards.
    pub pixel: (usize, usize),
    /// Share of the pixel in any unit, such as the area that the sample covers, 0 or more.
    pub weight: f64,
    /// Distance from the pixel's centre: data passes show the nearest sample, and the first of equally near
    /// ones.
    pub from_centre_px: f64,
}

impl Splat {
    /// Place of the sample with that index; `None` outside the window.
    pub(super) fn place(&self, window: Window, sample: u32) -> Option<SplatPlace> {
        let pixel = window.index(self.pixel.0, self.pixel.1)? as u32;
        Some(SplatPlace { weight: self.weight, pixel, from_centre_px: self.from_centre_px as f32, sample })
    }
}

impl Splats {
    pub(super) fn new(window: Window, passes: KeptPasses) -> Self {
        Self { window, passes, is_fresh: false, places: Vec::new(), samples: 0, values: Vec::new() }
    }

    /// Clears the list for samples of the fresh half, or of the known one.
    pub fn start(&mut self, is_fresh: bool) {
        self.is_fresh = is_fresh;
        self.places.clear();
        self.samples = 0;
        self.values.clear();
    }

    /// Appends a sample and returns its index.
    pub fn keep(&mut self, sample: &Sample) -> u32 {
        let Self { passes, values, .. } = self;
        passes.pack(sample, |channels| values.extend_from_slice(channels));
        self.samples += 1;
        self.samples - 1
    }

    /// Adds a kept sample to a pixel. Pixels outside the window are ignored.
    pub fn add(&mut self, sample: u32, splat: &Splat) {
        self.places.extend(splat.place(self.window, sample));
    }

    /// Places with their samples' values.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&SplatPlace, &[f32])> {
        let packed = self.passes.packed();
        self.places.iter().map(move |place| (place, &self.values[place.sample as usize * packed..][..packed]))
    }
}

/// Neighbouring pixels of a film.
pub(super) struct Band<'a> {
    pub(super) first_pixel: usize,
    pub(super) weights: &'a mut [PixelSum],
    pub(super) sums: &'a mut [PixelSum],
    pub(super) fresh: &'a mut [[PixelSum; 4]],
    pub(super) fog: &'a mut [[f32; 4]],
    pub(super) nearest_distances_px: &'a mut [f32],
    pub(super) nearest_values: &'a mut [f32],
    pub(super) hues: &'a mut [HueSums],
    pub(super) mattes: &'a mut [MatteList],
}

impl Band<'_> {
    pub(super) fn holds(&self, place: &SplatPlace) -> bool {
        (place.pixel as usize).wrapping_sub(self.first_pixel) < self.weights.len()
    }

    pub(super) fn add(&mut self, is_fresh: bool, place: &SplatPlace, values: &[f32]) {
        let pixel = place.pixel as usize - self.first_pixel;
        let channels = self.sums.len() / self.weights.len();
        let (mean, rest) = values.split_at(channels);
        let listed = if self.mattes.is_empty() { 0 } else { mattes::PACKED };
        let (rest, shares) = rest.split_at(rest.len() - listed);
        let colored = if self.hues.is_empty() { 0 } else { hues::PACKED };
        let (rest, colors) = rest.split_at(rest.len() - colored);
        let foggy = if self.fog.is_empty() { 0 } else { FOG };
        let (nearest, fog) = rest.split_at(rest.len() - foggy);
        if let Some(sums) = self.hues.get_mut(pixel) {
            sums.add_packed(is_fresh, colors, place.weight);
        }
        if let Some(sums) = self.fog.get_mut(pixel) {
            for (sum, value) in sums.iter_mut().zip(fog) {
                *sum += (place.weight * f64::from(*value)) as f32;
            }
        }
        if let Some(list) = self.mattes.get_mut(pixel) {
            list.add_packed(shares, place.weight);
        }
        pixel_sum::add(&mut self.weights[pixel], place.weight);
        for (sum, value) in self.sums[pixel * channels..][..channels].iter_mut().zip(mean) {
            pixel_sum::add(sum, place.weight * f64::from(*value));
        }
        if is_fresh {
            let one_and_color = [1.0, values[0], values[1], values[2]].map(f64::from);
            for (sum, value) in self.fresh[pixel].iter_mut().zip(one_and_color) {
                pixel_sum::add(sum, place.weight * value);
            }
        }
        if self.nearest_distances_px.get(pixel).is_some_and(|&distance| place.from_centre_px < distance) {
            self.nearest_distances_px[pixel] = place.from_centre_px;
            self.nearest_values[pixel * nearest.len()..][..nearest.len()].copy_from_slice(nearest);
        }
    }
}
