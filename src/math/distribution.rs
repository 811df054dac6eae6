//! Piecewise constant distribution on the unit square. In go the density of each cell of a grid and uniform
//! numbers, out come cells and places. Invariant: the map is continuous enough to keep low-discrepancy points
//! well distributed; a cell of density 0 is never sampled.

use glam::DVec2;

/// A density that is constant on each cell of a square grid (Pharr, Jakob & Humphreys, "Physically
/// Based Rendering", section A.5).
#[derive(Clone, Debug)]
pub struct SquareDistribution {
    side: usize,
    /// Prefix sums of the rows' densities: 0, the first row's, the first two rows', ... all.
    rows: Vec<f64>,
    /// Prefix sums within each row, row by row.
    columns: Vec<f64>,
}

impl SquareDistribution {
    /// Distribution from densities, row by row; `None` if all are 0, or some are not finite.
    pub fn new(side: usize, densities: impl Iterator<Item = f64>) -> Option<Self> {
        let mut rows = vec![0.0];
        let mut columns = Vec::with_capacity(side * (side + 1));
        let (mut total, mut row) = (0.0, 0.0);
        for (index, density) in densities.enumerate() {
            if index % side == 0 {
                row = 0.0;
                columns.push(row);
            }
            row += density;
            columns.push(row);
            if index % side == side - 1 {
                total += row;
                rows.push(total);
            }
        }
        (total > 0.0 && total.is_finite()).then_some(Self { side, rows, columns })
    }

    /// Index of the cell that two uniform numbers sample, and the place within the square.
    pub fn sample(&self, u: DVec2) -> (usize, DVec2) {
        let (row, y) = sample_discrete(&self.rows, u.y);
        let (column, x) = sample_discrete(&self.columns[row * (self.side + 1)..][..=self.side], u.x);
        let place = DVec2::new(column as f64 + x, row as f64 + y) / self.side as f64;
        (row * self.side + column, place)
    }

    /// Probability density of places in a cell, relative to the mean over the square.
    pub fn density(&self, cell: usize) -> f64 {
        let (row, column) = (cell / self.side, cell % self.side);
        let first = row * (self.side + 1) + column;
        let share = (self.columns[first + 1] - self.columns[first]) / self.rows[self.side];
        share * (self.side * self.side) as f64
    }

    /// Index of the cell that holds a place of the square.
    pub fn cell(&self, place: DVec2) -> usize {
        let index = |x: f64| ((x * self.side as f64) as usize).min(self.side - 1);
        index(place.y) * self.side + index(place.x)
    }
}

/// Index of the step of `sums` that holds the share `u` of the total, and the position within the step.
fn sample_discrete(sums: &[f64], u: f64) -> (usize, f64) {
    let wanted = u * sums[sums.len() - 1];
    // The last step that begins at or before the wanted sum and is not empty.
    let step = sums.partition_point(|sum| *sum <= wanted).clamp(1, sums.len() - 1) - 1;
    let width = sums[step + 1] - sums[step];
    (step, if width > 0.0 { ((wanted - sums[step]) / width).clamp(0.0, 1.0) } else { 0.5 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    #[test]
    fn cells_are_picked_as_often_as_they_are_dense() {
        let densities = [0.0, 3.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.0, 2.0];
        let table = SquareDistribution::new(3, densities.into_iter()).expect("it has a sum");
        let count = 1 << 12;
        let mut sampled = [0; 9];
        for sample in 0..count {
            let (cell, place) = table.sample(Sampler::new(9, 0, 0, sample).next_2d().into());
            assert_eq!(table.cell(place), cell);
            sampled[cell] += 1;
        }
        for (sampled, density) in sampled.into_iter().zip(densities) {
            let expected = density / 8.0 * f64::from(count);
            assert!((f64::from(sampled) - expected).abs() <= 6.0, "{sampled} instead of {expected}");
        }
        for (cell, density) in densities.into_iter().enumerate() {
            assert!((table.density(cell) - density * 9.0 / 8.0).abs() < 1e-14);
        }
        for u in [DVec2::ZERO, DVec2::splat(1.0 - 1e-16), DVec2::ONE] {
            assert!(densities[table.sample(u).0] > 0.0, "{u}");
        }
    }

    #[test]
    fn nothing_makes_no_distribution() {
        assert!(SquareDistribution::new(2, [0.0; 4].into_iter()).is_none());
        assert!(SquareDistribution::new(2, [f64::INFINITY; 4].into_iter()).is_none());
    }
}
