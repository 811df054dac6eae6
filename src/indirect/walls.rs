//! Walls of a snapshot: ground, trunks, rooms. In go triangles, out come the links between nodes that they
//! cut, and the patches that nodes see instead. Invariant: crossings are exact, so thin walls cut links, too.

use super::cut_patches::cut_patches;
use crate::accel::PrimitiveId;
use crate::canopy::surface_optics::optics_at;
use crate::canopy::surroundings::WallTriangle;
use crate::color::Rgb;
use crate::ordinates::grid::Grid;
use crate::ordinates::occluders::{CLEAR, CellTriangle};
use crate::ordinates::surface_optics::{MeanOptics, SurfaceOptics};
use crate::ordinates::walls::{CutNode, LINKS, Patch, Seen, Walls};
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::collections::HashMap;

const NO_WALL: u32 = u32::MAX;

/// Walls, with a triangle of each patch.
pub(super) struct SnapshotWalls {
    pub(super) walls: Walls,
    pub(super) primitives: Vec<PrimitiveId>,
}

/// Key of a patch: its cell, the main direction of its normal, its mesh.
type PatchKey = (usize, u8, u32);

impl SnapshotWalls {
    pub(super) fn new(grid: &Grid, snapshot: &Snapshot, triangles: &[WallTriangle]) -> Self {
        let mut building = Building::new(grid, snapshot);
        for triangle in triangles {
            building.add(triangle);
        }
        let Building { mut nodes, mut patches, mut primitives, means, about_cell, half_seen, .. } = building;
        for (patch, mean) in patches.iter_mut().zip(means) {
            patch.optics = mean.mean();
        }
        add_unseen((&mut patches, &mut primitives), &half_seen);
        cut_patches((grid, snapshot), &mut nodes, (&mut patches, &mut primitives));
        Self { walls: Walls::new(grid, nodes, patches, about_cell), primitives }
    }
}

/// Ranges of indices along each axis of nodes at the ends of cut links, with those just around the grid.
type Ends = [std::ops::RangeInclusive<i32>; 3];

/// Crossing of a triangle and a link, as the node at one of its ends sees it.
struct Crossing {
    node: usize,
    link: usize,
    /// Position on the link, as a share of its length.
    at: f64,
    /// Point in world space.
    point: DVec3,
    facing: DVec3,
}

