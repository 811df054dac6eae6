//! Kernels of a sweep, for many nodes at once. In go slices of coefficients and sources by node, out come
//! radiance and moments by node. Invariant: nodes of a plane are independent of each other, so eight are
//! computed at once, each by the same operations in the same order for any vector width.

use super::harmonics::COUNT;
use crate::accel::Vectorized;

/// Harmonics that change sign for the opposite direction; the others stay the same.
const ODD: std::ops::Range<usize> = 1..4;

/// Cells of one channel, along an ordinate and its opposite: their transmittances, and the radiance of their
/// sources.
pub(crate) struct Cells<'a> {
    /// Sources by harmonic, and the ordinate's harmonics.
    pub(crate) sources: [&'a [f32]; COUNT],
    pub(crate) basis: &'a [f32; COUNT],
    pub(crate) isotropic_extinction: &'a [f32],
    pub(crate) oriented_extinction: &'a [f32],
    /// Path through a cell, metres, and the factor on it where walls cut cells.
    pub(crate) way_m: f32,
    pub(crate) stretch: &'a [f32],
    /// Transmittance of a cell, and its mean over the places in it.
    pub(crate) through: &'a mut [f32],
    pub(crate) mean: &'a mut [f32],
    /// Radiance that a cell's source adds to the outgoing radiance, and to the mean within; along the
    /// ordinate and its opposite.
    pub(crate) added: [&'a mut [f32]; 2],
    pub(crate) added_within: [&'a mut [f32]; 2],
}

impl Vectorized for Cells<'_> {
    #[inline(always)]
    fn run(self) {
        let count = self.through.len();
        let [s0, s1, s2, s3, s4, s5, s6, s7, s8] = self.sources.map(|values| &values[..count]);
        let [b0, b1, b2, b3, b4, b5, b6, b7, b8] = *self.basis;
        let (isotropic, oriented) = (&self.isotropic_extinction[..count], &self.oriented_extinction[..count]);
        let [along, against] = self.added.map(|values| &mut values[..count]);
        let [within_along, within_against] = self.added_within.map(|values| &mut values[..count]);
        let (through, mean, stretch) = (self.through, &mut self.mean[..count], &self.stretch[..count]);
        for node in 0..count {
            let even =
                b0 * s0[node] + b4 * s4[node] + b5 * s5[node] + b6 * s6[node] + b7 * s7[node] + b8 * s8[node];
            let odd = b1 * s1[node] + b2 * s2[node] + b3 * s3[node];
            let way_m = self.way_m * stretch[node];
            let means = Means::of(way_m * (isotropic[node] + oriented[node]));
            (through[node], mean[node]) = (means.end, means.mean);
            // Truncated harmonics may be negative where they should be nearly 0; sums over ordinates are
            // right only if they stay so.
            let (gain, gain_within) = (way_m * means.mean, way_m * means.mean_of_mean);
            along[node] = gain * (even + odd);
            against[node] = gain * (even - odd);
            within_along[node] = gain_within * (even + odd);
            within_against[node] = gain_within * (even - odd);
        }
    }
}

/// Adds sources of degrees 3 to 5 to those of cells.
pub(crate) struct AddBeam<'a> {
    /// Sources by degree, with their values along the ordinate.
    pub(crate) sources: [&'a [f32]; 3],
    pub(crate) factors: [f32; 3],
    pub(crate) isotropic_extinction: &'a [f32],
    pub(crate) oriented_extinction: &'a [f32],
    /// As in [`Cells`].
    pub(crate) way_m: f32,
    pub(crate) stretch: &'a [f32],
    pub(crate) added: [&'a mut [f32]; 2],
    pub(crate) added_within: [&'a mut [f32]; 2],
}

impl Vectorized for AddBeam<'_> {
    #[inline(always)]
    fn run(self) {
        let count = self.isotropic_extinction.len();
        let [third, fourth, fifth] = self.sources.map(|values| &values[..count]);
        let stretch = &self.stretch[..count];
        let [of_third, of_fourth, of_fifth] = self.factors;
        let (isotropic, oriented) = (&self.isotropic_extinction[..count], &self.oriented_extinction[..count]);
        let [along, against] = self.added.map(|values| &mut values[..count]);
        let [within_along, within_against] = self.added_within.map(|values| &mut values[..count]);
        for node in 0..count {
            let even = of_fourth * fourth[node];
            let odd = of_third * third[node] + of_fifth * fifth[node];
            let way_m = self.way_m * stretch[node];
            let means = Means::of(way_m * (isotropic[node] + oriented[node]));
            let (gain, gain_within) = (way_m * means.mean, way_m * means.mean_of_mean);
            along[node] += gain * (even + odd);
            against[node] += gain * (even - odd);
            within_along[node] += gain_within * (even + odd);
            within_against[node] += gain_within * (even - odd);
        }
    }
}

/// Adds the slopes of dense cells' sources to those of cells.
pub(crate) struct AddSlopes<'a> {
    /// Slopes along the axes of the world, and the ordinate's components times its isotropic harmonic.
    pub(crate) slopes: [&'a [f32]; 3],
    pub(crate) along_axes: [f32; 3],
    pub(crate) isotropic_extinction: &'a [f32],
    pub(crate) oriented_extinction: &'a [f32],
    /// As in [`Cells`].
    pub(crate) way_m: f32,
    pub(crate) mean: &'a [f32],
    pub(crate) added: [&'a mut [f32]; 2],
    pub(crate) added_within: [&'a mut [f32]; 2],
}

impl Vectorized for AddSlopes<'_> {
    #[inline(always)]
    fn run(self) {
        /// Minimum optical depth: cells with slopes have more.
        const LEAST: f32 = 0.125;
        let count = self.isotropic_extinction.len();
        let [x, y, z] = self.slopes.map(|values| &values[..count]);
        let [along_x, along_y, along_z] = self.along_axes;
        let (isotropic, oriented) = (&self.isotropic_extinction[..count], &self.oriented_extinction[..count]);
        let mean = &self.mean[..count];
        let [along, against] = self.added.map(|values| &mut values[..count]);
        let [within_along, within_against] = self.added_within.map(|values| &mut values[..count]);
        for node in 0..count {
            let slope = along_x * x[node] + along_y * y[node] + along_z * z[node];
            let depth = (self.way_m * (isotropic[node] + oriented[node])).max(LEAST);
            // Integrals of a source that is 0 in the middle of the way.
            let gain = self.way_m * self.way_m * ((1.0 - mean[node]) / depth - 0.5 * mean[node]);
            let gain_within = -gain / depth;
            along[node] += gain * slope;
            against[node] -= gain * slope;
            within_along[node] += gain_within * slope;
            within_against[node] -= gain_within * slope;
        }
    }
}

/// Rows of a plane: each node's incoming radiance is a weighted mean over the four cells before it.
pub(crate) struct StepRows<'a> {
    pub(crate) shares: [f32; 4],
    /// The plane before, with its rim, and the indices of the first node's four cells.
    pub(crate) before: &'a [f32],
    pub(crate) first: [usize; 4],
    pub(crate) behind: &'a mut [f32],
    /// Index of the first node in `behind`; number of rows; their length with the rim and without.
    pub(crate) here: usize,
    pub(crate) rows: usize,
    pub(crate) row: usize,
    pub(crate) columns: usize,
    /// Values of nodes from the plane's first, as in [`Cells`], and the stride of rows.
    pub(crate) through: &'a [f32],
    pub(crate) mean: &'a [f32],
    pub(crate) added: &'a [f32],
    pub(crate) added_within: &'a [f32],
    pub(crate) radiance: &'a mut [f32],
    pub(crate) stride: usize,
}

impl<'a> Vectorized for StepRows<'a> {
    #[inline(always)]
    fn run(self) {
        let [p, q, r, s] = self.shares;
        for row in 0..self.rows {
            let (from, start) = (row * self.row, row * self.stride);
            let side = |number: usize| &self.before[self.first[number] + from..][..self.columns];
            let (a, b, c, d) = (side(0), side(1), side(2), side(3));
            let out = &mut self.behind[self.here + from..][..self.columns];
            let of_row = |values: &'a [f32]| &values[start..][..self.columns];
            let (through, mean) = (of_row(self.through), of_row(self.mean));
            let (added, added_within) = (of_row(self.added), of_row(self.added_within));
            let radiance = &mut self.radiance[start..][..self.columns];
            for column in 0..self.columns {
                let entering = p * a[column] + q * b[column] + r * c[column] + s * d[column];
                radiance[column] = entering * mean[column] + added_within[column];
                out[column] = entering * through[column] + added[column];
            }
        }
    }
}

/// Adds radiance along an ordinate and against it to moments.
pub(crate) struct Accumulate<'a> {
    pub(crate) along: &'a [f32],
    pub(crate) against: &'a [f32],
    /// Weight times basis.
    pub(crate) factors: [f32; COUNT],
    /// Moments, one harmonic after another.
    pub(crate) moments: &'a mut [f32],
}

impl Vectorized for Accumulate<'_> {
    #[inline(always)]
    fn run(self) {
        let (along, against) = (self.along, &self.against[..self.along.len()]);
        for (index, moments) in self.moments.chunks_exact_mut(along.len()).enumerate() {
            let factor = self.factors[index];
            let back = if ODD.contains(&index) { -factor } else { factor };
            for node in 0..along.len() {
                moments[node] += factor * along[node] + back * against[node];
            }
        }
    }
}

