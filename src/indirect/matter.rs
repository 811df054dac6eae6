//! Leaves and fog as one turbid medium, node by node. In go fog and surfels, out come what is lost of light
//! and where the rest goes. Invariant: matter that absorbs nothing, in even light from all sides, sends out
//! exactly what it takes.
//!
//! Leaves follow Ross 1981, "The radiation regime and architecture of plant stands". Each leaf's own normal
//! takes the place of a distribution of normals. Of `|cos|` the harmonics up to l = 2 are kept:
//! `3/16 + 15/16 cos^2`. So a node's leaves are two sums of outer products.

use super::clumping::Clumping;
use super::extinction::{Extinction, NO_LEAVES, Shade};
use super::fog_of_nodes::fog_of_nodes;
use super::grid::Grid;
use super::harmonics::{COUNT, DEGREE, cosine_lobe};
use super::masses::Masses;
use super::moments::Moments;
use super::occluders::OFF_WALL;
use super::scatters::Scatters;
use super::surroundings::{Surfel, Surfels};
use super::swept_fog::SweptFog;
use super::walls::Walls;
use crate::color::Rgb;
use crate::fog::BEAM_DEGREES;
use crate::scene::Bounces;
use glam::DVec3;
use std::f64::consts::FRAC_1_PI;

/// Of the harmonics those that are the same for a direction and its opposite, and those that change sign.
const EVEN: [usize; 6] = [0, 4, 5, 6, 7, 8];
const ODD: [usize; 3] = [1, 2, 3];
/// Products of two of them, each pair once.
const EVEN_PAIRS: usize = 21;
const ODD_PAIRS: usize = 6;
/// A node has leaves of so much of the mean density, at least, where power is shared out among them: rays
/// meet a leaf all over, and what it counts at is its middle.
const LEAST_SIDES: f32 = 0.02;

/// What fills the cells of a grid.
pub(super) struct Matter {
    pub(super) extinction: Extinction,
    /// Of fog what each degree of harmonics gets back: `sigma_s g^l`, 1/m, by channel, degree and node.
    fog_scattering: [[Vec<f32>; 3]; 3],
    /// The same of suns' light as it is scattered first, and its forward peak.
    first_scattering: [[Vec<f32>; BEAM_DEGREES as usize]; 3],
    first_peak: [Vec<f32>; 3],
    /// Nodes that have leaves, with those.
    pub(super) leaves: Vec<Leaves>,
    pub(super) clumping: Clumping,
}

/// The leaves of a node.
#[derive(Clone)]
pub(super) struct Leaves {
    pub(super) node: usize,
    /// Leaf area by volume, 1/m; of masses what meets light from elsewhere.
    density: f32,
    /// The same by outer products of normals: xx, yy, zz, xy, yz, zx.
    density_by_normal: [f32; 6],
    /// By channel and pair of harmonics.
    even: [[f32; EVEN_PAIRS]; 3],
    odd: [[f32; ODD_PAIRS]; 3],
    /// What they emit, by channel.
    emitted: [[f32; COUNT]; 3],
    /// The share of light that they send on, times their density.
    sent: Rgb,
}

impl Leaves {
    fn at(node: usize) -> Self {
        Self {
            node,
            density: 0.0,
            density_by_normal: [0.0; 6],
            even: [[0.0; EVEN_PAIRS]; 3],
            odd: [[0.0; ODD_PAIRS]; 3],
            emitted: [[0.0; COUNT]; 3],
            sent: Rgb::ZERO,
        }
    }

    /// Puts them in masses of a clumping index. Light that is scattered there several times has forgotten on
    /// which side of a leaf.
    fn gather(&mut self, clumping: &Clumping) {
        let index = clumping.at(self.node);
        if index == 1.0 || self.density <= 0.0 {
            return;
        }
        let inside = clumping.inside(index, self.sent / f64::from(self.density));
        for (channel, inside) in inside.to_array().into_iter().enumerate() {
            let [even, odd] = [index * inside, index * index].map(|factor| factor as f32);
            self.even[channel].iter_mut().for_each(|pair| *pair *= even);
            self.odd[channel].iter_mut().for_each(|pair| *pair *= odd);
            self.emitted[channel].iter_mut().for_each(|value| *value *= inside as f32);
        }
        self.density *= index as f32;
        self.density_by_normal.iter_mut().for_each(|density| *density *= index as f32);
    }

