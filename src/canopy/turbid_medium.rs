//! Leaves and fog as one turbid medium, node by node. In go fog and surfels, out come cross-sections.
//! Invariant: in uniform light from all sides a medium without absorption emits exactly what it removes.
//!
//! Leaves follow Ross 1981, "The radiation regime and architecture of plant stands", with each leaf's own
//! normal instead of a distribution of normals. The G-function's `|cos|` is truncated to harmonics up to l =
//! 2: `3/16 + 15/16 cos^2`. So a node's leaves are two sums of outer products.

use super::clumping::Clumping;
use super::clumps::Clumps;
use super::delta_scaled_fog::{DeltaScaledFog, FogCoefficients};
use super::leaf_sums::{LeafArea, leaf_sums};
use super::node_fog::fog_of_nodes;
use super::surfels::Surfels;
use crate::color::Rgb;
use crate::ordinates::cross_sections::{CrossSections, Extinction};
use crate::ordinates::first_collision_source::FIRST_DEGREES;
use crate::ordinates::moments::Moments;
use crate::ordinates::occluders::CutGrid;
use crate::scene::Bounces;
use std::f64::consts::PI;

/// Minimum leaf area of a node over which power is distributed, as a share of the mean. Rays meet every place
/// on a leaf, but its area is at the nodes around its centre.
const LEAST_SIDES: f32 = 0.02;

/// Leaves and fog in the cells of a grid.
pub(crate) struct TurbidMedium {
    pub(crate) cross_sections: CrossSections,
    /// Coefficients for the first scattering of suns' light in fog: 1/m, by channel, degree and node.
    pub(crate) first_scattering: [[Vec<f32>; FIRST_DEGREES]; 3],
    /// Coefficient of the forward peak, which `first_scattering` lacks at each degree, as if it were not
    /// scattered.
    pub(crate) first_peak: [Vec<f32>; 3],
    /// Leaf area of each node that has leaves.
    leaves: Vec<LeafArea>,
    /// Nodes with emissive fog, and the fog's emission in each direction, W m^-3 sr^-1.
    fog_emission: Vec<(usize, Rgb)>,
    pub(crate) clumping: Clumping,
}

impl TurbidMedium {
    /// Medium of fog and surfels, which stay on their side of walls.
    pub(crate) fn new(cut: CutGrid, fog: &DeltaScaledFog, surfels: &Surfels, bounces: Bounces) -> Self {
        let count = cut.grid.count();
        let channels = || [const { Vec::new() }; 3].map(|_: Vec<f32>| vec![0.0; count]);
        let mut medium = Self {
            cross_sections: CrossSections::zero(count),
            first_scattering: std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; count])),
            first_peak: channels(),
            fog_emission: Vec::new(),
            leaves: Vec::new(),
            clumping: Clumping::of(cut.grid, surfels, bounces),
        };
        if !fog.dimming.is_empty() || fog.emits() {
            medium.add_fog(&fog_of_nodes(cut, fog));
        }
        let mut leaves = leaf_sums(cut, surfels);
        if !medium.clumping.is_none() {
            leaves.iter_mut().for_each(|leaves| leaves.clump(&medium.clumping));
        }
        medium.leaves.reserve_exact(leaves.len());
        medium.cross_sections.set_oriented(leaves.into_iter().map(|leaves| {
            let extinction = leaves.extinction();
            medium.leaves.push(leaves.area);
            (extinction, leaves.scattering)
        }));
        medium
    }

    fn add_fog(&mut self, of_nodes: &[FogCoefficients]) {
        for (node, mean) in of_nodes.iter().enumerate() {
            for channel in 0..3 {
                self.cross_sections.extinction.isotropic[channel][node] = mean.extinction[channel] as f32;
                for degree in 0..3 {
                    self.cross_sections.scattering[channel][degree][node] =
                        mean.scattering[degree][channel] as f32;
                }
                for (degree, first) in mean.first_scattering.iter().enumerate() {
                    self.first_scattering[channel][degree][node] = first[channel] as f32;
                }
                self.first_peak[channel][node] = mean.first_peak[channel] as f32;
            }
            if mean.emission != Rgb::ZERO {
                self.fog_emission.push((node, mean.emission));
            }
        }
    }

    /// Clumps and extinction, for gathering light. `met_again` is the power that leaves of a clump give each
    /// other, W m^-3 by node.
    pub(crate) fn for_gathering(self, met_again: &[[f32; 3]]) -> (Clumps, Extinction) {
        let mut given = vec![[0.0; 3]; met_again.len()];
        let leaves = if met_again.is_empty() { &[] } else { &self.leaves[..] };
        // Light meets an effective area, which is smaller than the area of all leaves; each leaf has two
        // sides.
        let sides = |leaves: &LeafArea| 2.0 * leaves.density / self.clumping.at(leaves.node) as f32;
        let least = LEAST_SIDES * leaves.iter().map(sides).sum::<f32>() / leaves.len().max(1) as f32;
        for leaves in leaves {
            let sides = sides(leaves).max(least);
            if sides > 0.0 {
                given[leaves.node] = met_again[leaves.node].map(|power| power / sides);
            }
        }
        (Clumps::new(self.clumping, given), self.cross_sections.extinction)
    }

    /// Adds the emission of leaves and fog to sources.
    pub(crate) fn emit(&self, sources: &mut Moments) {
        for (node, emission) in &self.fog_emission {
            for channel in 0..3 {
                let mut sum = sources.at(channel, *node);
                sum[0] += ((4.0 * PI).sqrt() * emission[channel]) as f32;
                sources.set(channel, *node, &sum);
            }
        }
        for leaves in &self.leaves {
            for channel in 0..3 {
                let sum = sources.at(channel, leaves.node);
                let emitted = &leaves.emitted[channel];
                sources.set(channel, leaves.node, &std::array::from_fn(|index| sum[index] + emitted[index]));
            }
        }
    }
}
