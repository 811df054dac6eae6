//! Grid in world space for light transport. In go bounds in the world, out come nodes and their weights.
//! Invariant: cells lie at whole multiples of their side from a fixed place of the world, for any motion and
//! any camera. So the solution does not flicker as they move.

use crate::math::Ray;
use glam::{BVec3, DVec3, I64Vec3};

/// Offset from the world's origin to a corner of a cell, in cells. Walls often stand at round coordinates,
/// and a wall at nodes or half way between them would be on both sides of a link.
const PHASE: DVec3 = DVec3::new(0.137, 0.789, 0.173);

/// Nodes at equal distances along the world's axes. Each is the centre of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grid {
    /// The first cell, counted from the world's origin.
    first: I64Vec3,
    /// Nodes along each axis.
    pub(crate) size: [usize; 3],
    /// Distance between two nodes, metres.
    pub(crate) cell_m: f64,
    /// Low and high sides with a larger grid beyond, where the solution blends into that grid's.
    open_sides: [BVec3; 2],
}

/// Eight nodes around a place with their weights: trilinear interpolation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corners {
    pub(crate) nodes: [usize; 8],
    pub(crate) weights: [f64; 8],
}

impl Corners {
    /// Nodes with their weights.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        self.nodes.into_iter().zip(self.weights)
    }

    /// Nodes of nonzero weight.
    pub(crate) fn seen(&self) -> impl Iterator<Item = (usize, f64)> {
        self.iter().filter(|(_, weight)| *weight > 0.0)
    }

    /// Corners restricted to some nodes, renormalised; `None` if these have hardly any weight.
    pub(crate) fn only(&self, is_wanted: impl Fn(usize) -> bool) -> Option<Self> {
        const LEAST: f64 = 1e-3;
        let wanted = |corner: usize| if is_wanted(self.nodes[corner]) { self.weights[corner] } else { 0.0 };
        let weights: [f64; 8] = std::array::from_fn(wanted);
        let all: f64 = weights.iter().sum();
        (all > LEAST).then(|| Self { weights: weights.map(|weight| weight / all), ..*self })
    }
}

/// The part of a ray that lies in the cell of a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellInterval {
    pub(crate) node: usize,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// Weights of a node and of its two neighbours.
const EVENLY: [f32; 3] = [0.25, 0.5, 0.25];
/// Shares of a node's trilinear weight in its own cell, and in each cell beside it: integrals of the hat
/// function.
const BY_HAT: [f32; 3] = [0.125, 0.75, 0.125];

impl Grid {
    /// Grid that covers a box of world space, with a cell to spare on each side.
    pub(crate) fn covering(low: DVec3, high: DVec3, cell_m: f64) -> Self {
        let first = (low / cell_m - PHASE).floor().as_i64vec3() - 1;
        let end = (high / cell_m - PHASE).ceil().as_i64vec3() + 1;
        let size = (end - first).to_array().map(|count| count as usize);
        Self { first, size, cell_m, open_sides: [BVec3::TRUE; 2] }
    }

    /// The grid with nothing beyond some of its low and high sides.
    pub(crate) fn closed(self, [low, high]: [BVec3; 2]) -> Self {
        let [open_low, open_high] = self.open_sides;
        Self { open_sides: [open_low & !low, open_high & !high], ..self }
    }

    /// The grid with two more cells on sides with a larger grid beyond: the contents of its bounds end before
    /// the solution blends into that grid's.
    pub(crate) fn widened(self) -> Self {
        let cells = |open: BVec3| 2 * DVec3::select(open, DVec3::ONE, DVec3::ZERO).as_i64vec3();
        let [low, high] = self.open_sides.map(cells);
        let size = I64Vec3::from_array(self.size.map(|count| count as i64)) + low + high;
        Self { first: self.first - low, size: size.to_array().map(|count| count as usize), ..self }
    }

    /// Whether a place lies beyond a side of the grid with nothing beyond.
    pub(crate) fn is_past_its_end(&self, world: DVec3) -> bool {
        let ((low, high), [open_low, open_high]) = (self.volume(), self.open_sides);
        (world.cmplt(low) & !open_low).any() || (world.cmpgt(high) & !open_high).any()
    }

    pub(crate) fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// Strides in memory between neighbours along each axis.
    pub(crate) fn strides(&self) -> [usize; 3] {
        [1, self.size[0], self.size[0] * self.size[1]]
    }

    /// Volume of a cell, m^3.
    pub(crate) fn cell_volume(&self) -> f64 {
        self.cell_m.powi(3)
    }

    /// Cell of a node, by its indices along each axis.
    pub(crate) fn cell_of(&self, node: usize) -> [usize; 3] {
        let [_, row, layer] = self.strides();
        [node % row, node / row % self.size[1], node / layer]
    }

    /// Position of a node, in world space.
    pub(crate) fn position(&self, node: usize) -> DVec3 {
        let cell = self.cell_of(node).map(|index| index as i64);
        ((self.first + I64Vec3::from_array(cell)).as_dvec3() + 0.5 + PHASE) * self.cell_m
    }

