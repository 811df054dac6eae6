//! Boundary conditions of a grid. In goes the radiance of the sky, or of the solution around the grid; out
//! comes the incident radiance of one ordinate in the cells around a plane. Invariant: radiance straight from
//! the sky has ordinates of its own, finer than those of scattered light, as objects cast sharp shadows in
//! it.
//!
//! To add a condition, add a variant of [`BoundaryCondition`] and its arm in `fill`; extend `varies` if
//! planes differ. `source_iteration.rs` picks the condition of each sweep. A condition does not see the
//! radiance that leaves the grid, so none of them can reflect it.

use super::angular_radiance::AngularRadiance;
use super::grid::Grid;
use super::planes::Planes;
use super::quadrature::Quadrature;
use crate::color::Rgb;
use glam::DVec3;

#[derive(Clone, Copy)]
pub(crate) enum BoundaryCondition<'a> {
    Vacuum,
    /// Radiance by ordinate, the same on all sides.
    Uniform(&'a [Rgb]),
    /// Radiance by ordinate in each cell around the grid.
    Incident(&'a IncidentRadiance),
}

/// A plane with the cells around it, for one channel and ordinate.
#[derive(Clone, Copy)]
pub(crate) struct Rim<'a> {
    pub(crate) planes: &'a Planes,
    /// Number of the plane; the one before the first is -1.
    pub(crate) plane: i32,
    pub(crate) channel: usize,
    pub(crate) ordinate: usize,
}

impl BoundaryCondition<'_> {
    /// Whether rims differ from plane to plane.
    pub(crate) fn varies(&self) -> bool {
        matches!(self, Self::Incident(_))
    }

    /// Sets the rim of a plane, and all cells of a plane before the first or after the last.
    pub(crate) fn fill(&self, Rim { planes, plane, channel, ordinate }: Rim, into: &mut [f32]) {
        let incident = match self {
            Self::Vacuum => return into.fill(0.0),
            Self::Uniform(radiances) => return into.fill(radiances[ordinate][channel] as f32),
            Self::Incident(incident) => incident,
        };
        let [count, rows, columns] = planes.count.map(|count| count as i32);
        let is_outside = plane < 0 || plane == count;
        for row in -1..=rows {
            let is_rim = is_outside || row < 0 || row == rows;
            let step = if is_rim { 1 } else { columns as usize + 1 };
            for column in (-1..=columns).step_by(step) {
                let mut place = [0; 3];
                for (axis, index) in planes.axes.into_iter().zip([plane, row, column]) {
                    place[axis] = index;
                }
                let at = (row + 1) as usize * planes.row() + (column + 1) as usize;
                into[at] = incident.radiance(place, channel, ordinate);
            }
        }
    }
}

/// Incident radiance on a grid from its surrounding, if there is one.
#[derive(Default)]
pub(crate) struct Surrounding {
    /// All radiance that was scattered or emitted: one sum, or order by order where orders are counted.
    pub(crate) scattered: Vec<IncidentRadiance>,
    /// Radiance straight from the sky.
    pub(crate) of_sky: Option<IncidentRadiance>,
    /// Radiance straight from emitters, if `scattered` does not include it.
    pub(crate) emitted: Option<IncidentRadiance>,
}

impl Surrounding {
    /// Whether scattered radiance from outside has finer ordinates than those of all orders.
    pub(crate) fn is_fine(&self) -> bool {
        self.scattered.iter().any(|incident| incident.is_fine)
    }
}

/// Radiance in the cells around a grid, by ordinate.
pub(crate) struct IncidentRadiance {
    /// Number of cells along each axis, with those of the grid.
    size: [usize; 3],
    /// Index into `radiances` of each cell around the grid.
    numbers: Vec<u32>,
    /// Radiances by that index.
    radiances: AngularRadiance,
    /// Whether it is along [`Quadrature::fine`].
    pub(crate) is_fine: bool,
}

impl IncidentRadiance {
    /// Incident radiance of a grid; `radiances` are those of [`rim_places`].
    pub(crate) fn new(grid: &Grid, radiances: AngularRadiance) -> Self {
        Self::of_alike(grid, 0.., radiances)
    }

    /// As [`Self::new`], with 0 beyond closed sides of the grid: larger cells there have matter that lies
    /// within the grid.
    pub(crate) fn without_ends(grid: &Grid, mut radiances: AngularRadiance) -> Self {
        for (number, place) in rim_places(grid).into_iter().enumerate() {
            if grid.is_past_its_end(place) {
                radiances.0.iter_mut().flatten().for_each(|of_places| of_places[number] = 0.0);
            }
        }
        Self::new(grid, radiances)
    }

    /// Incident radiance with one entry for all equal places; `alike` has the entry's number for each of
    /// [`rim_places`].
    pub(crate) fn of_alike(
        grid: &Grid,
        alike: impl IntoIterator<Item = u32>,
        radiances: AngularRadiance,
    ) -> Self {
        let mut alike = alike.into_iter();
        let number = |place: Option<DVec3>| place.and_then(|_| alike.next()).unwrap_or(0);
        let numbers = all_about(grid).map(number).collect();
        let is_fine = radiances.0[0].len() == Quadrature::FINE;
        Self { size: grid.size.map(|count| count + 2), numbers, radiances, is_fine }
    }

    /// Radiance of a channel along an ordinate, in a cell around the grid. The grid's first cell is at 0.
    fn radiance(&self, place: [i32; 3], channel: usize, ordinate: usize) -> f32 {
        let [x, y, z] = place.map(|index| (index + 1) as usize);
        let number = self.numbers[x + self.size[0] * (y + self.size[1] * z)];
        self.radiances.0[channel][ordinate][number as usize]
    }
}

/// Centres of the cells around a grid, in world space.
pub(crate) fn rim_places(grid: &Grid) -> Vec<DVec3> {
    all_about(grid).flatten().collect()
}

/// Centres of the cells around a grid; `None` for each cell of the grid itself.
fn all_about(grid: &Grid) -> impl Iterator<Item = Option<DVec3>> {
    let size = grid.size.map(|count| count + 2);
    (0..size.iter().product()).map(move |cell: usize| {
        let place = [cell % size[0], cell / size[0] % size[1], cell / (size[0] * size[1])];
        let is_about = (0..3).any(|axis| place[axis] == 0 || place[axis] == size[axis] - 1);
        let steps = DVec3::from_array(place.map(|index| index as f64 - 1.0));
        is_about.then(|| grid.position(0) + grid.cell_m * steps)
    })
}
