//! Film, which turns samples into pixels. In go any number of weighted [`Sample`]s a pixel, in any order and
//! from any method; out comes a [`Frame`] of named channels. Invariant: a pixel keeps sums of weights and of
//! weighted values, which are divided once, at the end. So a pixel may have any number of rays, and any total
//! weight.

mod blocks;
mod brightness;
mod estimate;
pub mod filter;
mod frame;
mod holes;
mod hues;
mod mask;
mod mattes;
mod pass_value;
mod pixel_sum;
mod resolve;
mod smooth;
mod splats;
#[cfg(test)]
mod tests;

use crate::passes::Pass;
use crate::scene::{Size, Window};
use crate::transport::Sample;
use hues::HueSums;
use mattes::MatteList;
use pixel_sum::PixelSum;
use rayon::prelude::*;
use splats::{Band, KeptPasses, MOST_CHANNELS};

pub use crate::passes::{MATTE_LAYER, Precision};
pub use blocks::{BLOCK_SIDE, Blocks};
pub use brightness::Dark;
pub use estimate::{BlockEstimate, PixelEstimate};
pub use frame::{Channel, DefectCount, Frame, FrameDefects, HALF_MAX, PixelPlace};
pub use mask::Mask;
pub use smooth::REACH_PX;
pub use splats::{Splat, Splats};

/// Sums over the samples of a rectangle of the picture, for the beauty and the requested passes.
#[derive(Clone, Debug)]
pub struct Film {
    full: Size,
    window: Window,
    passes: KeptPasses,
    /// Sum of a pixel's weights; 0 without samples.
    weights: Vec<PixelSum>,
    /// A pixel's weighted sums: red, green, blue, alpha, then three for each pass that is averaged.
    sums: Vec<PixelSum>,
    /// Sums of the fresh half of a pixel's samples: weight, and weighted red, green and blue.
    fresh: Vec<[PixelSum; 4]>,
    /// Sums for smoothing shafts: their weighted red, green and blue, and weighted transmittance, the mean
    /// over the channels. Empty without smoothing.
    fog: Vec<[f32; 4]>,
    /// Distance of the nearest sample from a pixel's centre.
    nearest_distances_px: Vec<f32>,
    /// Values of that sample in the other passes, pixel by pixel.
    nearest_values: Vec<f32>,
    /// Sums of hues of each pixel's samples; empty if the light has no hues.
    hues: Vec<HueSums>,
    /// Objects that cover each pixel; empty without Cryptomatte.
    mattes: Vec<MatteList>,
}

impl Film {
    /// Creates an empty film for `window` of a picture of size `full`. Other passes take no memory.
    pub fn new(full: Size, window: Window, passes: &[Pass]) -> Self {
        Self::of(full, window, KeptPasses::new(passes, false))
    }

    /// Film of a light with hues: [`Sample::hue`] is not yet multiplied in.
    pub fn with_hues(full: Size, window: Window, passes: &[Pass]) -> Self {
        Self::of(full, window, KeptPasses::new(passes, true))
    }

    fn of(full: Size, window: Window, passes: KeptPasses) -> Self {
        let pixels = window.width * window.height;
        let background: Vec<f32> = passes
            .nearest
            .iter()
            .map(|&pass| pass.row())
            .flat_map(|layout| std::iter::repeat_n(layout.background, layout.channels.len()))
            .collect();
        Self {
            full,
            window,
            weights: vec![PixelSum::default(); pixels],
            sums: vec![PixelSum::default(); pixels * passes.mean_channels()],
            fresh: vec![Default::default(); pixels],
            fog: vec![[0.0; 4]; if passes.fog { pixels } else { 0 }],
            nearest_distances_px: vec![f32::INFINITY; if passes.nearest.is_empty() { 0 } else { pixels }],
            nearest_values: background.repeat(pixels),
            hues: vec![HueSums::default(); if passes.hues { pixels } else { 0 }],
            mattes: vec![MatteList::default(); if passes.mattes { pixels } else { 0 }],
            passes,
        }
    }

    /// Film with [smoothed shafts](smooth), for samples in two halves.
    pub fn with_smooth_shafts(full: Size, window: Window, passes: &[Pass], has_hues: bool) -> Self {
        Self::of(full, window, KeptPasses { fog: true, ..KeptPasses::new(passes, has_hues) })
    }

    /// Approximate bytes that a pixel takes in a film with these passes.
    pub fn bytes_per_pixel(passes: &[Pass]) -> usize {
        let kept = KeptPasses::new(passes, true);
        let sums = size_of::<PixelSum>() * (1 + kept.mean_channels() + 4) + size_of::<[f32; 4]>();
        let nearest = size_of::<f32>() * (1 + kept.nearest_channels());
        let mattes = if kept.mattes { size_of::<MatteList>() } else { 0 };
        sums + nearest + mattes + size_of::<HueSums>()
    }

    /// Rectangle of the picture that this film covers.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Adds a sample. Pixels outside the window are ignored.
    pub fn add(&mut self, splat: &Splat, sample: &Sample) {
        self.add_to_half(false, splat, sample);
    }

    /// Adds a sample of the fresh half, which [`Film::estimate`] compares with the known half.
    pub fn add_fresh(&mut self, splat: &Splat, sample: &Sample) {
        self.add_to_half(true, splat, sample);
    }

