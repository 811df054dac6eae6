//! Ground where leaves come to rest: a level, and the upper side of meshes. In goes a place, out come height
//! and normal. Invariant: every place has one height.

use glam::{DVec2, DVec3};

/// Mean number of triangles in a cell of the grid.
const TRIANGLES_PER_CELL: usize = 2;
/// Maximum cells along a side of the grid.
const MOST_CELLS: usize = 1024;
/// Cells along a side of a block with a known maximum height.
const BLOCK: usize = 8;

/// Heights over the x-z plane.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    level_m: f64,
    /// Maximum height.
    pub(super) highest_m: f64,
    own: Meshes,
    /// Meshes of other grounds, used outside its own.
    others: Meshes,
}

/// Upper side of triangles.
#[derive(Clone, Debug)]
struct Meshes {
    triangles: Vec<[DVec3; 3]>,
    /// The smallest corner of the grid, and the size of a cell.
    corner: DVec2,
    cell: DVec2,
    side: usize,
    /// Triangles over each cell, row by row along x.
    cells: Vec<Vec<u32>>,
    /// Maximum height of each block.
    highest_m: Vec<f64>,
}

impl Ground {
    /// Ground of its own triangles, outside them of others, and level elsewhere.
    pub(crate) fn new(level_m: f64, own: Vec<[DVec3; 3]>, others: Vec<[DVec3; 3]>) -> Self {
        let points = own.iter().chain(&others).flatten();
        let highest_m = points.map(|point| point.y).fold(level_m, f64::max);
        Self { level_m, highest_m, own: Meshes::new(own), others: Meshes::new(others) }
    }

    /// Maximum height in a box of the x-z plane.
    pub(crate) fn highest_within(&self, low: DVec2, high: DVec2) -> f64 {
        let of = |meshes: &Meshes| meshes.highest_within(low, high);
        self.level_m.max(of(&self.own)).max(of(&self.others))
    }

    /// Height of the upper side of meshes, or else of the level.
    pub(crate) fn height_m(&self, x: f64, z: f64) -> f64 {
        let place = DVec2::new(x, z);
        self.own.height_m(place).or_else(|| self.others.height_m(place)).unwrap_or(self.level_m)
    }

    /// Unit normal, averaged over a distance.
    pub(crate) fn normal(&self, x: f64, z: f64, over_m: f64) -> DVec3 {
        let half = 0.5 * over_m;
        let along_x = self.height_m(x + half, z) - self.height_m(x - half, z);
        let along_z = self.height_m(x, z + half) - self.height_m(x, z - half);
        DVec3::new(-along_x, over_m, -along_z).normalize()
    }
}

impl Meshes {
    fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        let flat = |point: DVec3| DVec2::new(point.x, point.z);
        let points = || triangles.iter().flatten().copied();
        let low = points().map(flat).fold(DVec2::INFINITY, DVec2::min);
        let high = points().map(flat).fold(DVec2::NEG_INFINITY, DVec2::max);
        let side = (triangles.len() / TRIANGLES_PER_CELL).isqrt().clamp(1, MOST_CELLS);
        let cell = ((high - low) / side as f64).max(DVec2::splat(f64::MIN_POSITIVE));
        let mut meshes = Self {
            triangles: Vec::new(),
            corner: low,
            cell,
            side,
            cells: vec![Vec::new(); if triangles.is_empty() { 0 } else { side * side }],
            highest_m: vec![f64::NEG_INFINITY; side.div_ceil(BLOCK).pow(2)],
        };
        for (number, triangle) in triangles.iter().enumerate() {
            let corners = triangle.map(flat);
            let (first, last) = (
                meshes.cell_of(corners[0].min(corners[1]).min(corners[2])),
                meshes.cell_of(corners[0].max(corners[1]).max(corners[2])),
            );
            let highest_m = triangle.map(|corner| corner.y).into_iter().fold(f64::NEG_INFINITY, f64::max);
            for row in first.1..=last.1 {
                for column in first.0..=last.0 {
                    meshes.cells[row * side + column].push(number as u32);
                    let block = &mut meshes.highest_m[row / BLOCK * side.div_ceil(BLOCK) + column / BLOCK];
                    *block = block.max(highest_m);
                }
            }
        }
        meshes.triangles = triangles;
        meshes
    }

    /// Height at a place; `None` outside all triangles.
    fn height_m(&self, place: DVec2) -> Option<f64> {
        let beyond = self.corner + self.cell * self.side as f64;
        if self.cells.is_empty() || place.cmplt(self.corner).any() || place.cmpgt(beyond).any() {
            return None;
        }
        let (column, row) = self.cell_of(place);
        let heights = self.cells[row * self.side + column]
            .iter()
            .filter_map(|&number| height_in(self.triangles[number as usize], place));
        heights.reduce(f64::max)
    }

    fn highest_within(&self, low: DVec2, high: DVec2) -> f64 {
        let [low, high] = [low, high].map(|place| self.cell_of(place));
        let rows = low.1 / BLOCK..=high.1 / BLOCK;
        let row = |row: usize| &self.highest_m[row * self.side.div_ceil(BLOCK)..];
        let heights = rows.flat_map(|number| &row(number)[low.0 / BLOCK..=high.0 / BLOCK]);
        heights.copied().fold(f64::NEG_INFINITY, f64::max)
    }

    fn cell_of(&self, place: DVec2) -> (usize, usize) {
        let cell = (place - self.corner) / self.cell;
        let most = self.side - 1;
        ((cell.x.max(0.0) as usize).min(most), (cell.y.max(0.0) as usize).min(most))
    }
}

