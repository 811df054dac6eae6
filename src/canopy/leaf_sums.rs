//! Leaf area at nodes, summed over surfels. In go surfels, out come cross-sections by node. Invariant: each
//! node's sum has a fixed order, for any number of threads.

use super::clumping::Clumping;
use super::surfels::{Surfel, Surfels};
use crate::color::Rgb;
use crate::ordinates::cross_sections::{EVEN, LobePairs, OrientedExtinction, OrientedScattering};
use crate::ordinates::grid::Corners;
use crate::ordinates::harmonics::{COUNT, cosine_lobe};
use crate::ordinates::occluders::{CutGrid, OFF_WALL};
use crate::ordinates::surface_optics::SurfaceOptics;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::FRAC_1_PI;

/// Number of surfels that are placed before they are added, which limits memory.
const AT_ONCE: usize = 4096;
/// Number of parts that nodes are divided into, and the fewest nodes of a part.
const PARTS: usize = 32;
const FEWEST_NODES: usize = 512;

/// Leaf area at a node.
pub(super) struct LeafArea {
    pub(super) node: usize,
    /// Leaf area density, 1/m; in clumps the effective density for light from outside.
    pub(super) density: f32,
    /// Emission of leaves, by channel.
    pub(super) emitted: [[f32; COUNT]; 3],
}

/// Leaf area at a node while it is summed.
pub(super) struct LeafSums {
    pub(super) area: LeafArea,
    /// Leaf area density times outer products of normals: xx, yy, zz, xy, yz, zx.
    density_by_normal: [f32; 6],
    pub(super) scattering: OrientedScattering,
    /// Albedo times density.
    sent: Rgb,
}

impl LeafSums {
    fn at(node: usize) -> Self {
        Self {
            area: LeafArea { node, density: 0.0, emitted: [[0.0; COUNT]; 3] },
            density_by_normal: [0.0; 6],
            scattering: OrientedScattering::zero(node),
            sent: Rgb::ZERO,
        }
    }

    /// Applies a clumping index. Light that is scattered several times in a clump no longer depends on the
    /// side of a leaf.
    pub(super) fn clump(&mut self, clumping: &Clumping) {
        let index = clumping.at(self.area.node);
        if index == 1.0 || self.area.density <= 0.0 {
            return;
        }
        let inside = clumping.inside(index, self.sent / f64::from(self.area.density));
        for (channel, inside) in inside.to_array().into_iter().enumerate() {
            let factors = [index * inside, index * index].map(|factor| factor as f32);
            self.scattering.scale(channel, factors);
            self.area.emitted[channel].iter_mut().for_each(|value| *value *= inside as f32);
        }
        self.area.density *= index as f32;
        self.density_by_normal.iter_mut().for_each(|density| *density *= index as f32);
    }

    fn add(&mut self, surfel: &SurfelTerms, density: f32) {
        self.area.density += density;
        for (sum, product) in self.density_by_normal.iter_mut().zip(surfel.normals) {
            *sum += density * product;
        }
        self.sent += f64::from(density) * surfel.sent;
        for channel in 0..3 {
            let factors = [density * surfel.even[channel], density * surfel.odd[channel]];
            self.scattering.add(channel, &surfel.pairs, factors);
            let emitted = density * surfel.emission[channel];
            if emitted > 0.0 {
                for index in EVEN {
                    self.area.emitted[channel][index] += 2.0 * emitted * surfel.lobe[index];
                }
            }
        }
    }

    /// Extinction by Ross' G-function, truncated to harmonics up to l = 2: `3/16 + 15/16 (n.w)^2`.
    pub(super) fn extinction(&self) -> OrientedExtinction {
        let by_normal = self.density_by_normal.map(|density| 15.0 / 16.0 * density);
        OrientedExtinction::new(3.0 / 16.0 * self.area.density, by_normal)
    }
}

/// Terms of a surfel, per leaf area density.
///
/// Irradiances are `E+ = e - o`, `E- = e + o`, from the even and odd parts of the moments along its normal.
/// Radiosities are `B+ + B- = 2 (rho + tau) e` and `B+ - B- = -2 (rho - tau) o`, emitted as `cos / pi`.
struct SurfelTerms {
    normals: [f32; 6],
    lobe: [f32; COUNT],
    pairs: LobePairs,
    even: [f32; 3],
    odd: [f32; 3],
    emission: [f32; 3],
    /// Albedo.
    sent: Rgb,
}

impl SurfelTerms {
    fn of(surfel: &Surfel, optics: &SurfaceOptics) -> Self {
        let DVec3 { x, y, z } = surfel.normal;
        let lobe = cosine_lobe(surfel.normal).map(|value| value as f32);
        let (reflectance, through) = (optics.reflectance, optics.through());
        let channels = |color: Rgb| color.to_array().map(|value| value as f32);
        Self {
            normals: [x * x, y * y, z * z, x * y, y * z, z * x].map(|value| value as f32),
            pairs: LobePairs::of(&lobe),
            lobe,
            even: channels(2.0 * FRAC_1_PI * (reflectance + through)),
            odd: channels(-2.0 * FRAC_1_PI * (reflectance - through)),
            emission: channels(f64::from(surfel.emits) * optics.emission),
            sent: reflectance + through,
        }
    }
}

/// A surfel with its corners.
struct Placed {
    terms: SurfelTerms,
    corners: Corners,
    area_m2: f64,
}

/// Leaf area at the nodes around each surfel, on its side of walls.
pub(super) fn leaf_sums(cut: CutGrid, surfels: &Surfels) -> Vec<LeafSums> {
    const NO_LEAVES: usize = usize::MAX;
    let volume_m3 = cut.grid.cell_volume();
    let (mut sums, mut number_of): (Vec<LeafSums>, _) = (Vec::new(), vec![NO_LEAVES; cut.grid.count()]);
    let placed = |surfel: &Surfel| {
        let off_wall = surfel.position + OFF_WALL * cut.grid.cell_m * surfel.normal;
        Placed {
            terms: SurfelTerms::of(surfel, surfels.optics(surfel)),
            corners: cut.corners(surfel.position, off_wall),
            area_m2: f64::from(surfel.exposed) * surfel.area,
        }
    };
    surfels.for_each_chunk_in(cut.grid, AT_ONCE, |chunk| {
        let placed: Vec<Placed> = chunk.par_iter().map(placed).collect();
        for node in placed.iter().flat_map(|surfel| surfel.corners.seen()).map(|(node, _)| node) {
            if number_of[node] == NO_LEAVES {
                number_of[node] = sums.len();
                sums.push(LeafSums::at(node));
            }
        }
        let count = sums.len().div_ceil(PARTS).max(FEWEST_NODES);
        // By part: the number of a node in it, with the terms and the density to add there.
        let mut shares: Vec<Vec<(usize, &SurfelTerms, f32)>> = vec![Vec::new(); sums.len().div_ceil(count)];
        for Placed { terms, corners, area_m2 } in &placed {
            for (node, weight) in corners.seen() {
                let number = number_of[node];
                shares[number / count].push((number % count, terms, (weight * area_m2 / volume_m3) as f32));
            }
        }
        sums.par_chunks_mut(count).zip(shares).for_each(|(sums, shares)| {
            shares.into_iter().for_each(|(number, terms, density)| sums[number].add(terms, density));
        });
    });
    sums
}
