//! Clumping index of leaves within cells, which know leaf area alone and not its arrangement. In go surfels,
//! out comes an index for each node. Invariant: leaves at independent random places have an index of 1.
//!
//! A canopy of the leaf area `L` has the transmittance `exp(-G L)` if its leaves are at random places, and
//! `exp(-G L omega)` if they stand in clumps (Nilson 1971, "A theoretical analysis of the frequency of gaps
//! in plant stands"). The index `omega` is estimated here. Columns of a cell, hardly wider than a leaf, have
//! their own leaf area. A cell with its neighbours has the mean of their transmittances (Lang & Xiang 1986,
//! "Estimation of leaf area index from transmission of direct sunlight in discontinuous canopies"). The
//! neighbours are included because a grid spreads leaves over them: clumps as wide as cells would be lost,
//! too.
//!
//! A leaf of a clump gets the share `omega` of light from elsewhere. By reciprocity the same share of its own
//! light leaves the clump, and the rest meets another leaf of it. This is the recollision probability
//! `1 - omega` (Smolander & Stenberg 2005, "Simple parameterizations of the radiation budget of uniform
//! broadleaved and coniferous canopies").

use super::recollision::escaped;
use super::surfels::Surfels;
use crate::color::Rgb;
use crate::ordinates::grid::{Corners, Grid};
use crate::scene::Bounces;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Minimum width of columns, in leaf widths: narrower ones would resolve single leaves.
const LEAVES_ACROSS: f64 = 1.2;
/// Maximum number of columns along each side of a cell.
const MOST_COLUMNS: usize = 6;
/// Minimum index: a cell whose leaves overlap completely would be transparent.
const LEAST: f64 = 0.2;
/// Number of terms of a geometric series: later ones are negligible.
const MOST_TERMS: u32 = 32;
/// Maximum number of columns of all cells and axes, which limits memory.
const MOST_IN_ALL: f64 = 16e6;

/// Clumping index of leaves, by node.
pub(crate) struct Clumping {
    /// Clumping index by node; empty where cells are too small for clumps.
    indices: Vec<f32>,
    bounces: Bounces,
}

impl Clumping {
    pub(crate) fn of(grid: &Grid, surfels: &Surfels, bounces: Bounces) -> Self {
        let none = Self { indices: Vec::new(), bounces };
        let leaf_m = surfels.leaf_area_m2.sqrt();
        if leaf_m <= 0.0 {
            return none;
        }
        let most = MOST_COLUMNS.min((MOST_IN_ALL / (3 * grid.count()) as f64).sqrt() as usize);
        let across = ((grid.cell_m / (LEAVES_ACROSS * leaf_m)) as usize).min(most);
        if across < 2 {
            return none;
        }
        let (columns, by_chance) = Columns::of(grid, surfels, across);
        let (stopped, depths): (Vec<_>, Vec<_>) =
            (0..grid.count()).into_par_iter().map(|node| columns.of_node(grid, node)).unzip();
        let summed = |node: usize| {
            let of_axis = |axis: usize| {
                let [stopped, depth] =
                    [&stopped, &depths].map(|of: &Vec<[f32; 3]>| grid.mean_across(axis, node, of)[axis]);
                [-(-stopped).ln_1p(), by_chance[axis] * depth]
            };
            (0..3).map(of_axis).fold([0.0; 2], |sums, depths| [sums[0] + depths[0], sums[1] + depths[1]])
        };
        let found: Vec<[f32; 2]> = (0..grid.count()).into_par_iter().map(summed).collect();
        let index = |node: usize| {
            let [found, anywhere] = grid.mean_about(node, &found);
            if anywhere > 0.0 { (found / anywhere).clamp(LEAST as f32, 1.0) } else { 1.0 }
        };
        Self { indices: (0..grid.count()).map(index).collect(), bounces }
    }

    /// Whether there are no clumps.
    pub(crate) fn is_none(&self) -> bool {
        self.indices.is_empty()
    }

    /// Index of a node.
    pub(crate) fn at(&self, node: usize) -> f64 {
        self.indices.get(node).map_or(1.0, |index| f64::from(*index))
    }

    /// Interpolated index at a place; it is continuous, so a falling leaf does not flicker.
    pub(crate) fn about(&self, corners: &Corners) -> f64 {
        if self.is_none() { 1.0 } else { corners.iter().map(|(node, share)| share * self.at(node)).sum() }
    }

