//! Occluders: walls between a place and the nodes around it. In go the triangles of walls, out come corners
//! without hidden nodes. Invariant: places on one side of a wall exchange no light with nodes on the other.

use super::grid::{Corners, Grid};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// A triangle of a wall, in world space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    pub(crate) corners: [DVec3; 3],
    /// Unit length; zero if it has no area.
    pub(crate) normal: DVec3,
}

impl Triangle {
    /// Height of a place above its plane.
    #[inline]
    pub(crate) fn height(&self, place: DVec3) -> f64 {
        (place - self.corners[0]).dot(self.normal)
    }
}

/// Triangles of walls, by cell.
pub(crate) struct Occluders {
    /// Triangles near each cell of eight nodes. Those of the cell after node N are from `starts[N]` to
    /// `starts[N + 1]`.
    about_cell: Vec<CellTriangle>,
    starts: Vec<u32>,
    /// Whether a wall is near one of the cells that meet at a node.
    are_near: Vec<bool>,
}

/// Triangle that may lie between the nodes of a cell, in cells from the lowest node.
#[derive(Clone, Copy)]
pub(crate) struct CellTriangle {
    corner: Vec3,
    sides: [Vec3; 2],
    normal: Vec3,
    /// Nodes clear of its plane on either side: one bit each.
    above: u8,
    below: u8,
}

/// A grid cut by walls.
#[derive(Clone, Copy)]
pub(crate) struct CutGrid<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) occluders: &'a Occluders,
}

impl CutGrid<'_> {
    /// Nodes around a place without those that walls hide from `seen_from`, a place among these nodes.
    pub(crate) fn corners(&self, place: DVec3, seen_from: DVec3) -> Corners {
        self.occluders.corners(self.grid, place, seen_from)
    }
}

/// Distance from a triangle's plane beyond which a place is clear of it, in cells.
pub(crate) const CLEAR: f32 = 1e-5;
/// Distance from their wall at which places on it are queried, in cells.
pub(crate) const OFF_WALL: f64 = 1e-3;

impl Occluders {
    /// Occluders from triangles, each with the lowest node of a cell that it is near.
    pub(crate) fn new(grid: &Grid, mut about_cell: Vec<(u32, CellTriangle)>) -> Self {
        // Sorted by cell; a stable sort keeps the order within each.
        about_cell.sort_by_key(|(node, _)| *node);
        let starts: Vec<u32> = (0..=grid.count() as u32)
            .map(|node| about_cell.partition_point(|(of, _)| *of < node) as u32)
            .collect();
        let about_cell = about_cell.into_iter().map(|(_, triangle)| triangle).collect();
        let are_near = are_near(grid, &starts);
        Self { about_cell, starts, are_near }
    }

    /// Whether there may be walls within a cell's distance of a node.
    pub(crate) fn are_near(&self, node: usize) -> bool {
        self.are_near[node]
    }

    /// Nodes around a place without those that walls hide from `seen_from`, a place among these nodes.
    #[inline]
    pub(crate) fn corners(&self, grid: &Grid, place: DVec3, seen_from: DVec3) -> Corners {
        let mut corners = grid.corners(place);
        if !self.about(corners.nodes[0]).is_empty() {
            self.hide_nodes(grid, &mut corners, seen_from);
        }
        corners
    }

    /// Whether a look-up may be moved from one place to another: within a cell, or where no walls are near.
    pub(crate) fn is_free_between(&self, grid: &Grid, from: DVec3, to: DVec3) -> bool {
        let cells = [from, to].map(|place| grid.corners(place).nodes[0]);
        cells[0] == cells[1] || cells.into_iter().all(|cell| self.about(cell).is_empty())
    }

    /// Nodes that represent a place: the one whose cell has it, unless a wall hides that node; otherwise the
    /// visible ones around it.
    #[inline]
    pub(crate) fn cell_of(&self, grid: &Grid, place: DVec3) -> Corners {
        let mut corners = grid.corners(place);
        let weight = |corner: usize| corners.weights[corner];
        let nearest =
            (1..8).fold(0, |best, corner| if weight(corner) > weight(best) { corner } else { best });
        let is_hidden = !self.about(corners.nodes[0]).is_empty()
            && self.hidden(grid, corners.nodes[0], place) >> nearest & 1 == 1;
        if is_hidden {
            self.hide_nodes(grid, &mut corners, place);
        } else {
            corners.weights = std::array::from_fn(|corner| f64::from(u8::from(corner == nearest)));
        }
        corners
    }

    /// Volume that each node represents by [`Occluders::cell_of`], in cells: 1 far from walls.
    pub(crate) fn shares(&self, grid: &Grid) -> Vec<f32> {
        /// Number of points of a lattice that is even along each axis: a plane across an axis has only its
        /// share of points.
        const POINTS: usize = 16;
        const GENERATOR: [usize; 3] = [1, 5, 7];
        let near: Vec<usize> = (0..grid.count()).filter(|node| self.are_near[*node]).collect();
        let of_points: Vec<[Corners; POINTS]> = near
            .par_iter()
            .map(|&node| {
                std::array::from_fn(|point| {
                    let along = |axis: usize| (GENERATOR[axis] * point % POINTS) as f64 + 0.5;
                    let place = DVec3::new(along(0), along(1), along(2)) / POINTS as f64 - 0.5;
                    self.cell_of(grid, grid.position(node) + grid.cell_m * place)
                })
            })
            .collect();
        let mut shares: Vec<f32> =
            self.are_near.iter().map(|is_near| f32::from(u8::from(!is_near))).collect();
        for corners in of_points.as_flattened() {
            for (node, weight) in corners.iter() {
                shares[node] += weight as f32 / POINTS as f32;
            }
        }
        shares
    }

