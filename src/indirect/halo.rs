//! What comes into a grid from the one about it. In go places about the grid and radiance at the nodes of
//! that one, out comes radiance in the cells next to the grid's. Invariant: what comes straight from the sky
//! stays apart, along ordinates of its own, as things have cut edges into it.

use super::grid::{Corners, Grid};
use super::radiances::Radiances;
use glam::DVec3;
use rayon::prelude::*;

/// Light of a larger grid about a grid, if there is one.
#[derive(Default)]
pub(super) struct Around {
    /// All that anything has scattered or sent out.
    pub(super) scattered: Option<Halo>,
    pub(super) of_sky: Option<Halo>,
}

/// Some light about a grid.
pub(super) struct Halo {
    /// Cells along each axis, the grid's among them.
    size: [usize; 3],
    /// The number of each cell about the grid among its like.
    numbers: Vec<u32>,
    /// By that number.
    radiances: Radiances,
}

impl Halo {
    /// `corners` has the larger grid's nodes about a place of world space.
    pub(super) fn new(grid: &Grid, radiances: &Radiances, corners: impl Fn(DVec3) -> Corners + Sync) -> Self {
        let size = grid.size.map(|count| count + 2);
        let mut about = Vec::new();
        let number_of = |cell: usize| {
            let place = [cell % size[0], cell / size[0] % size[1], cell / (size[0] * size[1])];
            if (0..3).any(|axis| place[axis] == 0 || place[axis] == size[axis] - 1) {
                about.push(place);
            }
            about.len().saturating_sub(1) as u32
        };
        let numbers = (0..size.iter().product()).map(number_of).collect();
        let corners_of = |place: [usize; 3]| {
            let steps = DVec3::from_array(place.map(|index| index as f64 - 1.0));
            corners(grid.position(0) + grid.cell_m * steps)
        };
        let corners: Vec<Corners> = about.into_par_iter().map(corners_of).collect();
        Self { size, numbers, radiances: radiances.at(&corners) }
    }

    /// Radiance of a channel along an ordinate, in a cell about the grid. The grid's first cell is at 0.
    pub(super) fn radiance(&self, place: [i32; 3], channel: usize, ordinate: usize) -> f32 {
        let [x, y, z] = place.map(|index| (index + 1) as usize);
        let number = self.numbers[x + self.size[0] * (y + self.size[1] * z)];
        self.radiances.of(channel, ordinate)[number as usize]
    }
}
