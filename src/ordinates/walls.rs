//! Walls between the nodes of a grid: ground, trunks, rooms. In go the links from node to node that they cut,
//! and the patches that are seen instead, out comes what they reflect. Invariant: no light goes along a link
//! that a wall cuts, however thin it is.

use super::faces::Faces;
use super::grid::Grid;
use super::occluders::{CellTriangle, Occluders};
use super::surface_optics::SurfaceOptics;
use crate::color::Rgb;
use glam::{DVec3, IVec3};
use std::f64::consts::PI;

/// Links of a node: its 26 neighbours and itself.
pub(crate) const LINKS: usize = 27;
const NO_PATCH: u32 = u32::MAX;

/// A step to a neighbour as the number of a link.
pub(crate) fn link_of(step: [i32; 3]) -> usize {
    (step[0] + 1 + 3 * (step[1] + 1) + 9 * (step[2] + 1)) as usize
}

/// The other way round.
pub(crate) fn step_of(link: usize) -> IVec3 {
    IVec3::new(link as i32 % 3 - 1, link as i32 / 3 % 3 - 1, link as i32 / 9 - 1)
}

/// A node some of whose neighbours are behind walls.
pub(crate) struct CutNode {
    pub(crate) node: usize,
    /// Patch that is seen first along each link.
    seen: [Seen; LINKS],
}

/// A patch as a node sees it.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    /// Place on the link, as a share of it.
    pub(crate) at: f32,
    pub(crate) patch: u32,
}

impl CutNode {
    /// A node all links of which are open.
    pub(crate) fn open(node: usize) -> Self {
        Self { node, seen: [Seen { at: 1.0, patch: NO_PATCH }; LINKS] }
    }

    /// The patch that is seen along a link, if a wall cuts it.
    pub(crate) fn wall_at(&self, link: usize) -> Option<usize> {
        let patch = self.seen[link].patch;
        (patch != NO_PATCH).then_some(patch as usize)
    }

    /// Room about the node along an axis, in cells: on each side to the wall that cuts its link, or half a
    /// cell.
    pub(crate) fn room(&self, axis: usize) -> f32 {
        /// Between walls closer than a cell as much light is carried as there is room for.
        const LEAST: f32 = 0.25;
        let to_side = |step: i32| {
            let mut steps = [0; 3];
            steps[axis] = step;
            let link = link_of(steps);
            if self.wall_at(link).is_some() { self.seen[link].at } else { 0.5 }
        };
        (to_side(-1) + to_side(1)).max(LEAST)
    }

    /// Whether what lies at a share of a link is seen: nothing that cuts it lies before.
    pub(crate) fn sees(&self, link: usize, at: f64) -> bool {
        f64::from(self.seen[link].at) > at
    }

    /// Cuts a link.
    pub(crate) fn cut(&mut self, link: usize, seen: Seen) {
        self.seen[link] = seen;
    }

    /// Links that are cut.
    pub(crate) fn cut_links(&self) -> impl Iterator<Item = &Seen> {
        self.seen.iter().filter(|seen| seen.patch != NO_PATCH)
    }

    /// Links that are cut, with their numbers.
    pub(crate) fn cut_links_mut(&mut self) -> impl Iterator<Item = (usize, &mut Seen)> {
        self.seen.iter_mut().enumerate().filter(|(_, seen)| seen.patch != NO_PATCH)
    }
}

/// Part of a wall that nodes about one cell see, on one side.
pub(crate) struct Patch {
    /// Position in world space, where it was seen first.
    pub(crate) position: DVec3,
    /// Towards those who see it.
    pub(crate) normal: DVec3,
    /// Optics on the mean of where it is seen, as walls have textures.
    pub(crate) optics: SurfaceOptics,
    /// Nodes that see it, and how much each counts.
    pub(crate) seen_by: Vec<(u32, f32)>,
    /// The patch of the same place on its other side, from where light comes through.
    pub(crate) behind: Option<u32>,
}

/// All walls about a grid's nodes.
pub(crate) struct Walls {
    nodes: Vec<CutNode>,
    pub(crate) patches: Vec<Patch>,
    pub(crate) faces: Faces,
    pub(crate) occluders: Occluders,
}

impl Walls {
    /// Walls of nodes and of the patches that these see; `about_cell` has triangles with the lowest nodes of
    /// the cells that they are about.
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

    /// Nodes some of whose neighbours are behind walls.
    pub(crate) fn nodes(&self) -> &[CutNode] {
        &self.nodes
    }

    /// Whether some stand at an angle to others, and so in each other's light.
    pub(crate) fn are_at_angles(&self) -> bool {
        /// Share of all patches.
        const FEW: f64 = 0.05;
        let mut along = [0; 3];
        for patch in &self.patches {
            let normal = patch.normal.abs();
            along[(0..3).max_by(|a, b| normal[*a].total_cmp(&normal[*b])).expect("three")] += 1;
        }
        let most = along.into_iter().max().unwrap_or(0);
        (self.patches.len() - most) as f64 > FEW * self.patches.len() as f64
    }

    /// Radiance that each patch scatters of the irradiance on all of them: of its own, and what comes
    /// through from behind.
    pub(crate) fn scattered(&self, irradiances: &[Rgb]) -> Vec<Rgb> {
        let of_patch = |(patch, &irradiance): (&Patch, &Rgb)| {
            let through = patch.behind.map_or(Rgb::ZERO, |behind| {
                self.patches[behind as usize].optics.transmittance * irradiances[behind as usize]
            });
            (patch.optics.reflectance * irradiance + through) / PI
        };
        self.patches.iter().zip(irradiances).map(of_patch).collect()
    }

    /// The irradiance on each patch by light at the nodes that see it: `irradiance` answers
    /// for a node and a normal.
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
