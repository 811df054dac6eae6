//! Error that is left in indirect light after its correction by walks. In go sums over two halves of the
//! walks and each half's correction, out come squares of the error, cell by cell. Invariant: the expected
//! value has no noise of the walks.

use super::correction::mean;
use super::map::Map;
use super::moments::Moments;
use super::probes::PASSES;
use crate::color::Rgb;

/// Standard deviation of the Gaussian by which the grid's light is averaged, in cells.
const SURROUNDINGS: f64 = 1.0;
/// Standard deviation of the surroundings in which a cell's error is estimated, in cells.
const LOCAL: f64 = 4.0;
/// Prior of the relative error of indirect light, before walks have measured it.
const EXPECTED: f64 = 0.03;

/// The grid's light of each pass, averaged over probes.
pub(super) struct Light(pub(super) [Map<Rgb>; PASSES]);

impl Light {
    pub(super) fn of(moments: &Moments) -> Self {
        let count = moments.count().smoothed(SURROUNDINGS);
        Self(std::array::from_fn(|pass| {
            let sum = moments.grid(pass).smoothed(SURROUNDINGS);
            sum.like(|cell| sum.of(cell) / count.of(cell).max(f64::MIN_POSITIVE))
        }))
    }

    /// Sum over all passes.
    pub(super) fn at(&self, cell: usize) -> Rgb {
        self.0.iter().map(|light| light.of(cell)).sum()
    }

    /// Mean of the colour channels, summed over all passes.
    pub(super) fn brightness(&self) -> Map<f64> {
        self.0[0].like(|cell| mean(self.at(cell)))
    }

    pub(super) fn mean(&self) -> Rgb {
        self.0.iter().map(Map::sum).sum::<Rgb>() / self.0[0].shape.count() as f64
    }
}

/// Residuals of pairs of walks, after corrections that do not know the other walk: of two in one half after
/// the other half's correction, of one in each half after its own. So products have no noise on average, but
/// for what both halves' common weights of estimates know.
pub(super) struct Left {
    /// Sums of such products near each cell, and their number.
    products: Map<f64>,
    pairs: Map<f64>,
    variances: Map<f64>,
    /// Square of the noise of the correction, in means over surroundings. That of a half is twice as large,
    /// and counts in half of the pairs.
    noise: Map<f64>,
}

impl Left {
    pub(super) fn of(
        (halves, near_cells): (&[Moments; 2], f64),
        corrections: &[[Map<Rgb>; PASSES]; 2],
        light: &Light,
    ) -> Self {
        let shape = light.0[0].shape;
        let noise = light.0[0].like(|cell| -> Rgb {
            let of_pass = |pass: usize| {
                let [one, other] = corrections.each_ref().map(|shares| shares[pass].of(cell));
                0.5 * (one - other) * light.0[pass].of(cell)
            };
            (0..PASSES).map(of_pass).sum()
        });
        let near = noise.averaged(near_cells);
        let noise = noise.like(|cell| mean(noise.of(cell) * near.of(cell)));
        let none = Map::filled(shape, 0.0);
        let mut all = Self { products: none.clone(), pairs: none.clone(), variances: none, noise };
        let left = [0, 1].map(|half| halves[half].left(&corrections[1 - half]));
        let own = [0, 1].map(|half| halves[half].left(&corrections[half]).0);
        let near = |sums: &Map<Rgb>| sums.smoothed(near_cells);
        let (left_near, own_near) = (left.each_ref().map(|(sums, _)| near(sums)), own.each_ref().map(near));
        let count = halves[0].with(&halves[1]).count();
        let count_near = count.smoothed(near_cells);
        let squares = count.like(|cell| left.iter().map(|(_, squares)| mean(squares.of(cell))).sum::<f64>());
        let squares_near = squares.smoothed(near_cells * 0.5_f64.sqrt());
        for cell in 0..shape.count() {
            let of_half = |half: usize| {
                left[half].0.of(cell) * left_near[half].of(cell)
                    + own[half].of(cell) * own_near[1 - half].of(cell)
            };
            // Without the products of a walk with itself.
            *all.products.cell_mut(cell) = mean(of_half(0) + of_half(1)) - squares.of(cell);
            *all.pairs.cell_mut(cell) = count.of(cell) * (count_near.of(cell) - 1.0);
            *all.variances.cell_mut(cell) = 2.0 * squares.of(cell) * squares_near.of(cell);
        }
        all
    }