    /// Irradiance on leaves of a clump with an index and an albedo from light outside, relative to single
    /// leaves. By reciprocity it is the share of their own light that leaves the clump, too.
    pub(crate) fn inside(&self, index: f64, albedo: Rgb) -> Rgb {
        match self.bounces {
            Bounces::All => escaped(index, albedo),
            // As many terms of the series as there are bounces.
            Bounces::UpTo(count) => {
                let met_again = (1.0 - index) * albedo.min(Rgb::ONE);
                (0..count.min(MOST_TERMS)).fold(Rgb::ZERO, |sum, _| index + met_again * sum)
            }
        }
    }
}

/// Columns of all cells along each axis.
struct Columns {
    /// Number of columns along each side of a cell.
    across: usize,
    side_m: f64,
    /// Projected leaf area in each column, m^2, by node, by axis, by column.
    areas_m2: Vec<f32>,
}

impl Columns {
    /// Columns, and by axis the index that leaves at random places seem to have: each leaf is in one column
    /// as a whole, and their number is Poisson-distributed.
    fn of(grid: &Grid, surfels: &Surfels, across: usize) -> (Self, Vec3) {
        let side_m = grid.cell_m / across as f64;
        let mut areas_m2 = vec![0.0; grid.count() * 3 * across * across];
        let leaf = surfels.leaf_area_m2 / side_m.powi(2);
        let (mut taken, mut all) = (DVec3::ZERO, DVec3::ZERO);
        surfels.for_each_in(grid, |surfel| {
            let (node, [x, y, z]) = grid.piece(surfel.position, across);
            for (axis, [u, v]) in [[y, z], [z, x], [x, y]].into_iter().enumerate() {
                let seen = surfel.normal[axis].abs() * surfel.area;
                areas_m2[((3 * node + axis) * across + u) * across + v] += surfel.exposed * seen as f32;
            }
            let depth = leaf * surfel.normal.abs();
            taken += surfel.area * (DVec3::ONE - (-depth).exp());
            all += surfel.area * depth;
        });
        let by_chance = DVec3::select(all.cmpgt(DVec3::ZERO), taken / all, DVec3::ONE).as_vec3();
        (Self { across, side_m, areas_m2 }, by_chance)
    }

