//! Importance of a picture's places: the density of probes. In goes the light of the first probes, out come
//! places and the weights of probes there. Invariant: every place has probes, and the weights leave means of
//! the picture unbiased.
//!
//! A few bright places, such as fog around a lantern, cause most of the noise. The variance of a sum is
//! smallest if probes are as dense as their standard deviation (Cochran 1977, "Sampling techniques", section
//! 5.5). That is about proportional to light. Few probes estimate the grid's light well, and noise badly.

use super::map::{Map, Shape};
use glam::DVec2;

/// Share of probes that are uniform, so that dark places keep theirs.
const EVEN: f64 = 0.5;

/// Density of probes by cell, with mean 1.
pub(super) struct Importance {
    density: Map<f64>,
    rows: Vec<f64>,
}

impl Importance {
    pub(super) fn even(shape: Shape) -> Self {
        Self::with(Map::filled(shape, 1.0))
    }

    fn with(density: Map<f64>) -> Self {
        let Shape { columns, rows } = density.shape;
        let row = |row: usize| -> f64 { (0..columns).map(|column| density.of(column + columns * row)).sum() };
        Self { rows: (0..rows).map(row).collect(), density }
    }

    /// Importance by the grid's light, as first probes have it.
    pub(super) fn of(light: &Map<f64>) -> Self {
        let per_mean = light.shape.count() as f64 / light.sum();
        if !per_mean.is_finite() {
            return Self::even(light.shape);
        }
        Self::with(light.like(|cell| EVEN + (1.0 - EVEN) * per_mean * light.of(cell)))
    }

    /// Place that two uniform numbers sample, `0..1` across and down, and the weight of a probe there.
    pub(super) fn sample(&self, u: DVec2) -> (DVec2, f64) {
        let Shape { columns, rows } = self.density.shape;
        let (row, down) = sample_discrete(self.rows.iter().copied(), u.y);
        let density = |column: usize| self.density.of(column + columns * row);
        let (column, across) = sample_discrete((0..columns).map(density), u.x);
        let place = DVec2::new((column as f64 + across) / columns as f64, (row as f64 + down) / rows as f64);
        (place, 1.0 / density(column))
    }
}

/// Index of the weight that a uniform number samples, and the remainder of the number, uniform again.
fn sample_discrete(weights: impl ExactSizeIterator<Item = f64> + Clone, u: f64) -> (usize, f64) {
    let (last, mut left) = (weights.len() - 1, u * weights.clone().sum::<f64>());
    for (number, weight) in weights.enumerate() {
        if number == last || left < weight {
            return (number, (left / weight).clamp(0.0, 1.0 - f64::EPSILON));
        }
        left -= weight;
    }
    (last, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kronecker;

    /// Probes are as dense as a cell is important, with the inverse weight: all cells have the same sum.
    #[test]
    fn a_cell_counts_the_same_however_many_probes_it_has() {
        let mut sums = Map::filled(Shape { columns: 48, rows: 28 }, 0.0);
        let shape = sums.shape;
        let density = |cell: usize| if cell % shape.columns < 12 { 2.5 } else { 0.5 };
        let importance = Importance::with(sums.like(density));
        let count = 400 * shape.count();
        for number in 0..count {
            let u = DVec2::new((number as f64 + 0.5) / count as f64, kronecker(0.3, number));
            let (place, counts) = importance.sample(u);
            *sums.cell_mut(shape.cell_at(place)) += counts;
        }
        for cell in 0..shape.count() {
            assert!((sums.of(cell) - 400.0).abs() < 60.0, "{cell}: {}", sums.of(cell));
        }
    }
}
