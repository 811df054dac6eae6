//! Surfels: pieces of surfaces that are small beside cells. In go chunks of leaves, out come their surfels in
//! order. Invariant: only one chunk is in memory at a time, and the order never changes.

use crate::ordinates::grid::Grid;
use crate::ordinates::surface_optics::SurfaceOptics;
use glam::DVec3;
use std::sync::Arc;

/// A piece of a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surfel {
    /// Position in world space.
    pub(crate) position: DVec3,
    pub(crate) normal: DVec3,
    /// m^2.
    pub(crate) area: f64,
    /// Share of light that the part itself does not shade: half for a ball, half of which is turned away.
    pub(crate) exposed: f32,
    /// Factor of its emission; 0 if the body that it stands for emits apart.
    pub(crate) emits: f32,
    pub(crate) optics: u32,
}

/// Surfels of a chunk of leaves by the chunk's number; `None` past the last chunk.
type OfChunk<'a> = Box<dyn Fn(usize) -> Option<Vec<Surfel>> + Send + Sync + 'a>;

/// All surfels, generated anew for each pass over them.
pub(crate) struct Surfels<'a> {
    /// Mean area of a leaf, m^2.
    pub(crate) leaf_area_m2: f64,
    optics: Arc<[SurfaceOptics]>,
    of_chunk: OfChunk<'a>,
}

impl<'a> Surfels<'a> {
    /// Surfels of so many leaves.
    pub(crate) fn new(leaves: usize, optics: Arc<[SurfaceOptics]>, of_chunk: OfChunk<'a>) -> Self {
        let mut surfels = Self { leaf_area_m2: 0.0, optics, of_chunk };
        let mut area_m2 = 0.0;
        surfels.for_each(|surfel| area_m2 += surfel.area);
        surfels.leaf_area_m2 = area_m2 / leaves.max(1) as f64;
        surfels
    }

    /// Leaves at places in world space, with one surfel each.
    #[cfg(test)]
    pub(crate) fn of_leaves(places: impl Iterator<Item = DVec3>, area: f64) -> Self {
        let leaf = |position: DVec3| Surfel {
            position,
            normal: DVec3::Y,
            area,
            exposed: 1.0,
            emits: 1.0,
            optics: 0,
        };
        let all: Vec<Surfel> = places.map(leaf).collect();
        let optics = Arc::new([SurfaceOptics::default()]);
        Self::new(all.len(), optics, Box::new(move |chunk| (chunk == 0).then(|| all.clone())))
    }

    fn for_each(&self, tell: impl FnMut(Surfel)) {
        (0..).map_while(&self.of_chunk).flatten().for_each(tell);
    }

    /// Calls back with the surfels in the cells of a grid.
    pub(crate) fn for_each_in(&self, grid: &Grid, mut tell: impl FnMut(&Surfel)) {
        self.for_each(|surfel| {
            if grid.holds(surfel.position) {
                tell(&surfel);
            }
        });
    }

    /// Calls back with chunks of at most `at_once` of them.
    pub(super) fn for_each_chunk_in(&self, grid: &Grid, at_once: usize, mut tell: impl FnMut(&[Surfel])) {
        for mut surfels in (0..).map_while(&self.of_chunk) {
            surfels.retain(|surfel| grid.holds(surfel.position));
            surfels.chunks(at_once).for_each(&mut tell);
        }
    }

    pub(crate) fn optics(&self, surfel: &Surfel) -> &SurfaceOptics {
        &self.optics[surfel.optics as usize]
    }
}