    fn hide_nodes(&self, grid: &Grid, corners: &mut Corners, seen_from: DVec3) {
        let hidden = self.hidden(grid, corners.nodes[0], seen_from);
        if hidden == 0 {
            return;
        }
        let is_seen: [f64; 8] = std::array::from_fn(|corner| f64::from(!hidden >> corner & 1));
        let share: f64 = (0..8).map(|corner| is_seen[corner] * corners.weights[corner]).sum();
        corners.weights = if share > 1e-3 {
            std::array::from_fn(|corner| is_seen[corner] * corners.weights[corner] / share)
        } else {
            // Between walls closer than a cell: all visible nodes.
            let open: f64 = is_seen.iter().sum();
            is_seen.map(|is_seen| is_seen / open.max(1.0))
        };
    }

    /// Triangles that may lie between eight nodes, or between them and a place among them; `lowest` is the
    /// lowest node.
    fn about(&self, lowest: usize) -> &[CellTriangle] {
        &self.about_cell[self.starts[lowest] as usize..self.starts[lowest + 1] as usize]
    }

    /// Nodes of a cell that walls hide from a place among them, one bit each.
    fn hidden(&self, grid: &Grid, lowest: usize, from: DVec3) -> u8 {
        let from = in_cell(grid, lowest, from);
        let mut hidden = 0;
        for triangle in self.about(lowest) {
            let on_this_side = match triangle.height(from) {
                height if height > CLEAR => triangle.above,
                height if height < -CLEAR => triangle.below,
                _ => 0,
            };
            let mut left = !(on_this_side | hidden);
            while left != 0 {
                let corner = left.trailing_zeros() as usize;
                left &= left - 1;
                if triangle.is_crossed(from, corner_of(corner)) {
                    hidden |= 1 << corner;
                }
            }
        }
        hidden
    }

    /// Whether a wall of a cell stands between two places.
    pub(crate) fn hide(&self, grid: &Grid, lowest: usize, from: DVec3, to: DVec3) -> bool {
        let about = self.about(lowest);
        if about.is_empty() {
            return false;
        }
        let [from, to] = [from, to].map(|place| in_cell(grid, lowest, place));
        about.iter().any(|triangle| {
            triangle.height(from) * triangle.height(to) <= 0.0 && triangle.is_crossed(from, to)
        })
    }
}

/// A place in cells from a node.
fn in_cell(grid: &Grid, node: usize, place: DVec3) -> Vec3 {
    ((place - grid.position(node)) / grid.cell_m).as_vec3()
}

/// Offset of one of a cell's eight nodes from the lowest, in cells.
fn corner_of(corner: usize) -> Vec3 {
    Vec3::new((corner & 1) as f32, (corner >> 1 & 1) as f32, (corner >> 2) as f32)
}

fn are_near(grid: &Grid, starts: &[u32]) -> Vec<bool> {
    let mut are_near = vec![false; grid.count()];
    let [x, y, z] = grid.strides();
    for lowest in 0..grid.count() {
        if starts[lowest] < starts[lowest + 1] {
            for corner in 0..8 {
                are_near[lowest + x * (corner & 1) + y * (corner >> 1 & 1) + z * (corner >> 2)] = true;
            }
        }
    }
    are_near
}

impl CellTriangle {
    pub(crate) fn new(triangle: &Triangle, grid: &Grid, lowest: usize) -> Self {
        let [a, b, c] = triangle.corners.map(|corner| in_cell(grid, lowest, corner));
        let mut placed =
            Self { corner: a, sides: [b - a, c - a], normal: triangle.normal.as_vec3(), above: 0, below: 0 };
        for corner in 0..8 {
            let height = placed.height(corner_of(corner));
            placed.above |= u8::from(height > CLEAR) << corner;
            placed.below |= u8::from(height < -CLEAR) << corner;
        }
        placed
    }

    /// Whether a triangle's box touches the cube at `lowest`, and its plane cuts the cube.
    pub(crate) fn is_about(triangle: &Triangle, lowest: DVec3, side: f64) -> bool {
        let [a, b, c] = triangle.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let slack = 1e-6 * side;
        let overlaps = low.cmple(lowest + side + slack).all() && high.cmpge(lowest - slack).all();
        let middle = lowest + 0.5 * side;
        overlaps && triangle.height(middle).abs() <= 0.5 * side * triangle.normal.abs().element_sum() + slack
    }

    /// Height of a place above its plane.
    #[inline]
    fn height(&self, place: Vec3) -> f32 {
        (place - self.corner).dot(self.normal)
    }

    /// Whether a line segment crosses it: Möller & Trumbore's test in single precision, with slightly wider
    /// edges.
    #[inline]
    fn is_crossed(&self, from: Vec3, to: Vec3) -> bool {
        const SLACK: f32 = 1e-4;
        let ([ab, ac], way) = (self.sides, to - from);
        let across = way.cross(ac);
        let determinant = ab.dot(across);
        let start = from - self.corner;
        // Scaled by the determinant, to avoid division.
        let sign = 1.0_f32.copysign(determinant);
        let (size, u) = (determinant.abs(), sign * start.dot(across));
        let slack = SLACK * size;
        // Most triangles are missed here already.
        if !(-slack..=size + 3.0 * slack).contains(&u) || size == 0.0 {
            return false;
        }
        let along = start.cross(ab);
        let (v, t) = (sign * way.dot(along), sign * ac.dot(along));
        v >= -slack && u + v <= size + slack && t >= 0.0 && t < size
    }
}