    fn add(&mut self, surfel: &SurfelTerms, density: f32) {
        self.density += density;
        for (sum, product) in self.density_by_normal.iter_mut().zip(surfel.normals) {
            *sum += density * product;
        }
        self.sent += f64::from(density) * surfel.sent;
        for channel in 0..3 {
            let (even, odd) = (density * surfel.even[channel], density * surfel.odd[channel]);
            for (sum, pair) in self.even[channel].iter_mut().zip(&surfel.even_pairs) {
                *sum += even * pair;
            }
            for (sum, pair) in self.odd[channel].iter_mut().zip(&surfel.odd_pairs) {
                *sum += odd * pair;
            }
            let emitted = density * surfel.emission[channel];
            if emitted > 0.0 {
                for index in EVEN {
                    self.emitted[channel][index] += 2.0 * emitted * surfel.lobe[index];
                }
            }
        }
    }

    /// What they make of the moments of light in one channel, added to `source`.
    fn scatter(&self, channel: usize, moments: &[f32; COUNT], source: &mut [f32; COUNT]) {
        multiply(&EVEN, &self.even[channel], moments, source);
        multiply(&ODD, &self.odd[channel], moments, source);
    }
}

/// `source += M moments` for a symmetric matrix of which each pair is kept once.
fn multiply<const N: usize>(
    which: &[usize; N],
    pairs: &[f32],
    moments: &[f32; COUNT],
    source: &mut [f32; COUNT],
) {
    let mut pair = 0;
    for i in 0..N {
        for j in i..N {
            source[which[i]] += pairs[pair] * moments[which[j]];
            if i != j {
                source[which[j]] += pairs[pair] * moments[which[i]];
            }
            pair += 1;
        }
    }
}

fn pairs<const N: usize, const M: usize>(which: &[usize; N], lobe: &[f32; COUNT]) -> [f32; M] {
    let mut products = [0.0; M];
    let mut pair = 0;
    for i in 0..N {
        for j in i..N {
            products[pair] = lobe[which[i]] * lobe[which[j]];
            pair += 1;
        }
    }
    products
}

/// What a surfel adds to its nodes, per leaf area by volume.
///
/// Irradiances are `E+ = e - o`, `E- = e + o` by the even and odd parts of the moments along its normal; what
/// leaves is `B+ + B- = 2 (rho + tau) e` and `B+ - B- = -2 (rho - tau) o`, sent out over `cos / pi`.
struct SurfelTerms {
    normals: [f32; 6],
    lobe: [f32; COUNT],
    even_pairs: [f32; EVEN_PAIRS],
    odd_pairs: [f32; ODD_PAIRS],
    even: [f32; 3],
    odd: [f32; 3],
    emission: [f32; 3],
    /// Share of light that it sends on.
    sent: Rgb,
}

impl SurfelTerms {
    fn of(surfel: &Surfel, scatters: &Scatters) -> Self {
        let DVec3 { x, y, z } = surfel.normal;
        let lobe = cosine_lobe(surfel.normal).map(|value| value as f32);
        let (reflectance, transmittance) = (scatters.reflectance, scatters.transmittance);
        let channels = |color: Rgb| color.to_array().map(|value| value as f32);
        Self {
            normals: [x * x, y * y, z * z, x * y, y * z, z * x].map(|value| value as f32),
            even_pairs: pairs(&EVEN, &lobe),
            odd_pairs: pairs(&ODD, &lobe),
            lobe,
            even: channels(2.0 * FRAC_1_PI * (reflectance + transmittance)),
            odd: channels(-2.0 * FRAC_1_PI * (reflectance - transmittance)),
            emission: channels(scatters.emission),
            sent: reflectance + transmittance,
        }
    }
}