    /// The least and the greatest place between nodes, in world space.
    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        (self.position(0), self.position(self.count() - 1))
    }

    /// Bounds of all cells, from half a cell before the first node to half a cell past the last, in world
    /// space.
    pub(crate) fn volume(&self) -> (DVec3, DVec3) {
        let (low, high) = self.bounds();
        (low - 0.5 * self.cell_m, high + 0.5 * self.cell_m)
    }

    /// Whether a place of world space lies in one of its cells.
    pub(crate) fn holds(&self, world: DVec3) -> bool {
        let (low, high) = self.volume();
        world.cmpge(low).all() && world.cmple(high).all()
    }

    /// Weight of this grid at a place within a larger one: 0 from the outermost nodes of open sides outwards,
    /// 1 from two cells inside.
    pub(crate) fn share(&self, world: DVec3) -> f64 {
        const CELLS: f64 = 2.0;
        let ((low, high), [open_low, open_high]) = (self.bounds(), self.open_sides);
        let within = |open: BVec3, inside: DVec3| DVec3::select(open, inside, DVec3::INFINITY);
        let inside = within(open_low, world - low).min(within(open_high, high - world));
        (inside.min_element() / (CELLS * self.cell_m)).clamp(0.0, 1.0)
    }

    /// Indices of the lowest of the eight nodes around a place, and the place's offset from it, in cells.
    /// Outside of the grid the nearest place inside is used.
    pub(crate) fn place(&self, world: DVec3) -> ([usize; 3], DVec3) {
        let along = world / self.cell_m - 0.5 - PHASE - self.first.as_dvec3();
        let mut lowest = [0; 3];
        let mut beyond = DVec3::ZERO;
        for axis in 0..3 {
            let last = self.size[axis] - 1;
            let inside = along[axis].clamp(0.0, last as f64);
            lowest[axis] = (inside as usize).min(last - 1);
            beyond[axis] = inside - lowest[axis] as f64;
        }
        (lowest, beyond)
    }

    /// The node whose cell has a place; outside of the grid, the nearest.
    pub(crate) fn nearest(&self, world: DVec3) -> usize {
        let (lowest, beyond) = self.place(world);
        let [x, y, z] = [0, 1, 2].map(|axis| lowest[axis] + usize::from(beyond[axis] >= 0.5));
        let [_, row, layer] = self.strides();
        x + row * y + layer * z
    }

    /// The node whose cell has a place, and the indices of one of so many pieces along each side.
    pub(crate) fn piece(&self, world: DVec3, pieces: usize) -> (usize, [usize; 3]) {
        let node = self.nearest(world);
        let within = (world - self.position(node)) / self.cell_m + 0.5;
        let piece = |place: f64| ((place * pieces as f64).max(0.0) as usize).min(pieces - 1);
        (node, within.to_array().map(piece))
    }

    /// Mean over a node and its neighbours, nearer ones with more weight; values outside are 0.
    pub(crate) fn mean_about<const N: usize>(&self, node: usize, of: &[[f32; N]]) -> [f32; N] {
        self.mean_over(node, [EVENLY; 3], of)
    }

    /// Mean over the cells across an axis with the weights of trilinear interpolation.
    pub(crate) fn mean_across<const N: usize>(&self, axis: usize, node: usize, of: &[[f32; N]]) -> [f32; N] {
        let mut shares = [BY_HAT; 3];
        shares[axis] = [0.0, 1.0, 0.0];
        self.mean_over(node, shares, of)
    }

    /// Mean over a node and its neighbours, with weights along each axis: before, at and after the node.
    fn mean_over<const N: usize>(&self, node: usize, shares: [[f32; 3]; 3], of: &[[f32; N]]) -> [f32; N] {
        let cell = self.cell_of(node);
        let range = |axis: usize| {
            let (low, high) =
                (usize::from(cell[axis] == 0), 3 - usize::from(cell[axis] + 1 == self.size[axis]));
            (low..high).filter(move |place| shares[axis][*place] > 0.0)
        };
        let [_, row, layer] = self.strides();
        let mut mean = [0.0; N];
        for (z, y) in range(2).flat_map(|z| range(1).map(move |y| (z, y))) {
            for x in range(0) {
                let share = shares[0][x] * shares[1][y] * shares[2][z];
                let other = node + x + row * y + layer * z - (1 + row + layer);
                mean.iter_mut().zip(&of[other]).for_each(|(sum, value)| *sum += share * value);
            }
        }
        mean
    }

    /// Cells along a part of a ray in world space, in order; none unless all of it lies within the grid
    /// (Amanatides & Woo 1987, "A fast voxel traversal algorithm for ray tracing").
    pub(crate) fn intervals(&self, ray: &Ray, start: f64, end: f64) -> impl Iterator<Item = CellInterval> {
        let strides = self.strides();
        let origin = ray.origin / self.cell_m - PHASE - self.first.as_dvec3();
        let step_m = self.cell_m / ray.direction.abs();
        let begin = origin + start / self.cell_m * ray.direction;
        let mut cell = [0; 3];
        let mut next = [f64::INFINITY; 3];
        for axis in 0..3 {
            cell[axis] = begin[axis].clamp(0.0, self.size[axis] as f64 - 0.5) as usize;
            if ray.direction[axis] != 0.0 {
                let border = cell[axis] + usize::from(ray.direction[axis] > 0.0);
                next[axis] = (border as f64 - origin[axis]) * self.cell_m / ray.direction[axis];
            }
        }
        let (mut from, forwards, size) = (start, ray.direction.cmpgt(DVec3::ZERO), self.size);
        std::iter::from_fn(move || {
            if from >= end {
                return None;
            }
            let axis = if next[0] <= next[1].min(next[2]) { 0 } else { 1 + usize::from(next[2] < next[1]) };
            let node = (0..3).map(|axis| cell[axis] * strides[axis]).sum();
            let interval = CellInterval { node, from, to: next[axis].clamp(from, end) };
            from = next[axis].max(from);
            next[axis] += step_m[axis];
            match forwards.test(axis) {
                true if cell[axis] + 1 < size[axis] => cell[axis] += 1,
                false if cell[axis] > 0 => cell[axis] -= 1,
                // Rounding: nothing lies beyond the last cell.
                _ => from = end,
            }
            Some(interval)
        })
    }

    /// Corners around a place in world space; outside of the grid, around the nearest place inside.
    pub(crate) fn corners(&self, world: DVec3) -> Corners {
        let (lowest, beyond) = self.place(world);
        let [_, row, layer] = self.strides();
        let base = lowest[0] + row * lowest[1] + layer * lowest[2];
        let mut corners = Corners { nodes: [0; 8], weights: [0.0; 8] };
        for corner in 0..8 {
            let is_far = [corner & 1, corner >> 1 & 1, corner >> 2];
            corners.nodes[corner] = base + is_far[0] + row * is_far[1] + layer * is_far[2];
            corners.weights[corner] = (0..3)
                .map(|axis| if is_far[axis] == 1 { beyond[axis] } else { 1.0 - beyond[axis] })
                .product();
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_keeps_still_while_its_bounds_grow() {
        let small = Grid::covering(DVec3::splat(-1.0), DVec3::splat(1.0), 0.5);
        let large = Grid::covering(DVec3::splat(-1.3), DVec3::splat(2.0), 0.5);
        let place = DVec3::new(0.2, -0.7, 0.93);
        let about = |grid: &Grid| {
            let corners = grid.corners(place);
            (corners.nodes.map(|node| grid.position(node)), corners.weights)
        };
        assert_eq!(about(&small), about(&large));
    }

    #[test]
    fn a_ray_is_shared_out_among_the_cells_that_it_crosses() {
        let grid = Grid::covering(DVec3::ZERO, DVec3::new(3.0, 2.0, 1.0), 0.3);
        for direction in [DVec3::new(0.3, 0.8, -0.5).normalize(), DVec3::X, -DVec3::Z] {
            let ray = Ray { origin: DVec3::new(0.7, 0.2, 0.9), direction };
            let intervals: Vec<CellInterval> = grid.intervals(&ray, 0.1, 0.8).collect();
            let mut at = 0.1;
            for CellInterval { node, from, to } in intervals {
                assert!((from - at).abs() < 1e-12 && to >= from, "{from} {at} {to}");
                let away = (ray.at(0.5 * (from + to)) - grid.position(node)).abs();
                assert!(away.max_element() <= 0.15 + 1e-9, "{away}");
                at = to;
            }
            assert!((at - 0.8).abs() < 1e-12, "{at}");
        }
    }

    #[test]
    fn a_grid_goes_over_into_others_at_open_sides_alone() {
        let open = Grid::covering(DVec3::ZERO, DVec3::splat(8.0), 0.5);
        let on_ground = open.closed([BVec3::new(false, true, false), BVec3::FALSE]);
        let (ground, side) = (DVec3::new(4.0, 0.0, 4.0), DVec3::new(0.0, 4.0, 4.0));
        assert!(open.share(ground) < 1.0 && open.share(side) < 1.0);
        assert_eq!((on_ground.share(ground), on_ground.share(side)), (1.0, open.share(side)));
        let wide = on_ground.widened();
        assert_eq!((wide.share(ground), wide.share(side)), (1.0, 1.0));
        let [below, beside] = [DVec3::NEG_Y, DVec3::NEG_X].map(|to| ground + 2.0 * to);
        assert_eq!([below, beside, side].map(|place| on_ground.is_past_its_end(place)), [true, false, false]);
    }

    #[test]
    fn weights_interpolate() {
        let grid = Grid::covering(DVec3::ZERO, DVec3::new(3.0, 2.0, 1.0), 0.3);
        for place in [DVec3::new(0.11, 1.7, 0.5), DVec3::new(3.0, 0.0, 1.0)] {
            let Corners { nodes, weights } = grid.corners(place);
            let mean: DVec3 = (0..8).map(|corner| weights[corner] * grid.position(nodes[corner])).sum();
            assert!((mean - place).length() < 1e-12, "{mean} {place}");
        }
        let outside = grid.corners(DVec3::splat(-99.0));
        assert_eq!((outside.nodes[0], outside.weights[0]), (0, 1.0));
    }
}
