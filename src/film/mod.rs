//! Samples become pixels. In go any number of weighted [`Sample`]s a pixel, in any order and from
//! any method; out comes a [`Frame`] of named channels. Invariant: per pixel only sums of weight and of
//! weight times value are kept and divided once, at the end, so nothing assumes one ray per pixel
//! sample or weights that add up to a known total.

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
mod splats;

use crate::passes::Pass;
use crate::scene::{Size, Window};
use crate::transport::Sample;
use hues::HueSums;
use mattes::MatteList;
use rayon::prelude::*;
use splats::{BEAUTY, Band, KeptPasses, MOST_CHANNELS, SplatPlace};

pub use crate::passes::{MATTE_LAYER, Precision};
pub use blocks::{BLOCK_SIDE, Blocks};
pub use brightness::Dark;
pub use estimate::{BlockEstimate, PixelEstimate};
pub use frame::{Channel, DefectCount, Frame, FrameDefects, HALF_MAX, PixelPlace};
pub use mask::Mask;
pub use splats::{Splat, Splats};

/// Sums over the samples of a rectangle of the picture, for the beauty and the passes asked for.
#[derive(Clone, Debug)]
pub struct Film {
    full: Size,
    window: Window,
    passes: KeptPasses,
    /// A pixel's sum of weights; 0 is a pixel without a sample.
    weights: Vec<f64>,
    /// A pixel's weighted sums: red, green, blue, alpha, then three for each pass that is averaged.
    sums: Vec<f64>,
    /// Of these, what the fresh half of a pixel's samples gave: weight, and weighted red, green and blue.
    fresh: Vec<[f64; 4]>,
    /// How far from the pixel's centre its nearest sample lies.
    nearest_distances_px: Vec<f32>,
    /// What that sample showed: the channels of the other passes, pixel by pixel.
    nearest_values: Vec<f32>,
    /// What each pixel's samples know of the light's hues, all of them and the fresh half; empty if it has none.
    hues: Vec<[HueSums; 2]>,
    /// Which objects cover each pixel; empty unless somebody asks.
    mattes: Vec<MatteList>,
}

/// Zeros in memory that has been written to: a sum reads its memory first, for which the system would show a page of zeros and then, for the
/// write, another.
fn written_zeros(count: usize) -> Vec<f64> {
    std::iter::repeat_n(std::hint::black_box(0.0), count).collect()
}

impl Film {
    /// An empty film for `window` of a picture of size `full`. Passes not asked for take no memory.
    pub fn new(full: Size, window: Window, passes: &[Pass]) -> Self {
        Self::of(full, window, KeptPasses::new(passes, false))
    }

