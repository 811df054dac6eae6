//! Mean densities of voxels on the ways to a lamp. In go voxels and its place, out come means from any place
//! among them, by a lattice. Invariant: at the lattice's nodes they are exact; between them they are linear.
//!
//! Depths have the tip of a cone at the lamp, which no lattice shows. Means have none.

use super::lattice::Lattice;
use super::{Ray, Voxels};
use glam::DVec3;
use rayon::prelude::*;
use std::fmt;

/// Spacing of the nodes, in voxels.
const SPACING: f64 = 0.5;

/// They lie farther apart where there would be more.
const MOST_NODES: f64 = (1 << 20) as f64;

/// Means by the densest voxel, towards one place.
pub struct VoxelMeans {
    low: DVec3,
    spacing: f64,
    means: Lattice,
}

/// Addresses alone: means never change.
impl fmt::Debug for VoxelMeans {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VoxelMeans({self:p})")
    }
}

impl VoxelMeans {
    /// `lamp` is a place of the voxels' own space.
    pub(super) fn new(voxels: &Voxels, lamp: DVec3) -> Self {
        let (low, high) = voxels.bounds();
        let nodes = (high - low).element_product() / SPACING.powi(3);
        let spacing = SPACING * (nodes / MOST_NODES).cbrt().max(1.0);
        let size = (high - low).to_array().map(|side| (side / spacing).ceil() as usize + 1);
        let [_, rows, row] = size;
        let mut values = vec![0.0; size.iter().product()];
        values.par_chunks_mut(row).enumerate().for_each(|(number, means)| {
            for (up, mean) in means.iter_mut().enumerate() {
                let node = [number / rows, number % rows, up].map(|index| spacing * index as f64);
                let origin = low + DVec3::from_array(node);
                let way = Ray { origin, direction: lamp - origin };
                let is_there = way.direction == DVec3::ZERO;
                let of_way = if is_there { voxels.at(lamp) } else { voxels.integral(&way, (0.0, 1.0)) };
                *mean = (of_way / voxels.most()) as f32;
            }
        });
        Self { low, spacing, means: Lattice { size, values } }
    }

    /// The mean from a place; `None` beyond the voxels.
    pub fn of(&self, place: DVec3) -> Option<f64> {
        let at = (place - self.low) / self.spacing;
        self.means.holds(at).then(|| self.means.at(at))
    }
}