struct Building<'a> {
    grid: &'a Grid,
    snapshot: &'a Snapshot<'a>,
    nodes: Vec<CutNode>,
    number_of: Vec<u32>,
    patches: Vec<Patch>,
    /// A triangle of each patch.
    primitives: Vec<PrimitiveId>,
    means: Vec<MeanOptics>,
    patch_of: HashMap<PatchKey, u32>,
    /// Patches with a triangle and a place of each where another wall hides the other side.
    half_seen: Vec<(u32, PrimitiveId, DVec3)>,
    /// Lowest nodes of cells, with triangles near them.
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
            primitives: Vec::new(),
            means: Vec::new(),
            patch_of: HashMap::new(),
            half_seen: Vec::new(),
            about_cell: Vec::new(),
        }
    }

    /// Cuts the links that a triangle crosses, and records the cells that it touches.
    fn add(&mut self, wall: &WallTriangle) {
        let (grid, triangle) = (self.grid, &wall.triangle);
        let [a, b, c] = triangle.corners;
        if triangle.normal == DVec3::ZERO {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let (first, last) = grid.bounds();
        let [is_before, is_past] = [first - low, high - last].map(|beyond| beyond.cmpgt(DVec3::ZERO));
        if low.cmpgt(last + grid.cell_m).any() || high.cmplt(first - grid.cell_m).any() {
            return;
        }
        let ((grid_low, _), (grid_high, _)) = (grid.place(low), grid.place(high));
        let reach = 1.75 * grid.cell_m;
        let range =
            |axis: usize| grid_low[axis].saturating_sub(1)..(grid_high[axis] + 2).min(grid.size[axis]);
        // Both ends of a crossed link are nodes of a cell that the triangle touches.
        let ends: Ends = [0, 1, 2].map(|axis| {
            let [before, past] = [is_before, is_past].map(|beyond| i32::from(beyond.test(axis)));
            grid_low[axis] as i32 - before..=grid_high[axis] as i32 + 1 + past
        });
        for z in range(2) {
            for y in range(1) {
                for x in range(0) {
                    let [_, row, layer] = grid.strides();
                    let node = x + row * y + layer * z;
                    let position = grid.position(node);
                    if triangle.height(position).abs() > reach {
                        continue;
                    }
                    self.cut_links(wall, [x, y, z], &ends);
                    let is_lowest = (0..3).all(|axis| [x, y, z][axis] + 1 < grid.size[axis]);
                    if is_lowest && CellTriangle::is_about(triangle, position, grid.cell_m) {
                        self.about_cell.push((node as u32, CellTriangle::new(triangle, grid, node)));
                    }
                }
            }
        }
    }

    /// Cuts links from a node to later neighbours, and to the cells around the grid.
    fn cut_links(&mut self, wall: &WallTriangle, cell: [usize; 3], ends: &Ends) {
        let (grid, triangle) = (self.grid, &wall.triangle);
        let normal = triangle.normal;
        let cell = cell.map(|place| place as i32);
        let are_ends = |cell: [i32; 3]| (0..3).all(|axis| ends[axis].contains(&cell[axis]));
        if !are_ends(cell) {
            return;
        }
        let [_, row, layer] = grid.strides().map(|stride| stride as i32);
        let node = (cell[0] + row * cell[1] + layer * cell[2]) as usize;
        let height = triangle.height(grid.position(node)) / grid.cell_m;
        let is_within = |cell: [i32; 3]| (0..3).all(|axis| (0..grid.size[axis] as i32).contains(&cell[axis]));
        for link in (0..LINKS).filter(|link| *link != LINKS / 2) {
            let step = [link % 3, link / 3 % 3, link / 9].map(|digit| digit as i32 - 1);
            let other = [0, 1, 2].map(|axis| cell[axis] + step[axis]);
            let has_node = is_within(other);
            if has_node && link < LINKS / 2 || !are_ends(other) {
                continue;
            }
            let on_the_way = DVec3::from_array(step.map(f64::from)).dot(normal);
            let (least, most) = (height.min(height + on_the_way), height.max(height + on_the_way));
            if least > CLEAR.into() || most < (-CLEAR).into() {
                continue;
            }
            let from = grid.position(node);
            let to = from + grid.cell_m * DVec3::from_array(step.map(f64::from));
            let Some(at) = crossing(&triangle.corners, from, to) else { continue };
            let facing = if (to - from).dot(normal) < 0.0 { normal } else { -normal };
            let point = from + at * (to - from);
            let seen = self.see(wall.primitive, &Crossing { node, link, at, point, facing });
            if !has_node {
                continue;
            }
            let node = (node as i32 + step[0] + row * step[1] + layer * step[2]) as usize;
            let there = Crossing { node, link: LINKS - 1 - link, at: 1.0 - at, point, facing: -facing };
            match [seen, self.see(wall.primitive, &there)] {
                [Some(here), Some(there)] => {
                    self.patches[here as usize].behind.get_or_insert(there);
                    self.patches[there as usize].behind.get_or_insert(here);
                }
                [Some(seen), None] | [None, Some(seen)] => self.half_seen.push((seen, wall.primitive, point)),
                [None, None] => {}
            }
        }
    }

    /// Patch at a crossing; `None` if another wall lies before it.
    fn see(&mut self, primitive: PrimitiveId, crossing: &Crossing) -> Option<u32> {
        let number = self.walled(crossing.node);
        if !self.nodes[number].sees(crossing.link, crossing.at) {
            return None;
        }
        let patch = self.patch(primitive, crossing);
        self.nodes[number].cut(crossing.link, Seen { at: crossing.at as f32, patch });
        Some(patch)
    }

    fn walled(&mut self, node: usize) -> usize {
        if self.number_of[node] == NO_WALL {
            self.number_of[node] = self.nodes.len() as u32;
            self.nodes.push(CutNode::open(node));
        }
        self.number_of[node] as usize
    }

    fn patch(&mut self, primitive: PrimitiveId, &Crossing { point, facing, .. }: &Crossing) -> u32 {
        let axis = (0..3).max_by(|a, b| facing[*a].abs().total_cmp(&facing[*b].abs())).expect("three");
        let face = 2 * axis as u8 + u8::from(facing[axis] > 0.0);
        // Off the wall, so that rounding does not decide on the cell.
        let cell = self.grid.nearest(point + 0.25 * self.grid.cell_m * facing);
        let key = (cell, face, primitive.instance);
        let next = self.patches.len() as u32;
        let (patches, primitives, means) = (&mut self.patches, &mut self.primitives, &mut self.means);
        let number = *self.patch_of.entry(key).or_insert_with(|| {
            patches.push(Patch {
                position: point,
                normal: facing,
                optics: SurfaceOptics::default(),
                seen_by: Vec::new(),
                behind: None,
            });
            primitives.push(primitive);
            means.push(MeanOptics::default());
            next
        });
        self.means[number as usize].add(1.0, &optics_at(self.snapshot, primitive, point, facing));
        number
    }
}

/// Adds the other sides of walls that transmit, close before another wall. No node sees them, but light of
/// lamps, and of what glows, falls on them.
fn add_unseen(
    (patches, primitives): (&mut Vec<Patch>, &mut Vec<PrimitiveId>),
    half_seen: &[(u32, PrimitiveId, DVec3)],
) {
    for &(seen, primitive, position) in half_seen {
        let Patch { normal, optics, behind, .. } = patches[seen as usize];
        if behind.is_none() && optics.transmittance != Rgb::ZERO {
            patches[seen as usize].behind = Some(patches.len() as u32);
            patches.push(Patch {
                position,
                normal: -normal,
                optics,
                seen_by: Vec::new(),
                behind: Some(seen),
            });
            primitives.push(primitive);
        }
    }
}

/// Intersection of a line segment with a triangle, as a share of its length (Möller & Trumbore 1997). Edges
/// count as inside.
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