    /// The same of a picture of one light whose points have hues: to its samples [`Sample::hue`] is still to come.
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
            weights: written_zeros(pixels),
            sums: written_zeros(pixels * passes.mean_channels()),
            fresh: vec![[0.0; 4]; pixels],
            nearest_distances_px: vec![f32::INFINITY; if passes.nearest.is_empty() { 0 } else { pixels }],
            nearest_values: background.repeat(pixels),
            hues: vec![[HueSums::default(); 2]; if passes.hues { pixels } else { 0 }],
            mattes: vec![MatteList::default(); if passes.mattes { pixels } else { 0 }],
            passes,
        }
    }

    /// About what a pixel of a film with these passes takes in memory.
    pub fn bytes_per_pixel(passes: &[Pass]) -> usize {
        let kept = KeptPasses::new(passes, true);
        let sums = size_of::<f64>() * (1 + kept.mean_channels()) + size_of::<[f64; 4]>();
        let nearest = size_of::<f32>() * (1 + kept.nearest_channels());
        let mattes = if kept.mattes { size_of::<MatteList>() } else { 0 };
        sums + nearest + mattes + 2 * size_of::<HueSums>()
    }

    /// The rectangle of the picture that this film covers.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Adds a sample to pixel (`x`, `y`) of the full picture, y downwards. Samples outside the window are none of this film's business.
    ///
    /// `weight` is the sample's share of the pixel in any unit, such as the area that it stands for, 0 or more;
    /// `distance_from_centre_px` decides which sample the data passes show: the nearest, of equal ones the first.
    pub fn add(&mut self, x: usize, y: usize, weight: f64, distance_from_centre_px: f64, sample: &Sample) {
        self.add_to_half(false, x, y, weight, distance_from_centre_px, sample);
    }

    /// The same with a sample of the fresh half, by which [`Film::estimates`] judges what was known without it.
    pub fn add_fresh(
        &mut self,
        x: usize,
        y: usize,
        weight: f64,
        distance_from_centre_px: f64,
        sample: &Sample,
    ) {
        self.add_to_half(true, x, y, weight, distance_from_centre_px, sample);
    }

    fn add_to_half(
        &mut self,
        is_fresh: bool,
        x: usize,
        y: usize,
        weight: f64,
        distance_from_centre_px: f64,
        sample: &Sample,
    ) {
        let Some(pixel) = self.window.index(x, y) else { return };
        let from_centre_px = distance_from_centre_px as f32;
        let place = SplatPlace { weight, pixel: pixel as u32, from_centre_px, sample: 0 };
        let (mut packed, mut count) = ([0.0; MOST_CHANNELS], 0);
        self.passes.pack(sample, |channels| {
            packed[count..][..channels.len()].copy_from_slice(channels);
            count += channels.len();
        });
        for mut whole in self.bands(self.weights.len()) {
            whole.add(is_fresh, &place, &packed[..count]);
        }
    }

    /// All samples so far of these pixels are the known half of what comes next; other pixels keep the halves that they are judged by.
    pub fn let_fresh_be_known(&mut self, pixels: &Mask) {
        for (index, (x, y)) in self.window.pixels().enumerate() {
            if pixels.contains(x, y) {
                self.fresh[index] = [0.0; 4];
                if let Some([_, fresh]) = self.hues.get_mut(index) {
                    *fresh = HueSums::default();
                }
            }
        }
    }

    /// An empty list of samples for this film.
    pub fn splats(&self) -> Splats {
        Splats::new(self.window, self.passes.clone())
    }

    /// Adds lists of samples, each as if by [`Film::add`] or [`Film::add_fresh`], in all threads of the current pool.
    pub fn add_all(&mut self, lists: &[Splats]) {
        let pixels = self.weights.len().div_ceil(rayon::current_num_threads());
        let bands: Vec<Band> = self.bands(pixels).collect();
        // Every band looks through all samples and takes its own: a pixel gets them in their order.
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

    /// The film, cut into parts of so many pixels.
    fn bands(&mut self, pixels: usize) -> impl Iterator<Item = Band<'_>> {
        let pixels = pixels.max(1);
        let (channels, nearest_channels) = (self.passes.mean_channels(), self.passes.nearest_channels());
        let mut distances = self.nearest_distances_px.chunks_mut(pixels);
        let mut nearest = self.nearest_values.chunks_mut((pixels * nearest_channels).max(1));
        let mut hues = self.hues.chunks_mut(pixels);
        let mut mattes = self.mattes.chunks_mut(pixels);
        let sums = self.sums.chunks_mut(pixels * channels);
        let fresh = self.fresh.chunks_mut(pixels);
        let parts = self.weights.chunks_mut(pixels).zip(sums).zip(fresh).enumerate();
        parts.map(move |(index, ((weights, sums), fresh))| Band {
            first_pixel: index * pixels,
            weights,
            sums,
            fresh,
            nearest_distances_px: distances.next().unwrap_or_default(),
            nearest_values: nearest.next().unwrap_or_default(),
            hues: hues.next().unwrap_or_default(),
            mattes: mattes.next().unwrap_or_default(),
        })
    }

    /// Adds what another film of the same picture and the same passes has gathered, such as a tile or a stack of slices.
    ///
    /// Where the two overlap the order of pasting decides the rounding of the sums and, between samples equally near
    /// to a pixel's centre, which one the data passes show: paste in a fixed order.
    pub fn paste(&mut self, part: &Self) {
        debug_assert_eq!(self.passes, part.passes, "parts of one picture have the same passes");
        let stride = self.stride();
        let nearest_stride = self.passes.nearest_channels();
        for (from, (x, y)) in part.window.pixels().enumerate() {
            let Some(to) = self.window.index(x, y) else { continue };
            self.weights[to] += part.weights[from];
            for (sum, added) in self.fresh[to].iter_mut().zip(part.fresh[from]) {
                *sum += added;
            }
            let added = &part.sums[from * stride..(from + 1) * stride];
            for (sum, added) in self.sums[to * stride..(to + 1) * stride].iter_mut().zip(added) {
                *sum += added;
            }
            if let (Some(sums), Some(added)) = (self.hues.get_mut(to), part.hues.get(from)) {
                sums.iter_mut().zip(added).for_each(|(sum, added)| sum.add(added));
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

    /// Pixels of the full picture that have no sample yet; [`Film::resolve`] would fill them from their neighbours.
    pub fn holes(&self) -> Vec<(usize, usize)> {
        let pixels = self.window.pixels().zip(&self.weights);
        pixels.filter(|(_, weight)| **weight == 0.0).map(|(pixel, _)| pixel).collect()
    }

    /// The picture so far. Values are not clamped and NaN stays NaN: ask [`Frame::check`].
    pub fn resolve(&self) -> Frame {
        let stride = self.stride();
        let mean = |offset: usize| -> Vec<f32> {
            self.weights
                .iter()
                .zip(self.sums.iter().skip(offset).step_by(stride))
                .map(|(&weight, &sum)| if weight == 0.0 { 0.0 } else { (sum / weight) as f32 })
                .collect()
        };
        let mean_layouts = self.passes.mean.iter().map(|&pass| pass.row());
        let mean_names = BEAUTY.into_iter().map(|name| (name, Precision::Half)).chain(
            mean_layouts.flat_map(|layout| layout.channels.iter().map(move |&name| (name, layout.precision))),
        );
        let mut channels: Vec<Channel> = mean_names
            .enumerate()
            .map(|(offset, (name, precision))| Channel::new(name, precision, mean(offset)))
            .collect();
        let shafts = self.passes.mean.iter().position(|&pass| pass == Pass::Shafts);
        hues::correct(
            &mut channels,
            shafts.map(|number| BEAUTY.len() + 3 * number),
            &self.hues,
            &self.weights,
        );
        let mean_channels = channels.len();
        let nearest_layouts = self.passes.nearest.iter().map(|&pass| pass.row());
        let nearest_names = nearest_layouts
            .flat_map(|layout| layout.channels.iter().map(move |&name| (name, layout.precision)));
        let nearest_stride = self.passes.nearest_channels();
        channels.extend(nearest_names.enumerate().map(|(offset, (name, precision))| {
            let pixels = self.nearest_values.iter().skip(offset).step_by(nearest_stride).copied().collect();
            Channel::new(name, precision, pixels)
        }));
        if self.passes.mattes {
            channels.extend(mattes::channels(&self.mattes, &self.weights));
        }
        let known = self.weights.iter().map(|&weight| weight != 0.0).collect();
        holes::fill(self.window, known, &mut channels, mean_channels);
        Frame { full: self.full, window: self.window, channels }
    }

    /// Samples that it holds, if each has weight 1.
    pub fn weight(&self) -> f64 {
        self.weights.iter().sum()
    }

    /// Sums a pixel.
    fn stride(&self) -> usize {
        self.passes.mean_channels()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::transport::{Matte, SurfaceFeatures};
    use glam::DVec3;
    use proptest::prelude::*;

    const ALL: [Pass; 9] = [
        Pass::Shafts,
        Pass::Transmittance,
        Pass::Depth,
        Pass::Normal,
        Pass::Position,
        Pass::Albedo,
        Pass::LeafId,
        Pass::Motion,
        Pass::Cryptomatte,
    ];
    const SIZE: Size = Size { width: 4, height: 3 };

    fn whole() -> Window {
        Window::whole(SIZE)
    }

    fn leaf(radiance: f64, depth_m: f64, leaf_id: u32) -> Sample {
        Sample {
            radiance: Rgb::splat(radiance),
            emitted: Rgb::ZERO,
            hue: Rgb::ONE,
            shafts: Rgb::splat(0.25 * radiance),
            transmittance: Rgb::splat(0.5),
            alpha: 1.0,
            surface: Some(SurfaceFeatures {
                depth_m,
                normal: DVec3::Y,
                position: DVec3::new(1.0, 2.0, depth_m),
                albedo: Rgb::splat(0.5),
                leaf_id,
            }),
            motion_px: [depth_m, 0.0, -depth_m, 1.0],
            mattes: [Matte { id: leaf_id, share: 1.0 }, Matte::default(), Matte::default(), Matte::default()],
        }
    }

    fn pixel(frame: &Frame, channel: &str, x: usize, y: usize) -> f32 {
        frame.channel(channel).unwrap().pixels[frame.window.index(x, y).unwrap()]
    }

    #[test]
    fn weights_need_not_sum_to_anything() {
        let mut film = Film::new(SIZE, whole(), &[Pass::Shafts]);
        film.add(1, 1, 0.03, 0.0, &leaf(1.0, 1.0, 1));
        film.add(1, 1, 0.01, 0.0, &leaf(5.0, 1.0, 1));
        let frame = film.resolve();
        assert_eq!(pixel(&frame, "R", 1, 1), 2.0);
        assert_eq!(pixel(&frame, "shafts.B", 1, 1), 0.5);
        assert_eq!(pixel(&frame, "A", 1, 1), 1.0);
    }

    #[test]
    fn data_passes_show_the_sample_nearest_to_the_centre_and_the_first_of_equals() {
        let mut film = Film::new(SIZE, whole(), &ALL);
        film.add(2, 0, 1.0, 0.4, &leaf(1.0, 7.0, 7));
        film.add(2, 0, 1.0, 0.1, &leaf(1.0, 8.0, 8));
        film.add(2, 0, 1.0, 0.1, &leaf(1.0, 9.0, 9));
        film.add(2, 0, 1.0, 0.3, &Sample::default());
        let frame = film.resolve();
        assert_eq!(pixel(&frame, "Z", 2, 0), 8.0);
        assert_eq!(pixel(&frame, "Position.Z", 2, 0), 8.0);
        assert_eq!(pixel(&frame, "leaf_id.X", 2, 0), 8.0);
        assert_eq!(
            ["X", "Y", "Z", "W"].map(|name| pixel(&frame, &format!("Vector.{name}"), 2, 0)),
            [8.0, 0.0, -8.0, 1.0]
        );
        assert_eq!(pixel(&frame, "Normal.Y", 2, 0), 0.75, "averaged, the background counts as 0");
    }

    /// Eight objects, some seen more than once: the six that cover most, ids as bits.
    #[test]
    fn mattes_are_ranked_by_coverage() {
        let mut film = Film::new(SIZE, whole(), &[Pass::Cryptomatte]);
        for (id, times) in [(1, 1), (2, 5), (3, 2), (4, 2), (5, 3), (6, 1), (7, 4), (8, 1)] {
            for _ in 0..times {
                film.add(1, 2, 0.5, 0.0, &leaf(1.0, 1.0, id));
            }
        }
        let half = Matte { id: 2, share: 0.5 };
        film.add(1, 2, 0.5, 0.0, &Sample { mattes: [half; 4], ..Sample::default() });
        let frame = film.resolve();
        let ranks = (0..3).flat_map(|layer| [("R", "G"), ("B", "A")].map(|pair| (layer, pair)));
        let found: Vec<(u32, f32)> = ranks
            .map(|(layer, (id, coverage))| {
                let at = |letter: &str| pixel(&frame, &format!("CryptoObject{layer:02}.{letter}"), 1, 2);
                (at(id).to_bits(), at(coverage))
            })
            .collect();
        let coverage = |times: f64| (times / 20.0) as f32;
        let expected = [(2, 7.0), (7, 4.0), (5, 3.0), (3, 2.0), (4, 2.0), (1, 1.0)];
        assert_eq!(found, expected.map(|(id, times)| (id, coverage(times))));
        assert_eq!(
            pixel(&frame, "CryptoObject00.G", 1, 1),
            found[0].1,
            "a hole takes over from its neighbour"
        );
    }

    #[test]
    fn background_has_the_depth_that_blender_writes() {
        let mut film = Film::new(SIZE, whole(), &ALL);
        film.add(0, 0, 1.0, 0.0, &Sample::default());
        let frame = film.resolve();
        assert_eq!(pixel(&frame, "Z", 0, 0), 1e10);
        assert_eq!(pixel(&frame, "leaf_id.X", 0, 0), 0.0);
        assert_eq!(pixel(&frame, "A", 0, 0), 0.0);
    }

    #[test]
    fn only_the_passes_asked_for_have_channels() {
        let names = |passes: &[Pass]| -> Vec<String> {
            Film::new(SIZE, whole(), passes)
                .resolve()
                .channels
                .into_iter()
                .map(|channel| channel.name)
                .collect()
        };
        assert_eq!(names(&[]), ["R", "G", "B", "A"]);
        assert_eq!(names(&[Pass::LeafId, Pass::Depth, Pass::Depth]), ["R", "G", "B", "A", "Z", "leaf_id.X"]);
        assert!(Film::new(SIZE, whole(), &[Pass::Shafts]).nearest_distances_px.is_empty());
    }

    #[test]
    fn a_nan_sample_stays_nan() {
        let mut film = Film::new(SIZE, whole(), &[]);
        for (x, y) in whole().pixels() {
            film.add(x, y, 1.0, 0.0, &leaf(1.0, 1.0, 1));
        }
        film.add(3, 2, 1.0, 0.0, &leaf(f64::NAN, 1.0, 1));
        let defects = film.resolve().check();
        assert_eq!(defects.nan.count, 3);
        let first = defects.nan.first.unwrap();
        assert_eq!((first.channel.as_str(), first.x, first.y), ("R", 3, 2));
    }

    #[test]
    fn samples_outside_a_cropped_window_are_left_to_others() {
        let window = Window { x: 2, y: 1, width: 2, height: 2 };
        let mut film = Film::new(SIZE, window, &[]);
        film.add(1, 1, 1.0, 0.0, &leaf(9.0, 1.0, 1));
        film.add(2, 1, 1.0, 0.0, &leaf(1.0, 1.0, 1));
        assert_eq!(film.holes().len(), 3);
        assert_eq!(pixel(&film.resolve(), "R", 2, 1), 1.0);
    }

    proptest! {
        /// Tiles that do not overlap give the same bits in any order of pasting, and the same as no tiles.
        #[test]
        fn tiles_in_any_order_equal_one_film(
            samples in prop::collection::vec((0_usize..4, 0_usize..3, 0.0..2.0_f64, 0.0..0.7_f64, 0.0..9.0_f64), 0..60),
            split in 1_usize..4,
        ) {
            let left = Window { x: 0, y: 0, width: split, height: 3 };
            let right = Window { x: split, y: 0, width: 4 - split, height: 3 };
            let mut parts = [left, right].map(|window| Film::new(SIZE, window, &ALL));
            let mut one = Film::new(SIZE, whole(), &ALL);
            for (id, &(x, y, weight, distance, radiance)) in samples.iter().enumerate() {
                let sample = leaf(radiance, radiance + 1.0, id as u32 + 1);
                one.add(x, y, weight, distance, &sample);
                parts.iter_mut().for_each(|part| part.add(x, y, weight, distance, &sample));
            }
            for order in [[0, 1], [1, 0]] {
                let mut pasted = Film::new(SIZE, whole(), &ALL);
                order.iter().for_each(|&part| pasted.paste(&parts[part]));
                prop_assert_eq!(pasted.resolve(), one.resolve());
            }
        }
    }
}