    /// Squares of the error that is left, cell by cell: noise of the correction, and the mean of the measured
    /// residual and its expected value, by their precision. The whole picture's error is the expectation for
    /// its parts.
    pub(super) fn squares(&self, light: &Light) -> Map<f64> {
        let Self { products, pairs, variances, noise } = self;
        let cells = noise.shape.count() as f64;
        let of_light = noise.like(|cell| mean(light.at(cell)).powi(2));
        let square_of_light = of_light.sum() / cells;
        let found = |products: f64, pairs: f64, variances: f64| {
            let pairs = pairs.max(f64::MIN_POSITIVE);
            (products / pairs, variances / (pairs * pairs))
        };
        let (product, variance) = found(products.sum(), pairs.sum(), variances.sum());
        let expected = EXPECTED.powi(2) * square_of_light;
        // The uncertainty is added, so that few walks never give a small error.
        let rest = product - noise.sum() / cells;
        let whole = judged(rest, variance, expected) + doubt(variance, expected);
        let [products, pairs] = [products, pairs].map(|map| map.smoothed(LOCAL));
        let noise = noise.averaged(LOCAL);
        let variances = variances.smoothed(LOCAL * 0.5_f64.sqrt());
        products.like(|cell| {
            let (product, variance) = found(products.of(cell), pairs.of(cell), variances.of(cell));
            let expected =
                if square_of_light > 0.0 { whole * of_light.of(cell) / square_of_light } else { 0.0 };
            let noise = noise.of(cell).max(0.0);
            noise + judged(product - noise, variance, expected)
        })
    }
}

/// Mean, by precision, of a measured square with its variance, and of an expected square whose standard
/// deviation is itself.
fn judged(found: f64, variance: f64, expected: f64) -> f64 {
    let precision = expected * expected / (expected * expected + variance).max(f64::MIN_POSITIVE);
    expected + precision * (found.max(0.0) - expected)
}

/// Standard deviation of the mean in `judged`.
fn doubt(variance: f64, expected: f64) -> f64 {
    let square = expected * expected;
    (square * variance / (square + variance).max(f64::MIN_POSITIVE)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::map::Shape;
    use super::super::probes::Probe;
    use super::*;
    use crate::transport::Noted;
    use glam::DVec2;

    /// Estimated error where the two halves' corrections of an exact grid are off by the same amounts, with
    /// opposite signs.
    fn told(off: impl Fn(usize) -> f64) -> f64 {
        let shape = Shape { columns: 48, rows: 28 };
        let mut half = Moments::none(shape);
        for cell in 0..shape.count() {
            let (column, row) = ((cell % shape.columns) as f64, (cell / shape.columns) as f64);
            let place = DVec2::new((column + 0.5) / shape.columns as f64, (row + 0.5) / shape.rows as f64);
            assert_eq!(shape.cell_at(place), cell);
            let light = [Rgb::ONE, Rgb::ZERO];
            half.add(&Probe {
                place,
                weight: 1.0,
                walk: light,
                grid: light,
                drawn: 1,
                noted: Noted::default(),
            });
        }
        let shares = |sign: f64| {
            let none = Map::filled(shape, Rgb::ZERO);
            [none.like(|cell| Rgb::splat(sign * off(cell))), none]
        };
        let light = Light::of(&half);
        let left = Left::of((&[half.clone(), half], 1.0), &[shares(1.0), shares(-1.0)], &light);
        left.squares(&light).of(shape.cell_at(DVec2::splat(0.5))).sqrt()
    }

    /// Noise of a correction counts as error, except where it cancels in means over surroundings.
    #[test]
    fn noise_counts_by_its_mean_over_surroundings() {
        let (everywhere, in_turns) = (told(|_| 0.1), told(|cell| if cell % 2 == 0 { 0.1 } else { -0.1 }));
        assert!((everywhere - 0.1).abs() < 0.005, "{everywhere}");
        assert!(in_turns < 0.03, "{in_turns}");
    }
}
