//! Cryptomatte's ids and coverages of pixels. In go ids with shares of samples, out come ranked channels.
//! Invariant: an id occurs once in a pixel's list, and none is dropped before ranking.

use super::pixel_sum::{self, PixelSum};
use super::{Channel, Precision};
use crate::passes::MATTE_LAYER;
use crate::transport::{MATTES_OF_A_SAMPLE, Matte};
/// Number of layers, with two ids and coverages each: six ranks, Blender's default.
const LAYERS: usize = 3;

/// Packed numbers of a sample.
pub(super) const PACKED: usize = 2 * MATTES_OF_A_SAMPLE;

/// Ids of a pixel, each with the weight of the samples that show it, in the order of arrival.
#[derive(Clone, Debug, Default)]
pub(super) struct MatteList(Vec<(u32, f64)>);

impl MatteList {
    pub(super) fn add(&mut self, id: u32, weight: f64) {
        match self.0.iter_mut().find(|(known, _)| *known == id) {
            Some((_, sum)) => *sum += weight,
            None => self.0.push((id, weight)),
        }
    }

    /// Adds another list of the same pixel.
    pub(super) fn append(&mut self, other: &Self) {
        other.0.iter().for_each(|&(id, weight)| self.add(id, weight));
    }

    /// Adds the packed shares of a sample.
    pub(super) fn add_packed(&mut self, packed: &[f32], weight: f64) {
        for pair in packed.chunks_exact(2) {
            if pair[1] > 0.0 {
                self.add(pair[0].to_bits(), weight * f64::from(pair[1]));
            }
        }
    }

    /// Ids by decreasing weight; equal ones by increasing id.
    fn ranked(&self) -> Vec<(u32, f64)> {
        let mut ranked = self.0.clone();
        ranked.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        ranked
    }
}

/// Packs a sample's shares: ids as the bits of single-precision numbers.
pub(super) fn packed(mattes: &[Matte; MATTES_OF_A_SAMPLE]) -> [f32; PACKED] {
    let mut packed = [0.0; PACKED];
    for (pair, matte) in packed.chunks_exact_mut(2).zip(mattes) {
        pair.copy_from_slice(&[f32::from_bits(matte.id), matte.share]);
    }
    packed
}

/// Channels of a film's pixels, whose samples have the total `weights`: `CryptoObject00.RGBA` and so on, with
/// an id and its coverage in each pair (Cryptomatte specification 1.2.0).
pub(super) fn channels(lists: &[MatteList], weights: &[PixelSum]) -> Vec<Channel> {
    let names = (0..LAYERS).flat_map(|layer| "RGBA".chars().map(move |letter| (layer, letter)));
    let mut channels: Vec<Channel> = names
        .map(|(layer, letter)| {
            let name = format!("{MATTE_LAYER}{layer:02}.{letter}");
            Channel::new(&name, Precision::Float, vec![0.0; lists.len()])
        })
        .collect();
    for (pixel, (list, weight)) in lists.iter().zip(weights).enumerate() {
        for (rank, (id, sum)) in list.ranked().into_iter().take(2 * LAYERS).enumerate() {
            channels[2 * rank].pixels[pixel] = f32::from_bits(id);
            channels[2 * rank + 1].pixels[pixel] = (sum / pixel_sum::value(weight)) as f32;
        }
    }
    channels
}
