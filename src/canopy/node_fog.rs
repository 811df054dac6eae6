//! Fog by node of a grid. In go a medium and walls, out come coefficients by node. Invariant: no fog is lost
//! or counted twice where walls cut cells, so a thin layer over ground has its optical depth.

use super::delta_scaled_fog::{DeltaScaledFog, FogCoefficients};
use crate::ordinates::grid::{Corners, Grid};
use crate::ordinates::occluders::{CutGrid, Occluders};
use glam::DVec3;
use rayon::prelude::*;

/// Number of sampled places of a cell: a lattice with all of them at different heights (Korobov 1959).
const PLACES: usize = 64;
const GENERATOR: [usize; 3] = [19, 1, 27];

/// Number of cells near walls whose samples are held at a time, which limits memory.
const CELLS_AT_ONCE: usize = 512;

/// Returns the coefficients of each node.
pub(crate) fn fog_of_nodes(
    CutGrid { grid, occluders }: CutGrid,
    fog: &DeltaScaledFog,
) -> Vec<FogCoefficients> {
    let alone = |node: usize| {
        if occluders.are_near(node) { FogCoefficients::default() } else { mean_of((grid, node), fog) }
    };
    let mut nodes: Vec<FogCoefficients> = (0..grid.count()).into_par_iter().map(alone).collect();
    let near: Vec<usize> = (0..grid.count()).filter(|node| occluders.are_near(*node)).collect();
    for cells in near.chunks(CELLS_AT_ONCE) {
        let shared = cells.par_iter().map(|node| shared_out((grid, *node), occluders, fog));
        for (corners, here) in shared.collect::<Vec<_>>().iter().flatten() {
            for (node, weight) in corners.iter().filter(|(_, weight)| *weight > 0.0) {
                nodes[node].add(here, weight / PLACES as f64);
            }
        }
    }
    nodes
}

fn place_in((grid, node): (&Grid, usize), number: usize) -> DVec3 {
    let along = |axis: usize| ((GENERATOR[axis] * number % PLACES) as f64 + 0.5) / PLACES as f64 - 0.5;
    grid.position(node) + grid.cell_m * DVec3::new(along(0), along(1), along(2))
}

/// Coefficients at places of a cell near walls, with the nodes that represent each.
fn shared_out(
    cell: (&Grid, usize),
    occluders: &Occluders,
    fog: &DeltaScaledFog,
) -> Vec<(Corners, FogCoefficients)> {
    let of_place = |number: usize| {
        let place = place_in(cell, number);
        (occluders.cell_of(cell.0, place), fog.at(place - fog.eye))
    };
    (0..PLACES).map(of_place).collect()
}

/// Mean over a cell; exact where fog is uniform around it.
fn mean_of(cell: (&Grid, usize), fog: &DeltaScaledFog) -> FogCoefficients {
    let (middle, cell_m) = (cell.0.position(cell.1) - fog.eye, cell.0.cell_m);
    let corner = |number: usize| {
        let sign = |bit: usize| if number >> bit & 1 == 1 { 0.5 } else { -0.5 };
        middle + (1.0 - 1e-9) * cell_m * DVec3::new(sign(0), sign(1), sign(2))
    };
    let here = fog.dimming.extinction_at(middle);
    let is_even = !fog.emits() && (0..8).all(|number| fog.dimming.extinction_at(corner(number)) == here);
    if is_even {
        return fog.at(middle);
    }
    let mut mean = FogCoefficients::default();
    (0..PLACES).for_each(|number| mean.add(&fog.at(place_in(cell, number) - fog.eye), 1.0 / PLACES as f64));
    mean
}
