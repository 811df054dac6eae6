//! Moments of radiance by direction of travel, or of its sources: nine numbers for each channel and node. In
//! go sums over ordinates, out come harmonics. Invariant: laid out by channel, then by harmonic, then by
//! node, so that neighbouring nodes are contiguous for vector operations.

use super::grid::Corners;
use super::harmonics::COUNT;
use crate::color::Rgb;
use rayon::prelude::*;

/// Moments of all nodes of a grid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Moments {
    nodes: usize,
    values: Vec<f32>,
}

impl Moments {
    pub(crate) fn zero(nodes: usize) -> Self {
        Self { nodes, values: vec![0.0; 3 * COUNT * nodes] }
    }

    /// Moments of the same size, all zero.
    pub(crate) fn emptied(&self) -> Self {
        Self::zero(self.nodes)
    }

    fn range(&self, channel: usize, index: usize) -> std::ops::Range<usize> {
        let start = (channel * COUNT + index) * self.nodes;
        start..start + self.nodes
    }

    /// One harmonic of all nodes.
    pub(crate) fn channel(&self, channel: usize, index: usize) -> &[f32] {
        &self.values[self.range(channel, index)]
    }

    pub(crate) fn channel_mut(&mut self, channel: usize, index: usize) -> &mut [f32] {
        let range = self.range(channel, index);
        &mut self.values[range]
    }

    /// All harmonics of one channel, one after the other.
    pub(crate) fn of_channel_mut(&mut self, channel: usize) -> &mut [f32] {
        let start = channel * COUNT * self.nodes;
        &mut self.values[start..start + COUNT * self.nodes]
    }

    pub(crate) fn at(&self, channel: usize, node: usize) -> [f32; COUNT] {
        std::array::from_fn(|index| self.values[(channel * COUNT + index) * self.nodes + node])
    }

    pub(crate) fn set(&mut self, channel: usize, node: usize, values: &[f32; COUNT]) {
        for (index, value) in values.iter().enumerate() {
            self.values[(channel * COUNT + index) * self.nodes + node] = *value;
        }
    }

    /// Applies a function to each harmonic.
    pub(crate) fn map(&self, of_harmonic: impl Fn(&[f32]) -> Vec<f32> + Sync) -> Self {
        let mut mapped = self.emptied();
        let harmonics = self.values.par_chunks_exact(self.nodes);
        let to = mapped.values.par_chunks_exact_mut(self.nodes);
        to.zip(harmonics).for_each(|(to, harmonic)| to.copy_from_slice(&of_harmonic(harmonic)));
        mapped
    }

    /// `self += factor * other`, the factor by channel.
    pub(crate) fn add(&mut self, other: &Self, factor: [f32; 3]) {
        let length = COUNT * self.nodes;
        for (channel, factor) in factor.into_iter().enumerate() {
            let range = channel * length..(channel + 1) * length;
            for (sum, value) in self.values[range.clone()].iter_mut().zip(&other.values[range]) {
                *sum += factor * value;
            }
        }
    }

    pub(crate) fn scale(&mut self, factor: f32) {
        self.values.iter_mut().for_each(|value| *value *= factor);
    }

    /// Sum of the magnitudes of the harmonic of degree 0, over all channels and nodes.
    pub(crate) fn magnitude(&self) -> f64 {
        let of_channel =
            |channel| self.channel(channel, 0).iter().map(|value| f64::from(value.abs())).sum::<f64>();
        (0..3).map(of_channel).sum()
    }

    /// `self += factor * other`.
    pub(crate) fn add_nodes(&mut self, other: &NodeMoments, factor: f32) {
        for channel in 0..3 {
            for index in 0..COUNT {
                let sums = self.channel_mut(channel, index).iter_mut();
                for (sum, node) in sums.zip(&other.0) {
                    *sum += factor * node[channel * COUNT + index];
                }
            }
        }
    }

    /// Sum of the harmonic of degree 0 over all nodes, by channel.
    pub(crate) fn total(&self) -> [f64; 3] {
        [0, 1, 2].map(|channel| self.channel(channel, 0).iter().map(|value| f64::from(*value)).sum())
    }
}

/// Moments by node. All numbers of a node are contiguous, as queries are for single nodes.
#[derive(Clone, Debug)]
pub(crate) struct NodeMoments(Vec<[f32; PER_NODE]>);

/// Nine for each channel, and one to fill eight lanes.
const PER_NODE: usize = 28;

impl NodeMoments {
    pub(crate) fn zero(nodes: usize) -> Self {
        Self(vec![[0.0; PER_NODE]; nodes])
    }

    /// Adds a lobe to eight nodes by their weights, with a factor by channel.
    pub(crate) fn add_lobe(&mut self, corners: &Corners, lobe: &[f64; COUNT], factor: Rgb) {
        let values = factor.to_array().map(|factor| lobe.map(|value| (factor * value) as f32));
        for (&node, &weight) in corners.nodes.iter().zip(&corners.weights) {
            let sums = self.0[node].iter_mut();
            for (sum, value) in sums.zip(values.as_flattened()) {
                *sum += weight as f32 * value;
            }
        }
    }

    pub(crate) fn of(moments: &Moments) -> Self {
        let mut nodes = vec![[0.0; PER_NODE]; moments.nodes];
        for channel in 0..3 {
            for index in 0..COUNT {
                for (node, value) in nodes.iter_mut().zip(moments.channel(channel, index)) {
                    node[channel * COUNT + index] = *value;
                }
            }
        }
        Self(nodes)
    }

    /// Moments of one node, by channel.
    pub(crate) fn at(&self, node: usize) -> [[f32; COUNT]; 3] {
        std::array::from_fn(|channel| std::array::from_fn(|index| self.0[node][channel * COUNT + index]))
    }

    /// Weighted mean of eight nodes, by channel.
    #[inline]
    pub(crate) fn mean(&self, corners: &Corners) -> [[f32; COUNT]; 3] {
        let mut sum = [0.0; PER_NODE];
        for (&node, &weight) in corners.nodes.iter().zip(&corners.weights) {
            let weight = weight as f32;
            for (sum, value) in sum.iter_mut().zip(&self.0[node]) {
                *sum += weight * value;
            }
        }
        std::array::from_fn(|channel| std::array::from_fn(|index| sum[channel * COUNT + index]))
    }
}
