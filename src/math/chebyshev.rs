//! Antiderivative of a smooth function, fitted once and then evaluated often. In go a function, an interval
//! and a tolerance. Out comes the integral over any part of the interval. Invariant: the error of the whole
//! is estimated from the fit itself, and pieces are halved until it is within the tolerance.

use glam::DVec3;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// Degree of the polynomial on each piece.
const DEGREE: usize = 16;
const POINTS: usize = DEGREE + 1;

/// Maximum number of pieces, which bounds the work for functions that are not smooth.
const MAX_PIECES: usize = 512;

/// Half angles `j pi / DEGREE`, whose cosines are the Chebyshev points of the second kind.
static COSINES: LazyLock<[f64; 2 * DEGREE]> =
    LazyLock::new(|| std::array::from_fn(|step| (PI * step as f64 / DEGREE as f64).cos()));

/// The antiderivative of a function with three components.
#[derive(Clone, Debug, Default)]
pub struct Antiderivative {
    /// Pieces in order; each begins where the one before ends.
    pieces: Vec<Piece>,
}

#[derive(Clone, Debug)]
struct Piece {
    start: f64,
    end: f64,
    /// Chebyshev coefficients of the antiderivative that is 0 at the start of the piece.
    coefficients: [DVec3; POINTS],
    /// Antiderivative at the end of the piece.
    whole: DVec3,
    /// Bound on the error of `whole`.
    error: DVec3,
    /// Sum of all earlier pieces.
    before: DVec3,
}

impl Antiderivative {
    /// Fits `function` over `[start, end]`, so that the integral over the whole has a relative error of about
    /// `tolerance` at most in each component. Replaces an earlier fit and reuses its memory.
    pub fn fit(&mut self, function: impl Fn(f64) -> DVec3, start: f64, end: f64, tolerance: f64) {
        self.pieces.clear();
        self.pieces.push(Piece::new(&function, start, end));
        loop {
            let total: DVec3 = self.pieces.iter().map(|piece| piece.whole.abs()).sum();
            let is_coarse = |piece: &Piece| {
                let middle = 0.5 * (piece.start + piece.end);
                piece.error.cmpgt(tolerance * total).any() && piece.start < middle && middle < piece.end
            };
            let Some(first) = self.pieces.iter().position(is_coarse) else { break };
            if self.pieces.len() >= MAX_PIECES {
                break;
            }
            for index in (first..self.pieces.len()).rev() {
                let piece = &self.pieces[index];
                if is_coarse(piece) {
                    let (start, end) = (piece.start, piece.end);
                    let middle = 0.5 * (start + end);
                    self.pieces[index] = Piece::new(&function, middle, end);
                    self.pieces.insert(index, Piece::new(&function, start, middle));
                }
            }
        }
        let mut before = DVec3::ZERO;
        for piece in &mut self.pieces {
            piece.before = before;
            before += piece.whole;
        }
    }

    /// The integral from one place to another, both within the interval.
    pub fn between(&self, from: f64, to: f64) -> DVec3 {
        self.at(to) - self.at(from)
    }

    fn at(&self, x: f64) -> DVec3 {
        let after = self.pieces.partition_point(|piece| piece.end < x);
        let piece = self.pieces.get(after).or(self.pieces.last());
        piece.map_or(DVec3::ZERO, |piece| piece.before + piece.at(x))
    }
}