impl Matter {
    /// Fog, which `eye` is the origin of in world space, and surfels, which stay on their side of walls.
    pub(super) fn new(
        (grid, walls): (&Grid, &Walls),
        eye: DVec3,
        fog: &SweptFog,
        surfels: &Surfels,
        bounces: Bounces,
    ) -> Self {
        let count = grid.count();
        let channels = || [const { Vec::new() }; 3].map(|_: Vec<f32>| vec![0.0; count]);
        let mut matter = Self {
            extinction: Extinction::zero(count),
            fog_scattering: [channels(), channels(), channels()],
            first_scattering: std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; count])),
            first_peak: channels(),
            leaves: Vec::new(),
            clumping: Clumping::of(grid, surfels, bounces),
        };
        if !fog.dimming.is_empty() {
            matter.add_fog(grid, walls, (fog, eye));
        }
        for surfel in &surfels.all {
            let terms = SurfelTerms::of(surfel, surfels.scatters(surfel));
            matter.add_leaf(grid, walls, (surfel, &terms));
        }
        if !matter.clumping.is_none() {
            matter.leaves.iter_mut().for_each(|leaves| leaves.gather(&matter.clumping));
        }
        let shade = |leaves: &Leaves| Shade::of(leaves.density, leaves.density_by_normal);
        matter.extinction.shades = matter.leaves.iter().map(shade).collect();
        matter
    }

    /// What fog gets back of one degree of a sun's light as it is scattered first, 1/m, by node; up to 5.
    pub(super) fn first_scattering(&self, channel: usize, degree: usize) -> &[f32] {
        &self.first_scattering[channel][degree]
    }

    /// What that leaves out of each degree, as if it were not scattered.
    pub(super) fn first_peak(&self, channel: usize) -> &[f32] {
        &self.first_peak[channel]
    }

    fn add_fog(&mut self, grid: &Grid, walls: &Walls, (fog, eye): (&SweptFog, DVec3)) {
        for (node, mean) in fog_of_nodes(grid, &walls.occluders, (fog, eye)).iter().enumerate() {
            for channel in 0..3 {
                self.extinction.fog[channel][node] = mean.extinction[channel] as f32;
                for degree in 0..3 {
                    self.fog_scattering[channel][degree][node] = mean.scattering[degree][channel] as f32;
                }
                for (degree, first) in mean.first_scattering.iter().enumerate() {
                    self.first_scattering[channel][degree][node] = first[channel] as f32;
                }
                self.first_peak[channel][node] = mean.first_peak[channel] as f32;
            }
        }
    }

    fn add_leaf(&mut self, grid: &Grid, walls: &Walls, (surfel, terms): (&Surfel, &SurfelTerms)) {
        let corners = walls.occluders.corners(
            grid,
            surfel.position,
            surfel.position + OFF_WALL * grid.cell_m * surfel.normal,
        );
        for (node, weight) in corners.nodes.into_iter().zip(corners.weights) {
            if weight > 0.0 {
                let area = f64::from(surfel.exposed) * surfel.area;
                self.leaves_mut(node).add(terms, (weight * area / grid.cell_volume()) as f32);
            }
        }
    }

    fn leaves_mut(&mut self, node: usize) -> &mut Leaves {
        let number = &mut self.extinction.leaves_of[node];
        if *number == NO_LEAVES {
            *number = self.leaves.len() as u32;
            self.leaves.push(Leaves::at(node));
        }
        &mut self.leaves[*number as usize]
    }

    /// Where light goes next: the sources that matter makes of the moments of light, per metre and steradian;
    /// leaves alone of light that fog is not to see.
    pub(super) fn scatter(&self, light: &Moments, is_seen_by_fog: bool) -> Moments {
        let mut sources = Moments::zero(self.extinction.leaves_of.len());
        for channel in 0..3 {
            for (index, degree) in DEGREE.into_iter().enumerate().filter(|_| is_seen_by_fog) {
                let share = &self.fog_scattering[channel][degree];
                let into = sources.channel_mut(channel, index);
                for ((into, light), share) in into.iter_mut().zip(light.channel(channel, index)).zip(share) {
                    *into = share * light;
                }
            }
            for leaves in &self.leaves {
                let mut source = sources.at(channel, leaves.node);
                leaves.scatter(channel, &light.at(channel, leaves.node), &mut source);
                sources.set(channel, leaves.node, &source);
            }
        }
        sources
    }

    /// What is known of it by who gathers light: masses of its leaves that get power of each other, W m^-3 by
    /// node.
    pub(super) fn told(self, met_again: &[[f32; 3]]) -> (Masses, Extinction) {
        let mut given = vec![[0.0; 3]; met_again.len()];
        let leaves = if met_again.is_empty() { &[] } else { &self.leaves[..] };
        // What meets light is less than the area of all leaves, which have two sides each.
        let sides = |leaves: &Leaves| 2.0 * leaves.density / self.clumping.at(leaves.node) as f32;
        let least = LEAST_SIDES * leaves.iter().map(sides).sum::<f32>() / leaves.len().max(1) as f32;
        for leaves in leaves {
            let sides = sides(leaves).max(least);
            if sides > 0.0 {
                given[leaves.node] = met_again[leaves.node].map(|power| power / sides);
            }
        }
        (Masses::new(self.clumping, given), self.extinction)
    }

    /// What leaves emit by themselves, as sources.
    pub(super) fn emit(&self, sources: &mut Moments) {
        for leaves in &self.leaves {
            for channel in 0..3 {
                let sum = sources.at(channel, leaves.node);
                let emitted = &leaves.emitted[channel];
                sources.set(channel, leaves.node, &std::array::from_fn(|index| sum[index] + emitted[index]));
            }
        }
    }
}
