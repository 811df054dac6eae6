//! Mean densities of voxels on the ways to a lamp. In go voxels and its place, out come means from any place,
//! from a lattice. Invariant: at the lattice's nodes they are exact; between them they are linear.
//!
//! Depths have the tip of a cone at the lamp, which a lattice cannot represent; means have none. A node's
//! mean is computed on first use, with the same result for any thread.

use super::lattice::Lattice;
use super::{Ray, Voxels};
use glam::DVec3;
use std::fmt;
use std::sync::atomic::{AtomicU32, Ordering};

/// Maximum number of nodes; their distance grows to keep it, as means over many voxels change little.
const MOST_NODES: f64 = (1 << 18) as f64;

/// Bits that mark a mean as not computed.
const UNKNOWN: u32 = u32::MAX;

/// Means relative to the densest voxel, towards one place.
pub struct VoxelMeans {
    lamp: DVec3,
    low: DVec3,
    spacing: f64,
    lattice: Lattice,
    /// Bits of each node's mean.
    means: Vec<AtomicU32>,
}

/// Prints the address alone: means never change.
impl fmt::Debug for VoxelMeans {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "VoxelMeans({self:p})")
    }
}

impl VoxelMeans {
    /// Lattice of means; `lamp` is a place in voxel space, `spacing` the minimum distance of nodes, in
    /// voxels.
    pub(super) fn new(voxels: &Voxels, lamp: DVec3, spacing: f64) -> Self {
        let (low, high) = voxels.bounds();
        let nodes = (high - low).element_product() / spacing.powi(3);
        let spacing = spacing * (nodes / MOST_NODES).cbrt().max(1.0);
        let size = (high - low).to_array().map(|side| (side / spacing).ceil() as usize + 1);
        let lattice = Lattice { size };
        let means = (0..lattice.count()).map(|_| AtomicU32::new(UNKNOWN)).collect();
        Self { lamp, low, spacing, lattice, means }
    }

    /// Mean from a place; `voxels` are those that the lattice was made for.
    pub fn of(&self, voxels: &Voxels, place: DVec3) -> f64 {
        let [at, lamp] = [place, self.lamp].map(|place| (place - self.low) / self.spacing);
        let mean = |at: DVec3| self.lattice.at(at, |node| self.of_node(voxels, node));
        if self.lattice.holds(at) {
            return mean(at);
        }
        // From outside, there is no fog up to the point where the way enters the voxels.
        let (way, last) = (lamp - at, self.lattice.last());
        let (a, b) = (-at / way, (last - at) / way);
        let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
        if !(0.0 < enter && enter < leave.min(1.0)) {
            return 0.0;
        }
        (1.0 - enter) * mean((at + enter * way).clamp(DVec3::ZERO, last))
    }

    fn of_node(&self, voxels: &Voxels, node: usize) -> f64 {
        let known = self.means[node].load(Ordering::Relaxed);
        if known != UNKNOWN {
            return f64::from(f32::from_bits(known));
        }
        let origin = self.low + self.spacing * self.lattice.place(node);
        let way = Ray { origin, direction: self.lamp - origin };
        let is_there = way.direction == DVec3::ZERO;
        let of_way = if is_there { voxels.at(self.lamp) } else { voxels.integral(&way, (0.0, 1.0)) };
        let mean = (of_way / voxels.most()) as f32;
        self.means[node].store(mean.to_bits(), Ordering::Relaxed);
        f64::from(mean)
    }
}
