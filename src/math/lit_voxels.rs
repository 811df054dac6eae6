//! Voxels that light of suns, lamps and a sky passes through. In go voxels, out come depths towards lights
//! and approximate integrals. Invariant: depths of a light are computed once.

use super::coarse_voxels::CoarseVoxels;
use super::{Ray, Recent, VoxelDepths, VoxelMeans, Voxels};
use glam::DVec3;
use std::sync::{Arc, OnceLock};

/// Maximum spacing of the nodes of a light's lattice, in voxels.
const SPACING: f64 = 0.5;

/// Tolerance of a lattice in optical depth, between its nodes.
const TOLERANCE: f64 = 0.01;

/// Optical depth at which a lattice's depths are cut off: a fourth of it is opaque.
const DEEPEST: f64 = 300.0;

/// Optical depth of a voxel above which ways are opaque after a few voxels: they are traversed if a lattice
/// would have too many nodes.
const THICK: f64 = 2.0;
const MANY_NODES: f64 = (1 << 24) as f64;

/// Maximum numbers of suns and lamps whose depths are cached.
const MOST_SUNS: usize = 8;
const MOST_LAMPS: usize = 32;

/// Voxels with cached depths towards lights.
#[derive(Debug)]
pub struct LitVoxels {
    /// The voxels.
    pub voxels: Voxels,
    /// Depths and means by directions and by places in voxel space.
    suns: Recent<(DVec3, f64), Arc<VoxelDepths>>,
    lamps: Recent<(DVec3, f64), Arc<VoxelMeans>>,
    /// Voxels of two, four and eight times the size, computed on first use.
    coarse: [OnceLock<Option<CoarseVoxels>>; 3],
}

impl From<Voxels> for LitVoxels {
    fn from(voxels: Voxels) -> Self {
        Self { voxels, suns: Recent::default(), lamps: Recent::default(), coarse: Default::default() }
    }
}

impl LitVoxels {
    /// Integral over a range of a line, in units of `t`, from voxels of at most `times` the size.
    pub fn rough_integral(&self, line: &Ray, range: (f64, f64), times: f64) -> f64 {
        let walked = || self.voxels.integral(line, range);
        self.coarse(times).map_or_else(walked, |coarse| coarse.integral(line, range))
    }

    /// Approximate integral from a line's origin, in its direction or one near it.
    pub fn rough_integral_to_sky(&self, line: &Ray, times: f64) -> f64 {
        let walked = || self.voxels.integral(line, (0.0, f64::INFINITY));
        self.coarse(times).map_or_else(walked, |coarse| coarse.integral_to_sky(line))
    }

    fn coarse(&self, times: f64) -> Option<&CoarseVoxels> {
        let level = (0..self.coarse.len()).rev().find(|level| f64::from(2 << level) <= times)?;
        self.coarse[level].get_or_init(|| CoarseVoxels::new(&self.voxels, 2 << level)).as_ref()
    }

    /// Depths towards a direction in voxel space, computed once. `of_voxel`, the optical depth of a voxel at
    /// maximum density, sets the resolution; `None` where that would be too fine.
    pub fn depths_towards(&self, to_light: DVec3, of_voxel: f64) -> Option<Arc<VoxelDepths>> {
        let (spacing, (low, high)) = (spacing(of_voxel), self.voxels.bounds());
        if of_voxel > THICK && (high - low).element_product() / spacing.powi(3) > MANY_NODES {
            return None;
        }
        let made = || VoxelDepths::new(&self.voxels, to_light, (spacing, deepest(spacing))).into();
        Some(self.suns.of((to_light, spacing), MOST_SUNS, made))
    }

    /// Mean densities on the ways to a place in voxel space, computed once, with the same resolution.
    pub fn means_to(&self, lamp: DVec3, of_voxel: f64) -> Arc<VoxelMeans> {
        let spacing = spacing(of_voxel);
        self.lamps.of((lamp, spacing), MOST_LAMPS, || VoxelMeans::new(&self.voxels, lamp, spacing).into())
    }
}

/// Spacing of nodes, in voxels, at which interpolation errs by the tolerance: where density grows by
/// `of_voxel` a voxel the error is `of_voxel * spacing^2 / 8`. It is a power of 2, so that keyed density
/// changes it in few steps.
fn spacing(of_voxel: f64) -> f64 {
    let wanted = (8.0 * TOLERANCE / of_voxel).sqrt() / SPACING;
    SPACING * wanted.log2().floor().clamp(-8.0, 0.0).exp2()
}

/// Depth at which a lattice is cut off, in voxels of maximum density. Where nodes are closer than `SPACING`,
/// such a voxel has an optical depth of at most `8 TOLERANCE / spacing^2`, and at least a fourth of it.
fn deepest(spacing: f64) -> f64 {
    if spacing < SPACING { DEEPEST * spacing.powi(2) / (8.0 * TOLERANCE) } else { f64::INFINITY }
}
