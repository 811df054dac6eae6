//! Depths of voxels towards a sun. In go voxels and a direction, out come depths of any place by a lattice
//! of lines along it. Invariant: at the lattice's nodes they are exact; between them they are linear.

use super::lattice::Lattice;
use super::{Ray, Voxels};
use glam::DVec3;
use rayon::prelude::*;
use std::fmt;

/// Nodes lie farther apart where there would be more.
const MOST_NODES: f64 = (1 << 23) as f64;

/// Depths in voxels of the densest, towards one direction.
pub struct VoxelDepths {
    /// Unit vectors: across, across, and towards the sun.
    axes: [DVec3; 3],
    low: DVec3,
    spacing: f64,
    /// Towards the sun fastest.
    lattice: Lattice,
    depths: Vec<f32>,
}

/// Addresses alone: depths never change.
impl fmt::Debug for VoxelDepths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VoxelDepths({self:p})")
    }
}

impl VoxelDepths {
    /// `to_light` is a direction of the voxels' own space; nodes lie so far apart, in voxels.
    pub(super) fn new(voxels: &Voxels, to_light: DVec3, spacing: f64) -> Self {
        let up = to_light.normalize();
        let (right, across) = up.any_orthonormal_pair();
        let axes = [right, across, up];
        let (low, high) = voxels.bounds();
        let (mut from, mut to) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let corner = DVec3::new(side(0), side(1), side(2));
            let along = DVec3::from_array(axes.map(|axis| axis.dot(corner)));
            (from, to) = (from.min(along), to.max(along));
        }
        let nodes = (to - from).element_product() / spacing.powi(3);
        let spacing = spacing * (nodes / MOST_NODES).cbrt().max(1.0);
        let size = (to - from).to_array().map(|side| (side / spacing).ceil() as usize + 1);
        let places: Vec<f64> = (0..size[2]).map(|index| spacing * index as f64).collect();
        let mut depths = vec![0.0; size.iter().product()];
        depths.par_chunks_mut(size[2]).enumerate().for_each(|(number, depths)| {
            let [i, j] = [number / size[1], number % size[1]].map(|index| spacing * index as f64);
            let origin = (from.x + i) * right + (from.y + j) * across + from.z * up;
            let line = Ray { origin, direction: up };
            let before = voxels.integrals(&line, &places);
            let all = before[size[2] - 1];
            for (value, before) in depths.iter_mut().zip(before) {
                *value = ((all - before) / voxels.most()) as f32;
            }
        });
        Self { axes, low: from, spacing, lattice: Lattice { size }, depths }
    }

    /// A line of the voxels' own space in the lattice's.
    pub fn line(&self, line: &Ray) -> Ray {
        let along = |way: DVec3| DVec3::from_array(self.axes.map(|axis| axis.dot(way))) / self.spacing;
        Ray { origin: along(line.origin) - self.low / self.spacing, direction: along(line.direction) }
    }

    /// Depth at a place of the lattice's space.
    pub fn of(&self, at: DVec3) -> f64 {
        if self.lattice.holds(at) {
            return self.lattice.at(at, |node| f64::from(self.depths[node]));
        }
        // Before the lattice, seen from the sun, there is nothing; behind it all.
        if at.z < 0.0 { self.of(at.with_z(0.0)) } else { 0.0 }
    }
}
