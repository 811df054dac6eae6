//! What comes into a grid from the one about it. In goes radiance of that one next to the grid's rim, out it
//! comes cell by cell. Invariant: what comes straight from the sky stays apart, along ordinates of its own,
//! as things have cut edges into it.

use super::grid::Grid;
use super::ordinates::Ordinates;
use super::radiances::Radiances;
use glam::DVec3;

/// Light of a larger grid about a grid, if there is one.
#[derive(Default)]
pub(super) struct Around {
    /// All that anything has scattered or sent out.
    pub(super) scattered: Option<Halo>,
    pub(super) of_sky: Option<Halo>,
}

impl Around {
    /// Whether what was scattered outside comes along finer ordinates than those of all orders.
    pub(super) fn is_fine(&self) -> bool {
        self.scattered.as_ref().is_some_and(|halo| halo.is_fine)
    }
}

/// Some light about a grid.
pub(super) struct Halo {
    /// Cells along each axis, the grid's among them.
    size: [usize; 3],
    /// The number of each cell about the grid among its like.
    numbers: Vec<u32>,
    /// By that number.
    radiances: Radiances,
    /// Whether it is along [`super::ordinates::Ordinates::fine`].
    pub(super) is_fine: bool,
}

impl Halo {
    /// `radiances` are of [`places_about`] the grid.
    pub(super) fn new(grid: &Grid, radiances: Radiances) -> Self {
        let mut after = 0;
        let number = |place: Option<DVec3>| {
            after += u32::from(place.is_some());
            after.saturating_sub(1)
        };
        let numbers = all_about(grid).map(number).collect();
        let is_fine = radiances.0[0].len() == Ordinates::FINE;
        Self { size: grid.size.map(|count| count + 2), numbers, radiances, is_fine }
    }

    /// Radiance of a channel along an ordinate, in a cell about the grid. The grid's first cell is at 0.
    pub(super) fn radiance(&self, place: [i32; 3], channel: usize, ordinate: usize) -> f32 {
        let [x, y, z] = place.map(|index| (index + 1) as usize);
        let number = self.numbers[x + self.size[0] * (y + self.size[1] * z)];
        self.radiances.0[channel][ordinate][number as usize]
    }
}

/// Middles of the cells about a grid, in world space.
pub(super) fn places_about(grid: &Grid) -> Vec<DVec3> {
    all_about(grid).flatten().collect()
}

/// Of all cells of a grid and about it, the middles of those about it.
fn all_about(grid: &Grid) -> impl Iterator<Item = Option<DVec3>> {
    let size = grid.size.map(|count| count + 2);
    (0..size.iter().product()).map(move |cell: usize| {
        let place = [cell % size[0], cell / size[0] % size[1], cell / (size[0] * size[1])];
        let is_about = (0..3).any(|axis| place[axis] == 0 || place[axis] == size[axis] - 1);
        let steps = DVec3::from_array(place.map(|index| index as f64 - 1.0));
        is_about.then(|| grid.position(0) + grid.cell_m * steps)
    })
}