impl Piece {
    fn new(function: &impl Fn(f64) -> DVec3, start: f64, end: f64) -> Self {
        let (middle, half) = (0.5 * (start + end), 0.5 * (end - start));
        let values: [DVec3; POINTS] = std::array::from_fn(|j| function(middle + half * COSINES[j]));
        // Coefficients of the interpolant through the Chebyshev points (Trefethen, "Approximation Theory
        // and Approximation Practice", chapter 3): a cosine sum whose first and last terms count half.
        let coefficient = |k: usize| {
            let ends = 0.5 * (values[0] + if k.is_multiple_of(2) { values[DEGREE] } else { -values[DEGREE] });
            let inner = (1..DEGREE).map(|j| COSINES[j * k % (2 * DEGREE)] * values[j]);
            inner.fold(ends, |sum, term| sum + term) * (2.0 / DEGREE as f64)
        };
        let mut of_function: [DVec3; POINTS + 1] =
            std::array::from_fn(|k| if k < POINTS { coefficient(k) } else { DVec3::ZERO });
        of_function[DEGREE] *= 0.5;
        // The integral of T_k is T_(k+1) / 2(k+1) - T_(k-1) / 2(k-1); the last, which further points would
        // change most, is left out.
        let mut coefficients = [DVec3::ZERO; POINTS];
        for k in 1..POINTS {
            coefficients[k] = (of_function[k - 1] - of_function[k + 1]) * (half / (2 * k) as f64);
        }
        // T_k is 1 at the end, and alternately 1 and -1 at the start.
        let odd = (1..POINTS).step_by(2).fold(DVec3::ZERO, |sum, k| sum + coefficients[k]);
        let even = (2..POINTS).step_by(2).fold(DVec3::ZERO, |sum, k| sum + coefficients[k]);
        coefficients[0] = odd - even;
        let error = (of_function[DEGREE].abs() + of_function[DEGREE - 1].abs()) * half;
        Self { start, end, coefficients, whole: 2.0 * odd, error, before: DVec3::ZERO }
    }

    /// Clenshaw's recurrence.
    fn at(&self, x: f64) -> DVec3 {
        if x <= self.start {
            return DVec3::ZERO;
        }
        if x >= self.end {
            return self.whole;
        }
        let x = ((x - self.start) - (self.end - x)) / (self.end - self.start);
        let (mut next, mut after_next) = (DVec3::ZERO, DVec3::ZERO);
        for coefficient in self.coefficients[1..].iter().rev() {
            (next, after_next) = (2.0 * x * next - after_next + *coefficient, next);
        }
        x * next - after_next + self.coefficients[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A decaying exponential, a Gaussian-like bump far narrower than the interval, and a square.
        #[test]
        fn equals_closed_forms(rate in 1e-6..500.0_f64, width in 1e-3..2.0_f64, from in 0.0..1.0_f64, to in 0.0..1.0_f64) {
            let function = |x: f64| {
                DVec3::new((-rate * x).exp(), 1.0 / (1.0 + ((x - 0.37) / width).powi(2)), x * x)
            };
            let integral = |x: f64| {
                DVec3::new(-(-rate * x).exp_m1() / rate, width * (((x - 0.37) / width).atan() + (0.37 / width).atan()), x * x * x / 3.0)
            };
            let mut fitted = Antiderivative::default();
            fitted.fit(function, 0.0, 1.0, 1e-12);
            let error = fitted.between(from, to) - (integral(to) - integral(from));
            prop_assert!((error / integral(1.0)).abs().max_element() < 1e-11, "{error} with {} pieces", fitted.pieces.len());
        }
    }

    #[test]
    fn what_is_not_smooth_ends_all_the_same() {
        let mut fitted = Antiderivative::default();
        fitted.fit(|x| DVec3::splat(if x < 1.0 / 3.0 { 1.0 } else { 0.0 }), 0.0, 1.0, 1e-12);
        assert!((fitted.between(0.0, 1.0).x - 1.0 / 3.0).abs() < 1e-9);
        fitted.fit(|_| DVec3::ZERO, 0.0, 1.0, 1e-12);
        assert_eq!((fitted.between(0.0, 1.0), fitted.pieces.len()), (DVec3::ZERO, 1));
        fitted.fit(|_| DVec3::ONE, 2.0, 2.0, 1e-12);
        assert_eq!(fitted.between(2.0, 2.0), DVec3::ZERO);
    }
}
