//! Walls between the nodes of a grid: ground, trunks, rooms. In go triangles, out come the links from node to
//! node that they cut, and the patches that are seen instead. Invariant: no light goes along a link that a
//! wall cuts, however thin it is.

use super::faces::Faces;
use super::grid::Grid;
use super::occluders::{CLEAR, CellTriangle, Occluders};
use super::scatters::{MeanScatters, Scatters, scatters};
use super::surroundings::WallTriangle;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::snapshot::Snapshot;
use glam::{DVec3, IVec3};
use std::collections::HashMap;
use std::f64::consts::PI;

/// Links of a node: its 26 neighbours and itself.
const LINKS: usize = 27;
const NO_PATCH: u32 = u32::MAX;
const NO_WALL: u32 = u32::MAX;

/// A step to a neighbour as the number of a link.
pub(super) fn link_of(step: [i32; 3]) -> usize {
    (step[0] + 1 + 3 * (step[1] + 1) + 9 * (step[2] + 1)) as usize
}

/// The other way round.
pub(super) fn step_of(link: usize) -> IVec3 {
    IVec3::new(link as i32 % 3 - 1, link as i32 / 3 % 3 - 1, link as i32 / 9 - 1)
}

/// A node some of whose neighbours are behind walls.
pub(super) struct WalledNode {
    pub(super) node: usize,
    /// What is seen first along each link.
    seen: [Seen; LINKS],
}

#[derive(Clone, Copy)]
pub(super) struct Seen {
    /// As a share of the link.
    pub(super) at: f32,
    pub(super) patch: u32,
}

impl WalledNode {
    /// The patch that is seen along a link, if a wall cuts it.
    pub(super) fn wall_at(&self, link: usize) -> Option<usize> {
        let patch = self.seen[link].patch;
        (patch != NO_PATCH).then_some(patch as usize)
    }

    /// By link.
    pub(super) fn seen_along(&mut self) -> impl Iterator<Item = (usize, &mut Seen)> {
        self.seen.iter_mut().enumerate().filter(|(_, seen)| seen.patch != NO_PATCH)
    }
}

/// What nodes see of a wall about one cell, on one side.
pub(super) struct Patch {
    /// In world space, where it was seen first.
    pub(super) position: DVec3,
    /// Towards those who see it.
    pub(super) normal: DVec3,
    /// On the mean of where it is seen, as walls have textures.
    pub(super) scatters: Scatters,
    /// A triangle of it.
    pub(super) primitive: PrimitiveId,
    /// Nodes that see it, and how much each counts.
    pub(super) seen_by: Vec<(u32, f32)>,
    /// The patch of the same place on its other side, from where light comes through.
    pub(super) behind: Option<u32>,
}

/// Which patch a place belongs to: the cell, the direction that it faces most, the mesh.
type PatchKey = (usize, u8, u32);

/// All walls about a grid's nodes.
pub(super) struct Walls {
    nodes: Vec<WalledNode>,
    pub(super) patches: Vec<Patch>,
    pub(super) faces: Faces,
    pub(super) occluders: Occluders,
}

impl Walls {
    pub(super) fn new(grid: &Grid, snapshot: &Snapshot, triangles: &[WallTriangle]) -> Self {
        let mut building = Building::new(grid, snapshot);
        for triangle in triangles {
            building.add(triangle);
        }
        let Building { nodes, mut patches, means, about_cell, .. } = building;
        for (patch, mean) in patches.iter_mut().zip(means) {
            patch.scatters = mean.mean();
        }
        let normal_of = |seen: &Seen| (seen.patch != NO_PATCH).then(|| patches[seen.patch as usize].normal);
        let seen_by = |walled: &WalledNode| (walled.node, walled.seen.iter().filter_map(normal_of).collect());
        let faces = Faces::new(grid.count(), nodes.iter().map(seen_by));
        Self { nodes, patches, faces, occluders: Occluders::new(grid, about_cell) }
    }

    /// Nodes that see walls, and what they see.
    pub(super) fn parts_mut(&mut self) -> (&mut [WalledNode], &mut Vec<Patch>) {
        (&mut self.nodes, &mut self.patches)
    }

    /// Those some of whose neighbours are behind walls.
    pub(super) fn nodes(&self) -> &[WalledNode] {
        &self.nodes
    }
}

/// Along each axis, which nodes may be ends of links that are cut.
type Ends = [std::ops::RangeInclusive<i32>; 3];

