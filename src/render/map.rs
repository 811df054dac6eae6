//! Values on a coarse grid of cells over the whole picture. In go values at places of it, out come their
//! sums, smoothed. Invariant: sums are taken in one order, for any number of threads.

use glam::DVec2;
use std::ops::{Add, Mul};

/// Cells across and down, for any size of picture: errors of indirect light have hardly finer detail.
pub(super) const COLUMNS: usize = 48;
pub(super) const ROWS: usize = 28;

/// Distance beyond which a Gaussian counts as 0, in its standard deviations.
const REACH: f64 = 3.0;

/// One value for each cell, in rows from the top.
#[derive(Clone)]
pub(super) struct Map<T>(Vec<T>);

impl<T: Copy> Map<T> {
    pub(super) fn filled(value: T) -> Self {
        Self(vec![value; COLUMNS * ROWS])
    }

    /// Map by a function of each cell's number.
    pub(super) fn from_fn(value: impl FnMut(usize) -> T) -> Self {
        Self((0..COLUMNS * ROWS).map(value).collect())
    }

    pub(super) fn of(&self, cell: usize) -> T {
        self.0[cell]
    }

    pub(super) fn cell_mut(&mut self, cell: usize) -> &mut T {
        &mut self.0[cell]
    }
}

/// Index of the cell at a place of the picture, `0..1` across and down.
pub(super) fn cell_at(place: DVec2) -> usize {
    let index = |at: f64, count: usize| ((at * count as f64) as usize).min(count - 1);
    index(place.x, COLUMNS) + COLUMNS * index(place.y, ROWS)
}

impl<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>> Map<T> {
    pub(super) fn sum(&self) -> T {
        self.0.iter().fold(T::default(), |sum, &value| sum + value)
    }

    /// Sums around each cell, weighted by a Gaussian of that standard deviation, in cells, with the value 1
    /// in its middle. An infinite deviation has the weight 1 everywhere.
    pub(super) fn smoothed(&self, sigma: f64) -> Self {
        if sigma == f64::INFINITY {
            return Self::filled(self.sum());
        }
        let reach = (REACH * sigma).ceil() as usize;
        let weights: Vec<f64> = (0..=reach).map(|far| (-0.5 * (far as f64 / sigma).powi(2)).exp()).collect();
        let along = |values: &[T], first: usize, stride: usize, count: usize, at: usize| {
            let near = at.saturating_sub(reach)..(at + reach + 1).min(count);
            near.fold(T::default(), |sum, other| {
                sum + values[first + other * stride] * weights[other.abs_diff(at)]
            })
        };
        let across = Self::from_fn(|cell| along(&self.0, cell - cell % COLUMNS, 1, COLUMNS, cell % COLUMNS));
        Self::from_fn(|cell| along(&across.0, cell % COLUMNS, COLUMNS, ROWS, cell / COLUMNS))
    }

    /// Means around each cell, with the same weights.
    pub(super) fn averaged(&self, sigma: f64) -> Self {
        let (sums, cells) = (self.smoothed(sigma), Map::filled(1.0).smoothed(sigma));
        Self::from_fn(|cell| sums.of(cell) * (1.0 / cells.of(cell)))
    }

    /// Value at a place of the picture, interpolated between the middles of cells.
    pub(super) fn at(&self, place: DVec2) -> T {
        let between = |at: f64, count: usize| {
            let at = (at * count as f64 - 0.5).clamp(0.0, (count - 1) as f64);
            let low = (at as usize).min(count - 2);
            (low, at - low as f64)
        };
        let ((column, across), (row, down)) = (between(place.x, COLUMNS), between(place.y, ROWS));
        let of_row = |row: usize| {
            let first = column + COLUMNS * row;
            self.0[first] * (1.0 - across) + self.0[first + 1] * across
        };
        of_row(row) * (1.0 - down) + of_row(row + 1) * down
    }
}
