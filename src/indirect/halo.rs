//! What comes into a grid from the one about it. In go places about the grid and radiance at the nodes of
//! that one, out comes radiance in the cells next to the grid's. Invariant: it is all light of the larger
//! field, the sky's own among it where fog sees that.

use super::grid::{Corners, Grid};
use super::radiances::Radiances;
use glam::DVec3;
use rayon::prelude::*;

/// Light about a grid.
pub(super) struct Halo {
    /// Cells along each axis, the grid's among them.
    size: [usize; 3],
    /// Of each cell about the grid the larger grid's nodes; of the grid's own none.
    corners: Vec<Option<Corners>>,
    radiances: Radiances,
}

impl Halo {
    /// `corners` has the larger grid's nodes about a place of world space.
    pub(super) fn new(grid: &Grid, radiances: Radiances, corners: impl Fn(DVec3) -> Corners + Sync) -> Self {
        let size = grid.size.map(|count| count + 2);
        let of_cell = |cell: usize| {
            let place = [cell % size[0], cell / size[0] % size[1], cell / (size[0] * size[1])];
            let is_about = (0..3).any(|axis| place[axis] == 0 || place[axis] == size[axis] - 1);
            let steps = DVec3::from_array(place.map(|index| index as f64 - 1.0));
            is_about.then(|| corners(grid.position(0) + grid.cell_m * steps))
        };
        let cells = 0..size.iter().product();
        Self { size, corners: cells.into_par_iter().map(of_cell).collect(), radiances }
    }

    /// Radiance of a channel along an ordinate. The grid's first cell is at 0.
    pub(super) fn radiance(&self, place: [i32; 3], channel: usize, ordinate: usize) -> f32 {
        let [x, y, z] = place.map(|index| (index + 1) as usize);
        let corners = &self.corners[x + self.size[0] * (y + self.size[1] * z)];
        corners.as_ref().map_or(0.0, |corners| self.radiances.mean(corners, channel, ordinate))
    }
}
