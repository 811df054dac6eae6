//! Walls between the nodes of a grid: ground, trunks, rooms. In go the links between nodes that they cut, and
//! the patches that nodes see instead, out comes radiance that walls scatter. Invariant: no light passes a
//! link that a wall cuts, however thin the wall is.

use super::faces::Faces;
use super::grid::Grid;
use super::occluders::{CellTriangle, Occluders};
use super::surface_optics::SurfaceOptics;
use crate::color::Rgb;
use glam::{DVec3, IVec3};
use std::f64::consts::PI;

/// Number of links of a node: to its 26 neighbours and to itself.
pub(crate) const LINKS: usize = 27;
const NO_PATCH: u32 = u32::MAX;

/// Number of the link of a step to a neighbour.
pub(crate) fn link_of(step: [i32; 3]) -> usize {
    (step[0] + 1 + 3 * (step[1] + 1) + 9 * (step[2] + 1)) as usize
}

/// Step of a link, the inverse of [`link_of`].
pub(crate) fn step_of(link: usize) -> IVec3 {
    IVec3::new(link as i32 % 3 - 1, link as i32 / 3 % 3 - 1, link as i32 / 9 - 1)
}

/// A node with cut links: some of its neighbours are behind walls.
pub(crate) struct CutNode {
    pub(crate) node: usize,
    /// The first patch along each link.
    seen: [Seen; LINKS],
}

/// A patch as a node sees it.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    /// Position on the link, as a share of its length.
    pub(crate) at: f32,
    pub(crate) patch: u32,
}

impl CutNode {
    pub(crate) fn open(node: usize) -> Self {
        Self { node, seen: [Seen { at: 1.0, patch: NO_PATCH }; LINKS] }
    }

    /// The patch that is seen along a link, if a wall cuts it.
    pub(crate) fn wall_at(&self, link: usize) -> Option<usize> {
        let patch = self.seen[link].patch;
        (patch != NO_PATCH).then_some(patch as usize)
    }

    /// Room around the node along an axis, in cells: on each side up to the wall that cuts the link, or half
    /// a cell.
    pub(crate) fn room(&self, axis: usize) -> f32 {
        /// Minimum room: between walls closer than that, light is transported as in such a gap.
        const LEAST: f32 = 0.25;
        let to_side = |step: i32| {
            let mut steps = [0; 3];
            steps[axis] = step;
            let link = link_of(steps);
            if self.wall_at(link).is_some() { self.seen[link].at } else { 0.5 }
        };
        (to_side(-1) + to_side(1)).max(LEAST)
    }

    /// Whether the node sees a position on a link, given as a share of its length: no wall lies before it.
    pub(crate) fn sees(&self, link: usize, at: f64) -> bool {
        f64::from(self.seen[link].at) > at
    }

    pub(crate) fn cut(&mut self, link: usize, seen: Seen) {
        self.seen[link] = seen;
    }

    pub(crate) fn cut_links(&self) -> impl Iterator<Item = &Seen> {
        self.seen.iter().filter(|seen| seen.patch != NO_PATCH)
    }

    /// Links that are cut, with their numbers.
    pub(crate) fn cut_links_mut(&mut self) -> impl Iterator<Item = (usize, &mut Seen)> {
        self.seen.iter_mut().enumerate().filter(|(_, seen)| seen.patch != NO_PATCH)
    }
}

/// Part of a wall that the nodes around one cell see, on one side.
pub(crate) struct Patch {
    /// Position in world space, where a node first saw it.
    pub(crate) position: DVec3,
    /// Normal, towards the nodes that see it.
    pub(crate) normal: DVec3,
    /// Mean optics of the visible places, as walls have textures.
    pub(crate) optics: SurfaceOptics,
    /// Nodes that see it, with their weights.
    pub(crate) seen_by: Vec<(u32, f32)>,
    /// The patch at the same place on the other side, for transmitted light.
    pub(crate) behind: Option<u32>,
}

/// All walls around a grid's nodes.
pub(crate) struct Walls {
    pub(super) nodes: Vec<CutNode>,
    pub(crate) patches: Vec<Patch>,
    pub(crate) faces: Faces,
    pub(crate) occluders: Occluders,
}

impl Walls {
    /// Walls from cut nodes and their patches; `about_cell` has triangles with the lowest nodes of the cells
    /// near them.
    pub(crate) fn new(
        grid: &Grid,
        nodes: Vec<CutNode>,
        mut patches: Vec<Patch>,
        about_cell: Vec<(u32, CellTriangle)>,
    ) -> Self {
        for cut in &nodes {
            for seen in cut.cut_links() {
                patches[seen.patch as usize].seen_by.push((cut.node as u32, 1.0 - 0.9 * seen.at));
            }
        }
        let normal_of = |seen: &Seen| patches[seen.patch as usize].normal;
        let seen_by = |cut: &CutNode| (cut.node, cut.cut_links().map(normal_of).collect());
        let faces = Faces::new(grid.count(), nodes.iter().map(seen_by));
        Self { nodes, patches, faces, occluders: Occluders::new(grid, about_cell) }
    }

    /// Whether some walls stand at an angle to others, and so light each other.
    pub(crate) fn are_at_angles(&self) -> bool {
        /// Share of all patches below which such walls are neglected.
        const FEW: f64 = 0.05;
        let mut along = [0; 3];
        for patch in &self.patches {
            let normal = patch.normal.abs();
            along[(0..3).max_by(|a, b| normal[*a].total_cmp(&normal[*b])).expect("three")] += 1;
        }
        let most = along.into_iter().max().unwrap_or(0);
        (self.patches.len() - most) as f64 > FEW * self.patches.len() as f64
    }

    /// Radiance that each patch scatters of the irradiance on all patches: by reflection of its own, and by
    /// transmission of that behind it.
    pub(crate) fn scattered(&self, irradiances: &[Rgb]) -> Vec<Rgb> {
        self.reflected_and_through(irradiances, irradiances)
    }

    /// As [`Self::scattered`], where less irradiance is reflected than passes through.
    pub(crate) fn reflected_and_through(&self, irradiances: &[Rgb], through: &[Rgb]) -> Vec<Rgb> {
        let of_patch = |(patch, &irradiance): (&Patch, &Rgb)| {
            let through = patch.behind.map_or(Rgb::ZERO, |behind| {
                self.patches[behind as usize].optics.transmittance * through[behind as usize]
            });
            (patch.optics.reflectance * irradiance + through) / PI
        };
        self.patches.iter().zip(irradiances).map(of_patch).collect()
    }

    /// Irradiance on each patch from the nodes that see it; `irradiance` returns that for a node and a
    /// normal.
    pub(crate) fn irradiances(&self, irradiance: impl Fn(usize, DVec3) -> Rgb) -> Vec<Rgb> {
        let of_patch = |patch: &Patch| {
            let (mut weighted, mut all) = (Rgb::ZERO, 0.0);
            for &(node, weight) in &patch.seen_by {
                weighted += f64::from(weight) * irradiance(node as usize, patch.normal);
                all += f64::from(weight);
            }
            if all > 0.0 { weighted / all } else { Rgb::ZERO }
        };
        self.patches.iter().map(of_patch).collect()
    }
}
