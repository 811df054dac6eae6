//! Voxels that suns, lamps and a sky shine through. In go voxels, out come depths towards lights and rough
//! integrals. Invariant: what lights know of the voxels is found once.

use super::coarse_voxels::CoarseVoxels;
use super::{Ray, Recent, VoxelDepths, VoxelMeans, Voxels};
use glam::DVec3;
use std::sync::{Arc, OnceLock};

/// Spacing of the nodes of a light's lattice, in voxels, at most.
const SPACING: f64 = 0.5;

/// Optical depth by which a lattice may err between its nodes.
const TOLERANCE: f64 = 0.01;

/// Where voxels have so much optical depth, a way is opaque after few: it is walked if a lattice for it would
/// have too many nodes.
const THICK: f64 = 2.0;
const MANY_NODES: f64 = (1 << 24) as f64;

/// Suns and lamps whose depths are kept.
const MOST_SUNS: usize = 8;
const MOST_LAMPS: usize = 32;

/// Voxels that light shines through.
#[derive(Debug)]
pub struct LitVoxels {
    /// Them.
    pub voxels: Voxels,
    /// By directions and by places of the voxels' own space.
    suns: Recent<(DVec3, f64), Arc<VoxelDepths>>,
    lamps: Recent<(DVec3, f64), Arc<VoxelMeans>>,
    /// Twice, four and eight times as wide, once they have been asked for.
    coarse: [OnceLock<Option<CoarseVoxels>>; 3],
}

impl From<Voxels> for LitVoxels {
    fn from(voxels: Voxels) -> Self {
        Self { voxels, suns: Recent::default(), lamps: Recent::default(), coarse: Default::default() }
    }
}

impl LitVoxels {
    /// The integral over a part of a line, in units of `t`, where voxels may count as wider ones: at most
    /// `times` as wide.
    pub fn rough_integral(&self, line: &Ray, range: (f64, f64), times: f64) -> f64 {
        let walked = || self.voxels.integral(line, range);
        self.coarse(times).map_or_else(walked, |coarse| coarse.integral(line, range))
    }

    /// Integral from where a line begins, where the line may have one of some directions about its own.
    pub fn rough_integral_to_sky(&self, line: &Ray, times: f64) -> f64 {
        let walked = || self.voxels.integral(line, (0.0, f64::INFINITY));
        self.coarse(times).map_or_else(walked, |coarse| coarse.integral_to_sky(line))
    }

    fn coarse(&self, times: f64) -> Option<&CoarseVoxels> {
        let level = (0..self.coarse.len()).rev().find(|level| f64::from(2 << level) <= times)?;
        self.coarse[level].get_or_init(|| CoarseVoxels::new(&self.voxels, 2 << level)).as_ref()
    }

    /// Depths towards a direction of its own space, found once. The optical depth of a voxel that is as dense
    /// as the densest says how fine; `None` where it would be too fine.
    pub fn depths_towards(&self, to_light: DVec3, of_voxel: f64) -> Option<Arc<VoxelDepths>> {
        let (spacing, (low, high)) = (spacing(of_voxel), self.voxels.bounds());
        if of_voxel > THICK && (high - low).element_product() / spacing.powi(3) > MANY_NODES {
            return None;
        }
        let made = || VoxelDepths::new(&self.voxels, to_light, spacing).into();
        Some(self.suns.of((to_light, spacing), MOST_SUNS, made))
    }

    /// Mean densities on the ways to a place of its own space, found once, as fine.
    pub fn means_to(&self, lamp: DVec3, of_voxel: f64) -> Arc<VoxelMeans> {
        let spacing = spacing(of_voxel);
        self.lamps.of((lamp, spacing), MOST_LAMPS, || VoxelMeans::new(&self.voxels, lamp, spacing).into())
    }
}

/// Spacing in voxels of nodes between which lines err by a tolerance: where density grows by `of_voxel` a
/// voxel they err by `of_voxel * spacing^2 / 8`. Density that is keyed changes it in steps of 2.
fn spacing(of_voxel: f64) -> f64 {
    let wanted = (8.0 * TOLERANCE / of_voxel).sqrt() / SPACING;
    SPACING * wanted.log2().floor().clamp(-8.0, 0.0).exp2()
}