struct Building<'a> {
    grid: &'a Grid,
    snapshot: &'a Snapshot<'a>,
    nodes: Vec<WalledNode>,
    number_of: Vec<u32>,
    patches: Vec<Patch>,
    /// What each of them scatters.
    means: Vec<MeanScatters>,
    patch_of: HashMap<PatchKey, u32>,
    /// Cells, by their lowest node, and triangles about them.
    about_cell: Vec<(u32, CellTriangle)>,
}

impl<'a> Building<'a> {
    fn new(grid: &'a Grid, snapshot: &'a Snapshot<'a>) -> Self {
        Self {
            grid,
            snapshot,
            nodes: Vec::new(),
            number_of: vec![NO_WALL; grid.count()],
            patches: Vec::new(),
            means: Vec::new(),
            patch_of: HashMap::new(),
            about_cell: Vec::new(),
        }
    }

    /// Cuts the links that a triangle crosses, and notes the cells that it touches.
    fn add(&mut self, triangle: &WallTriangle) {
        let grid = self.grid;
        let [a, b, c] = triangle.corners;
        if triangle.normal == DVec3::ZERO {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let (first, last) = grid.volume();
        if low.cmpgt(last).any() || high.cmplt(first).any() {
            return;
        }
        let ((grid_low, _), (grid_high, _)) = (grid.place(low), grid.place(high));
        let reach = 1.75 * grid.cell_m;
        let range =
            |axis: usize| grid_low[axis].saturating_sub(1)..(grid_high[axis] + 2).min(grid.size[axis]);
        // Both ends of a link that it crosses are nodes of a cell that it touches.
        let ends: Ends = [0, 1, 2].map(|axis| grid_low[axis] as i32..=grid_high[axis] as i32 + 1);
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let [_, row, layer] = grid.strides();
                    let node = x + row * y + layer * z;
                    let position = grid.position(node);
                    if triangle.height(position).abs() > reach {
                        continue;
                    }
                    self.cut_links(triangle, [x, y, z], &ends);
                    let is_lowest = (0..3).all(|axis| [x, y, z][axis] + 1 < grid.size[axis]);
                    if is_lowest && CellTriangle::is_about(triangle, position, grid.cell_m) {
                        self.about_cell.push((node as u32, CellTriangle::new(triangle, grid, node)));
                    }
                }
            }
        }
    }

    /// Of links that lead from a node to neighbours that come after it.
    fn cut_links(&mut self, triangle: &WallTriangle, cell: [usize; 3], ends: &Ends) {
        let (grid, normal) = (self.grid, triangle.normal);
        let cell = cell.map(|place| place as i32);
        let are_ends = |cell: [i32; 3]| (0..3).all(|axis| ends[axis].contains(&cell[axis]));
        if !are_ends(cell) {
            return;
        }
        let [_, row, layer] = grid.strides().map(|stride| stride as i32);
        let node = (cell[0] + row * cell[1] + layer * cell[2]) as usize;
        let height = triangle.height(grid.position(node)) / grid.cell_m;
        for link in LINKS / 2 + 1..LINKS {
            let step = [link % 3, link / 3 % 3, link / 9].map(|digit| digit as i32 - 1);
            let other = [0, 1, 2].map(|axis| cell[axis] + step[axis]);
            if !are_ends(other) {
                continue;
            }
            let neighbour = (node as i32 + step[0] + row * step[1] + layer * step[2]) as usize;
            let on_the_way = DVec3::from_array(step.map(f64::from)).dot(normal);
            let (least, most) = (height.min(height + on_the_way), height.max(height + on_the_way));
            if least > CLEAR.into() || most < (-CLEAR).into() {
                continue;
            }
            let (from, to) = (grid.position(node), grid.position(neighbour));
            let Some(at) = crossing(&triangle.corners, from, to) else { continue };
            let facing = if (to - from).dot(normal) < 0.0 { normal } else { -normal };
            let point = from + at * (to - from);
            let here = self.see(triangle, (node, link), at, (point, facing));
            let there = self.see(triangle, (neighbour, LINKS - 1 - link), 1.0 - at, (point, -facing));
            if let (Some(here), Some(there)) = (here, there) {
                self.patches[here as usize].behind.get_or_insert(there);
                self.patches[there as usize].behind.get_or_insert(here);
            }
        }
    }

    /// The patch that is seen, unless another is before it.
    fn see(
        &mut self,
        triangle: &WallTriangle,
        (node, link): (usize, usize),
        at: f64,
        (point, facing): (DVec3, DVec3),
    ) -> Option<u32> {
        let number = self.walled(node);
        if f64::from(self.nodes[number].seen[link].at) <= at {
            return None;
        }
        let patch = self.patch(triangle, point, facing);
        self.nodes[number].seen[link] = Seen { at: at as f32, patch };
        Some(patch)
    }

    fn walled(&mut self, node: usize) -> usize {
        if self.number_of[node] == NO_WALL {
            self.number_of[node] = self.nodes.len() as u32;
            self.nodes.push(WalledNode { node, seen: [Seen { at: 1.0, patch: NO_PATCH }; LINKS] });
        }
        self.number_of[node] as usize
    }

    fn patch(&mut self, triangle: &WallTriangle, point: DVec3, facing: DVec3) -> u32 {
        let axis = (0..3).max_by(|a, b| facing[*a].abs().total_cmp(&facing[*b].abs())).expect("three");
        let face = 2 * axis as u8 + u8::from(facing[axis] > 0.0);
        // Off the wall, so that rounding does not decide which cell it is.
        let cell = self.grid.nearest(point + 0.25 * self.grid.cell_m * facing);
        let key = (cell, face, triangle.primitive.instance);
        let next = self.patches.len() as u32;
        let (patches, means) = (&mut self.patches, &mut self.means);
        let number = *self.patch_of.entry(key).or_insert_with(|| {
            patches.push(Patch {
                position: point,
                normal: facing,
                scatters: Scatters::default(),
                primitive: triangle.primitive,
                seen_by: Vec::new(),
                behind: None,
            });
            means.push(MeanScatters::default());
            next
        });
        self.means[number as usize].add(1.0, &scatters(self.snapshot, triangle.primitive, point, facing));
        number
    }
}

