//! Values on a coarse grid of cells over the whole picture. In go values at places of it, out come their
//! sums, smoothed. Invariant: sums are taken in one order, for any number of threads.

use crate::scene::Size;
use glam::DVec2;
use std::ops::{Add, Mul};

/// Approximate number of cells, for any size of picture: errors of indirect light have hardly finer detail.
const CELLS: f64 = 1344.0;
/// Cells along the longer side are a multiple of it, so that pictures of nearly the same shape have the same.
const STEP: f64 = 4.0;
/// Minimum number of cells along the shorter side, for very long pictures.
const FEWEST: f64 = 8.0;

/// Numbers of cells across and down. Cells are about as wide as high.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Shape {
    pub(super) columns: usize,
    pub(super) rows: usize,
}

impl Shape {
    pub(super) fn of(size: Size) -> Self {
        let (width, height) = (size.width as f64, size.height as f64);
        let aspect = width.max(height) / width.min(height);
        let long = STEP * ((CELLS * aspect).sqrt().min(CELLS / FEWEST) / STEP).round();
        let short = (CELLS / long).round();
        let [long, short] = [long as usize, short as usize];
        if width >= height {
            Self { columns: long, rows: short }
        } else {
            Self { columns: short, rows: long }
        }
    }

    pub(super) fn count(self) -> usize {
        self.columns * self.rows
    }

    /// Number of the cell at a place of the picture, `0..1` across and down.
    pub(super) fn cell_at(self, place: DVec2) -> usize {
        let index = |at: f64, count: usize| ((at * count as f64) as usize).min(count - 1);
        index(place.x, self.columns) + self.columns * index(place.y, self.rows)
    }

    /// The four cells whose middles lie about a place of the picture.
    pub(super) fn about(self, place: DVec2) -> Between {
        let between = |at: f64, count: usize| {
            let at = (at * count as f64 - 0.5).clamp(0.0, (count - 1) as f64);
            let low = (at as usize).min(count - 2);
            (low, at - low as f64)
        };
        let ((column, across), (row, down)) = (between(place.x, self.columns), between(place.y, self.rows));
        Between { first: column + self.columns * row, across, down }
    }
}

/// A place between the middles of four cells.
pub(super) struct Between {
    /// Number of the cell above it to the left.
    first: usize,
    /// Distances from the middle of that cell, in cells.
    across: f64,
    down: f64,
}

/// Distance beyond which a Gaussian counts as 0, in its standard deviations.
const REACH: f64 = 3.0;

/// One value for each cell, in rows from the top.
#[derive(Clone)]
pub(super) struct Map<T> {
    pub(super) shape: Shape,
    values: Vec<T>,
}

impl<T: Copy> Map<T> {
    pub(super) fn filled(shape: Shape, value: T) -> Self {
        Self { shape, values: vec![value; shape.count()] }
    }

    /// Map of the same shape by a function of each cell's number.
    pub(super) fn like<U>(&self, value: impl FnMut(usize) -> U) -> Map<U> {
        Map { shape: self.shape, values: (0..self.values.len()).map(value).collect() }
    }

    pub(super) fn of(&self, cell: usize) -> T {
        self.values[cell]
    }

    pub(super) fn cell_mut(&mut self, cell: usize) -> &mut T {
        &mut self.values[cell]
    }
}

impl<T: Copy + Default + Add<Output = T> + Mul<f64, Output = T>> Map<T> {
    pub(super) fn sum(&self) -> T {
        self.values.iter().fold(T::default(), |sum, &value| sum + value)
    }

    /// Sums around each cell, weighted by a Gaussian of that standard deviation, in cells, with the value 1
    /// in its middle. An infinite deviation has the weight 1 everywhere.
    pub(super) fn smoothed(&self, sigma: f64) -> Self {
        if sigma == f64::INFINITY {
            return Self::filled(self.shape, self.sum());
        }
        let reach = (REACH * sigma).ceil() as usize;
        let weights: Vec<f64> = (0..=reach).map(|far| (-0.5 * (far as f64 / sigma).powi(2)).exp()).collect();
        let along = |values: &[T], first: usize, stride: usize, count: usize, at: usize| {
            let near = at.saturating_sub(reach)..(at + reach + 1).min(count);
            near.fold(T::default(), |sum, other| {
                sum + values[first + other * stride] * weights[other.abs_diff(at)]
            })
        };
        let Shape { columns, rows } = self.shape;
        let across = self.like(|cell| along(&self.values, cell - cell % columns, 1, columns, cell % columns));
        self.like(|cell| along(&across.values, cell % columns, columns, rows, cell / columns))
    }

    /// Means around each cell, with the same weights.
    pub(super) fn averaged(&self, sigma: f64) -> Self {
        let (sums, cells) = (self.smoothed(sigma), Map::filled(self.shape, 1.0).smoothed(sigma));
        self.like(|cell| sums.of(cell) * (1.0 / cells.of(cell)))
    }

    /// Value between the middles of four cells.
    pub(super) fn between(&self, &Between { first, across, down }: &Between) -> T {
        let of_row = |first: usize| self.values[first] * (1.0 - across) + self.values[first + 1] * across;
        of_row(first) * (1.0 - down) + of_row(first + self.shape.columns) * down
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Landscape keeps the cells that it always had; a picture on its side has them on their side.
    #[test]
    fn cells_are_about_as_wide_as_high() {
        let of = |width, height| {
            let Shape { columns, rows } = Shape::of(Size { width, height });
            (columns, rows)
        };
        assert_eq!([of(1920, 1080), of(160, 90), of(80, 44)], [(48, 28); 3]);
        assert_eq!([of(1080, 1920), of(50, 90)], [(28, 48); 2]);
        assert_eq!([of(500, 500), of(2000, 500), of(10_000, 1)], [(36, 37), (72, 19), (168, 8)]);
    }
}
