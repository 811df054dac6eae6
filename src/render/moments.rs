//! Moments of many probes, cell by cell of the picture. In go probes, out come sums of their values and of
//! products of these. Invariant: only sums are stored, so memory does not grow with the number of probes.

use super::map::{Map, Shape};
use super::probes::{PASSES, Probe};
use crate::color::Rgb;

/// Values of each pass: walk minus grid, and grid.
const VALUES: usize = 2 * PASSES;

/// Sums over the probes of a cell, each by its weight.
#[derive(Clone, Copy, Default)]
struct Cell {
    count: f64,
    sums: [Rgb; VALUES],
    products: [[Rgb; VALUES]; VALUES],
}

/// Sums over probes.
#[derive(Clone)]
pub(super) struct Moments(Map<Cell>);

impl Moments {
    pub(super) fn none(shape: Shape) -> Self {
        Self(Map::filled(shape, Cell::default()))
    }

    pub(super) fn add(&mut self, probe: &Probe) {
        let mut values = [Rgb::ZERO; VALUES];
        for pass in 0..PASSES {
            values[2 * pass] = probe.weight * (probe.walk[pass] - probe.grid[pass]);
            values[2 * pass + 1] = probe.weight * probe.grid[pass];
        }
        let cell = self.0.cell_mut(self.0.shape.cell_at(probe.place));
        cell.count += probe.weight;
        for (row, &value) in values.iter().enumerate() {
            cell.sums[row] += value;
            for (product, &other) in cell.products[row].iter_mut().zip(&values) {
                *product += value * other;
            }
        }
    }

    /// Moments of two sets of probes together.
    pub(super) fn with(&self, other: &Self) -> Self {
        Self(self.0.like(|cell| {
            let (mut sum, other) = (self.0.of(cell), other.0.of(cell));
            sum.count += other.count;
            for row in 0..VALUES {
                sum.sums[row] += other.sums[row];
                for column in 0..VALUES {
                    sum.products[row][column] += other.products[row][column];
                }
            }
            sum
        }))
    }

    pub(super) fn shape(&self) -> Shape {
        self.0.shape
    }

    pub(super) fn count(&self) -> Map<f64> {
        self.0.like(|cell| self.0.of(cell).count)
    }

    /// Sum of walk minus grid.
    pub(super) fn difference(&self, pass: usize) -> Map<Rgb> {
        self.0.like(|cell| self.0.of(cell).sums[2 * pass])
    }

    pub(super) fn grid(&self, pass: usize) -> Map<Rgb> {
        self.0.like(|cell| self.0.of(cell).sums[2 * pass + 1])
    }

    /// Sum, and sum of squares, of the difference between walk and grid in each cell, after each pass of the
    /// grid's light is multiplied by 1 plus its share.
    pub(super) fn left(&self, shares: &[Map<Rgb>; PASSES]) -> (Map<Rgb>, Map<Rgb>) {
        let weights = |cell: usize| {
            let mut weights = [Rgb::ONE; VALUES];
            for (pass, share) in shares.iter().enumerate() {
                weights[2 * pass + 1] = -share.of(cell);
            }
            weights
        };
        let sums = self.0.like(|cell| {
            let sums = self.0.of(cell).sums;
            weights(cell).iter().zip(sums).map(|(&weight, sum)| weight * sum).sum()
        });
        let squares = self.0.like(|cell| {
            let (products, weights) = (self.0.of(cell).products, weights(cell));
            let row = |row: usize| -> Rgb {
                (0..VALUES).map(|column| weights[column] * products[row][column]).sum()
            };
            (0..VALUES).map(|index| weights[index] * row(index)).sum()
        });
        (sums, squares)
    }

    /// Sum of these squares in one pass.
    pub(super) fn squares_left(&self, pass: usize, share: &Map<Rgb>) -> Map<Rgb> {
        self.0.like(|cell| {
            let (products, share) = (self.0.of(cell).products, share.of(cell));
            let [difference, grid] = [2 * pass, 2 * pass + 1];
            products[difference][difference] - 2.0 * share * products[difference][grid]
                + share * share * products[grid][grid]
        })
    }
}