impl Walls {
    /// Tells each patch which nodes see it.
    pub(super) fn introduce(mut self) -> Self {
        for walled in &self.nodes {
            for seen in walled.seen.iter().filter(|seen| seen.patch != NO_PATCH) {
                self.patches[seen.patch as usize].seen_by.push((walled.node as u32, 1.0 - 0.9 * seen.at));
            }
        }
        self
    }

    /// Whether some stand at an angle to others, and so in each other's light.
    pub(super) fn are_at_angles(&self) -> bool {
        /// Of all patches.
        const FEW: f64 = 0.05;
        let mut along = [0; 3];
        for patch in &self.patches {
            let normal = patch.normal.abs();
            along[(0..3).max_by(|a, b| normal[*a].total_cmp(&normal[*b])).expect("three")] += 1;
        }
        let most = along.into_iter().max().unwrap_or(0);
        (self.patches.len() - most) as f64 > FEW * self.patches.len() as f64
    }

    /// What each patch scatters of the irradiance on all of them, as radiance: of its own, and what comes
    /// through from behind.
    pub(super) fn scattered(&self, irradiances: &[Rgb]) -> Vec<Rgb> {
        let of_patch = |(patch, &irradiance): (&Patch, &Rgb)| {
            let through = patch.behind.map_or(Rgb::ZERO, |behind| {
                self.patches[behind as usize].scatters.transmittance * irradiances[behind as usize]
            });
            (patch.scatters.reflectance * irradiance + through) / PI
        };
        self.patches.iter().zip(irradiances).map(of_patch).collect()
    }

    /// The irradiance on each patch by light at the nodes that see it: `irradiance` answers
    /// for a node and a normal.
    pub(super) fn irradiances(&self, irradiance: impl Fn(usize, DVec3) -> Rgb) -> Vec<Rgb> {
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

/// Where a way from one place to another crosses a triangle, as a share of the way (Möller & Trumbore 1997).
/// Edges count as inside.
fn crossing([a, b, c]: &[DVec3; 3], from: DVec3, to: DVec3) -> Option<f64> {
    const SLACK: f64 = 1e-9;
    let (ab, ac, way) = (*b - *a, *c - *a, to - from);
    let across = way.cross(ac);
    let determinant = ab.dot(across);
    if determinant == 0.0 {
        return None;
    }
    let start = from - *a;
    let u = start.dot(across) / determinant;
    let along = start.cross(ab);
    let v = way.dot(along) / determinant;
    if u < -SLACK || v < -SLACK || u + v > 1.0 + SLACK {
        return None;
    }
    let t = ac.dot(along) / determinant;
    (0.0..1.0).contains(&t).then_some(t)
}
