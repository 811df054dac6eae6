//! What comes into a grid from the one about it. In goes the field of that one, out comes radiance in
//! the cells next to the grid's. Invariant: it is all light of the larger field, the sky's own among
//! it where fog sees that.

use super::grid::Grid;
use super::harmonics::COUNT;
use glam::DVec3;
use rayon::prelude::*;

/// Light about a grid.
pub(super) struct Halo {
    /// Cells along each axis, the grid's among them.
    size: [usize; 3],
    /// Moments of radiance by cell; zero in the grid's own.
    moments: Vec<[[f32; COUNT]; 3]>,
}

impl Halo {
    /// `light` has the moments at a place of world space.
    pub(super) fn new(grid: &Grid, light: impl Fn(DVec3) -> [[f32; COUNT]; 3] + Sync) -> Self {
        let size = grid.size.map(|count| count + 2);
        let cells = 0..size.iter().product();
        let moments = cells.into_par_iter().map(|cell: usize| {
            let place = [cell % size[0], cell / size[0] % size[1], cell / (size[0] * size[1])];
            let is_about = (0..3).any(|axis| place[axis] == 0 || place[axis] == size[axis] - 1);
            if !is_about {
                return [[0.0; COUNT]; 3];
            }
            let steps = DVec3::from_array(place.map(|index| index as f64 - 1.0));
            light(grid.position(0) + grid.cell_m * steps)
        });
        Self { size, moments: moments.collect() }
    }

    /// Radiance of a channel along a direction of travel, with that one's basis. The
    /// grid's first cell is at 0.
    pub(super) fn radiance(&self, place: [i32; 3], channel: usize, basis: &[f32; COUNT]) -> f32 {
        let [x, y, z] = place.map(|index| (index + 1) as usize);
        let moments = &self.moments[x + self.size[0] * (y + self.size[1] * z)][channel];
        moments.iter().zip(basis).map(|(moment, basis)| moment * basis).sum::<f32>().max(0.0)
    }
}