    /// Share of light that columns stop, along each axis, and the mean optical depth of their leaves. A clump
    /// may be longer than a cell, so columns extend into the next cells. Leaves flat on the ground are no
    /// clump: seen from the side they have hardly any area.
    fn of_node(&self, grid: &Grid, node: usize) -> ([f32; 3], [f32; 3]) {
        let (cell, strides) = (grid.cell_of(node), grid.strides());
        let count = self.across * self.across;
        let (mut stopped, mut depths) = ([0.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let before = (cell[axis] > 0).then(|| node - strides[axis]);
            let behind = (cell[axis] + 1 < grid.size[axis]).then(|| node + strides[axis]);
            let cells = [before, Some(node), behind].into_iter().flatten();
            let cells: Vec<&[f32]> =
                cells.map(|cell| &self.areas_m2[(3 * cell + axis) * count..][..count]).collect();
            if cells.iter().all(|cell| cell.iter().all(|area_m2| *area_m2 == 0.0)) {
                continue;
            }
            let depth = |column: usize| {
                let area_m2: f64 = cells.iter().map(|cell| f64::from(cell[column])).sum();
                area_m2 / self.side_m.powi(2)
            };
            let (sum_stopped, sum) = (0..count)
                .map(depth)
                .fold((0.0, 0.0), |(stopped, all), depth| (stopped - (-depth).exp_m1(), all + depth));
            stopped[axis] = (sum_stopped / count as f64) as f32;
            depths[axis] = (sum / count as f64) as f32;
        }
        (stopped, depths)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const CELL_M: f64 = 2.0;
    const LEAF_AREA_M2: f64 = 0.04;

    /// Mean index of the cells of a box full of leaves, in groups of a size, in a layer of a height.
    fn index(leaves_a_clump: usize, layer: f64) -> f64 {
        let half_m = 8.0;
        let grid = Grid::covering(DVec3::splat(-half_m), DVec3::splat(half_m), CELL_M);
        let clumps = 40_000 / leaves_a_clump;
        let place = |number: usize| {
            // Splitmix64 (Steele, Lea & Flood 2014).
            let uniform = |index: usize| {
                let mut z = (3 * number + index + 1) as u64;
                z = z.wrapping_mul(0x9e37_79b9_7f4a_7c15);
                z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                (z ^ (z >> 31)) as f64 / u64::MAX as f64
            };
            half_m
                * DVec3::new(1.0, layer, 1.0)
                * (2.0 * DVec3::new(uniform(0), uniform(1), uniform(2)) - 1.0)
        };
        let places = (0..clumps).flat_map(|number| std::iter::repeat_n(place(number), leaves_a_clump));
        let clumping = Clumping::of(&grid, &Surfels::of_leaves(places, LEAF_AREA_M2), Bounces::All);
        let inside: Vec<usize> = (0..grid.count())
            .filter(|node| grid.position(*node).abs().max_element() < half_m - 2.0 * CELL_M)
            .collect();
        inside.iter().map(|node| clumping.at(*node)).sum::<f64>() / inside.len() as f64
    }

    #[test]
    fn leaves_that_stand_anywhere_have_an_index_of_one() {
        let index = index(1, 1.0);
        assert!((0.97..=1.0).contains(&index), "{index}");
    }

    /// A clump at a point acts as one leaf of its area: their number is Poisson-distributed, so their
    /// transmittance is known.
    #[test]
    fn clumps_have_that_of_as_many_large_leaves() {
        let across = ((CELL_M / (LEAVES_ACROSS * LEAF_AREA_M2.sqrt())) as usize).min(MOST_COLUMNS);
        let by_chance = |area_m2: f64| {
            let depth = area_m2 / (CELL_M / across as f64).powi(2);
            -(-depth).exp_m1() / depth
        };
        for leaves in [2, 4, 12] {
            let expected = by_chance(leaves as f64 * LEAF_AREA_M2) / by_chance(LEAF_AREA_M2);
            let found = index(leaves, 1.0);
            assert!((found / expected - 1.0).abs() < 0.06, "{leaves}: {found} {expected}");
        }
    }

    /// Pillars a quarter of a cell wide, uniformly full of leaves: none is clumped within its cell.
    #[test]
    fn clumps_as_wide_as_cells_are_clumps() {
        let half_m = 8.0;
        let grid = Grid::covering(DVec3::splat(-half_m), DVec3::splat(half_m), CELL_M);
        let is_full = |node: &usize| {
            let [x, _, z] = grid.cell_of(*node);
            x % 2 == 0 && z % 2 == 0
        };
        let full: Vec<usize> = (0..grid.count()).filter(is_full).collect();
        let evenly = |leaf: usize| DVec3::new((leaf % 6) as f64 - 2.5, 0.0, (leaf / 6) as f64 - 2.5) / 6.0;
        let places = full.iter().flat_map(|node| {
            let middle = grid.position(*node);
            (0..36).map(move |leaf| middle + CELL_M * evenly(leaf))
        });
        let clumping = Clumping::of(&grid, &Surfels::of_leaves(places, LEAF_AREA_M2), Bounces::All);
        let index = full.iter().map(|node| clumping.at(*node)).sum::<f64>() / full.len() as f64;
        assert!(index < 0.9, "{index}");
    }

    /// They do not overlap: all face up.
    #[test]
    fn leaves_that_lie_on_the_ground_are_no_clump() {
        let index = index(1, 1e-3);
        assert!(index > 0.95, "{index}");
    }

    /// All light that enters a clump and is scattered leaves it, and the terms of the series add up to its
    /// sum.
    #[test]
    fn nothing_is_lost_within_a_clump_that_absorbs_nothing() {
        let clumping = |bounces| Clumping { indices: Vec::new(), bounces };
        let albedo = Rgb::new(1.0, 0.5, 0.0);
        let all = clumping(Bounces::All).inside(0.6, albedo);
        assert!((all - Rgb::new(1.0, 0.75, 0.6)).abs().max_element() < 1e-12, "{all}");
        let few = [1, 2].map(|count| clumping(Bounces::UpTo(count)).inside(0.6, albedo));
        assert!((few[0] - 0.6).abs().max_element() < 1e-12, "{few:?}");
        assert!((few[1] - 0.6 * Rgb::new(1.4, 1.2, 1.0)).abs().max_element() < 1e-12, "{few:?}");
        // An albedo above 1 counts as 1.
        let more = clumping(Bounces::All).inside(0.6, Rgb::splat(3.0));
        assert!((more - 1.0).abs().max_element() < 1e-12, "{more}");
        let many = clumping(Bounces::UpTo(u32::MAX)).inside(0.6, albedo);
        assert!((many - all).abs().max_element() < 1e-9, "{many} {all}");
    }
}