/// Adds radiance to moments of one degree.
pub(crate) struct AccumulateDegree<'a> {
    pub(crate) along: &'a [f32],
    pub(crate) against: &'a [f32],
    /// Parity: the sign for the opposite direction, 1 or -1.
    pub(crate) back: f32,
    pub(crate) factors: &'a [f32],
    pub(crate) moments: &'a mut [f32],
}

impl Vectorized for AccumulateDegree<'_> {
    #[inline(always)]
    fn run(self) {
        let (along, against) = (self.along, &self.against[..self.along.len()]);
        for (factor, moments) in self.factors.iter().zip(self.moments.chunks_exact_mut(along.len())) {
            for node in 0..along.len() {
                moments[node] += factor * (along[node] + self.back * against[node]);
            }
        }
    }
}

/// `exp(-x)` and its means over `0..x`, for `x >= 0`.
pub(super) struct Means {
    pub(super) end: f32,
    pub(super) mean: f32,
    /// Mean over `0..x` of that mean.
    pub(super) mean_of_mean: f32,
}

impl Means {
    /// Accurate to a relative 3e-6, without branch or call, so that eight are computed at once.
    ///
    /// Padé's approximation of `exp(-x / 16)`, squared four times.
    #[inline(always)]
    pub(super) fn of(x: f32) -> Self {
        /// Value of `x` beyond which nothing is transmitted.
        const MOST: f32 = 24.0;
        /// Value of `x` below which a series avoids cancellation in `(1 - mean) / x`.
        const SMALL: f32 = 0.5;
        let bounded = x.min(MOST);
        let z = bounded * (1.0 / 16.0);
        let even = 1.0 + z * z * (1.0 / 12.0);
        let root = (even - 0.5 * z) / (even + 0.5 * z);
        let square = root * root;
        let fourth = square * square;
        let eighth = fourth * fourth;
        // 1 - r = z / (even + z / 2), and 1 - r^16 is that times (1 + r)(1 + r^2)(1 + r^4)(1 + r^8): without
        // cancellation at small x.
        let of_bounded = (1.0 / 16.0) / (even + 0.5 * z)
            * ((1.0 + root) * (1.0 + square))
            * ((1.0 + fourth) * (1.0 + eighth));
        let beyond = if x > MOST { MOST / x } else { 1.0 };
        let mean = of_bounded * beyond;
        let series = 0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x * (1.0 / 120.0 - x * (1.0 / 720.0))));
        let mean_of_mean = if x < SMALL { series } else { (1.0 - mean) / x };
        Self { end: eighth * eighth, mean, mean_of_mean }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_and_its_means_are_right() {
        for step in 0..4000 {
            let x = 0.01 * f64::from(step);
            let Means { end, mean, mean_of_mean } = Means::of(x as f32);
            let expected = if x > 0.0 { -(-x).exp_m1() / x } else { 1.0 };
            let twice = if x > 1e-3 { (1.0 - expected) / x } else { 0.5 - x / 6.0 };
            assert!((f64::from(end) - (-x).exp()).abs() < 3e-6, "{x}: {end}");
            assert!((f64::from(mean) - expected).abs() < 3e-6, "{x}: {mean} {expected}");
            assert!((f64::from(mean_of_mean) - twice).abs() < 8e-6, "{x}: {mean_of_mean} {twice}");
        }
    }
}