/// Height of a triangle's plane at a place inside it, edges included.
pub(super) fn height_in([a, b, c]: [DVec3; 3], place: DVec2) -> Option<f64> {
    let (ab, ac) = (b - a, c - a);
    let (x, z) = (place.x - a.x, place.y - a.z);
    let area = ab.x * ac.z - ab.z * ac.x;
    if area == 0.0 {
        return None;
    }
    let (towards_b, towards_c) = ((x * ac.z - z * ac.x) / area, (z * ab.x - x * ab.z) / area);
    // Tolerance, so that rounding opens no gap between neighbours.
    const SLACK: f64 = -1e-9;
    let inside = towards_b >= SLACK && towards_c >= SLACK && towards_b + towards_c <= 1.0 - SLACK;
    inside.then_some(a.y + towards_b * ab.y + towards_c * ac.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Chance;

    /// Hills as a mesh of `side` times `side` squares over 20 m, and their heights by interpolation.
    fn hills(side: i32) -> Ground {
        let point = |i: i32, j: i32| {
            let (x, z) =
                (20.0 * f64::from(i) / f64::from(side) - 10.0, 20.0 * f64::from(j) / f64::from(side) - 10.0);
            DVec3::new(x, (0.3 * x).sin() + 0.1 * z, z)
        };
        let squares = (0..side).flat_map(|i| (0..side).map(move |j| (i, j)));
        let triangles = squares.flat_map(|(i, j)| {
            let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        Ground::new(-5.0, triangles.collect(), Vec::new())
    }

    #[test]
    fn heights_are_the_meshes_and_beyond_it_the_level() {
        let ground = hills(200);
        for item in 0..2000 {
            let chance = Chance::of(2, item);
            let (x, z) = (20.0 * chance.at(0) - 10.0, 20.0 * chance.at(1) - 10.0);
            let height = ground.height_m(x, z);
            assert!((height - ((0.3 * x).sin() + 0.1 * z)).abs() < 1e-3, "{x} {z} {height}");
            assert!(height <= ground.highest_m);
            let within = [0.0, 0.7].map(|half| {
                let place = DVec2::new(x, z);
                ground.highest_within(place - half, place + half)
            });
            assert!(height <= within[0] && within[0] <= within[1] && within[1] < height + 1.0, "{x} {z}");
        }
        assert_eq!(ground.height_m(10.1, 0.0), -5.0);
        let slope = ground.normal(0.0, 0.0, 0.2);
        assert!((slope - DVec3::new(-0.3, 1.0, -0.1).normalize()).length() < 1e-3, "{slope}");
    }

    #[test]
    fn of_two_floors_the_upper_one_counts_and_walls_do_not() {
        let floor = |y: f64| [DVec3::new(-4.0, y, -4.0), DVec3::new(4.0, y, -4.0), DVec3::new(0.0, y, 4.0)];
        let wall = [DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.0, 9.0, -1.0), DVec3::new(0.0, 0.0, 1.0)];
        let ground = Ground::new(0.0, vec![floor(1.0), floor(2.0), wall], Vec::new());
        assert_eq!(ground.height_m(0.0, 0.0), 2.0);
        assert_eq!(Ground::new(0.25, Vec::new(), Vec::new()).height_m(1.0, 1.0), 0.25);
    }

    #[test]
    fn where_a_mesh_ends_others_go_on_and_then_the_level() {
        let at = |x: f64, y: f64| {
            [DVec3::new(x - 1.0, y, -4.0), DVec3::new(x + 1.0, y, -4.0), DVec3::new(x, y, 4.0)]
        };
        let ground = Ground::new(0.0, vec![at(-1.0, 1.0)], vec![at(-1.0, 7.0), at(1.0, 2.0)]);
        let heights = [-1.0, 1.0, 3.0].map(|x| ground.height_m(x, 0.0));
        assert_eq!((heights, ground.highest_m), ([1.0, 2.0, 0.0], 7.0));
    }
}