    fn add_to_half(&mut self, is_fresh: bool, splat: &Splat, sample: &Sample) {
        let Some(place) = splat.place(self.window, 0) else { return };
        let (mut packed, mut count) = ([0.0; MOST_CHANNELS], 0);
        self.passes.pack(sample, |channels| {
            packed[count..][..channels.len()].copy_from_slice(channels);
            count += channels.len();
        });
        for mut whole in self.bands(self.weights.len()) {
            whole.add(is_fresh, &place, &packed[..count]);
        }
    }

    /// Moves all samples of these pixels to the known half; other pixels keep their halves.
    pub fn let_fresh_be_known(&mut self, pixels: &Mask) {
        for (index, (x, y)) in self.window.pixels().enumerate() {
            if pixels.contains(x, y) {
                self.fresh[index] = Default::default();
                self.hues.get_mut(index).into_iter().for_each(HueSums::clear_fresh);
            }
        }
    }

    /// An empty list of samples for this film.
    pub fn splats(&self) -> Splats {
        Splats::new(self.window, self.passes.clone())
    }

    /// Adds lists of samples, each as if by [`Film::add`] or [`Film::add_fresh`], in all threads
    /// of the current pool.
    pub fn add_all(&mut self, lists: &[Splats]) {
        let pixels = self.weights.len().div_ceil(rayon::current_num_threads());
        let bands: Vec<Band> = self.bands(pixels).collect();
        // Every band goes through all samples and takes its own, so a pixel gets them in order.
        bands.into_par_iter().for_each(|mut band| {
            for splats in lists {
                for (place, values) in splats.iter() {
                    if band.holds(place) {
                        band.add(splats.is_fresh, place, values);
                    }
                }
            }
        });
    }

    /// Film divided into bands of at most so many pixels.
    fn bands(&mut self, pixels: usize) -> impl Iterator<Item = Band<'_>> {
        let pixels = pixels.max(1);
        let (channels, nearest_channels) = (self.passes.mean_channels(), self.passes.nearest_channels());
        let mut distances = self.nearest_distances_px.chunks_mut(pixels);
        let mut nearest = self.nearest_values.chunks_mut((pixels * nearest_channels).max(1));
        let mut hues = self.hues.chunks_mut(pixels);
        let mut mattes = self.mattes.chunks_mut(pixels);
        let sums = self.sums.chunks_mut(pixels * channels);
        let fresh = self.fresh.chunks_mut(pixels);
        let mut fog = self.fog.chunks_mut(pixels);
        let parts = self.weights.chunks_mut(pixels).zip(sums).zip(fresh).enumerate();
        parts.map(move |(index, ((weights, sums), fresh))| Band {
            first_pixel: index * pixels,
            weights,
            sums,
            fresh,
            fog: fog.next().unwrap_or_default(),
            nearest_distances_px: distances.next().unwrap_or_default(),
            nearest_values: nearest.next().unwrap_or_default(),
            hues: hues.next().unwrap_or_default(),
            mattes: mattes.next().unwrap_or_default(),
        })
    }

    /// Adds another film of the same picture and passes, such as that of a tile or a stack of slices.
    ///
    /// Films that overlap have to be pasted in a fixed order. It decides the rounding of sums, and which of
    /// two samples equally near to a pixel's centre the data passes show.
    pub fn paste(&mut self, part: &Self) {
        debug_assert_eq!(self.passes, part.passes, "parts of one picture have the same passes");
        let stride = self.stride();
        let nearest_stride = self.passes.nearest_channels();
        for (from, (x, y)) in part.window.pixels().enumerate() {
            let Some(to) = self.window.index(x, y) else { continue };
            let add_all = |sums: &mut [PixelSum], added: &[PixelSum]| {
                let pairs = sums.iter_mut().zip(added);
                pairs.for_each(|(sum, added)| pixel_sum::add(sum, pixel_sum::value(added)));
            };
            add_all(&mut self.weights[to..=to], &part.weights[from..=from]);
            add_all(&mut self.sums[to * stride..][..stride], &part.sums[from * stride..][..stride]);
            add_all(&mut self.fresh[to], &part.fresh[from]);
            if let (Some(sums), Some(added)) = (self.fog.get_mut(to), part.fog.get(from)) {
                sums.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
            }
            if let (Some(sums), Some(added)) = (self.hues.get_mut(to), part.hues.get(from)) {
                sums.add(added);
            }
            if let (Some(list), Some(added)) = (self.mattes.get_mut(to), part.mattes.get(from)) {
                list.append(added);
            }
            if nearest_stride > 0 && part.nearest_distances_px[from] < self.nearest_distances_px[to] {
                self.nearest_distances_px[to] = part.nearest_distances_px[from];
                self.nearest_values[to * nearest_stride..(to + 1) * nearest_stride].copy_from_slice(
                    &part.nearest_values[from * nearest_stride..(from + 1) * nearest_stride],
                );
            }
        }
    }

    /// Total weight: the number of samples, if each has weight 1.
    pub fn weight(&self) -> f64 {
        self.weights.iter().map(pixel_sum::value).sum()
    }

    /// Number of sums a pixel.
    fn stride(&self) -> usize {
        self.passes.mean_channels()
    }
}
