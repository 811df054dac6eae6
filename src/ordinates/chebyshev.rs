//! Chebyshev acceleration of source iteration (Hageman & Young 1981, "Applied Iterative Methods", chapter 4).
//! In goes the ratio of successive orders, out come the weights with which iterations are added. Invariant:
//! weights do not depend on the light.
//!
//! In thick fog that absorbs little, each order is nearly as bright as the one before, and hundreds of them
//! count. The error of an iteration is a polynomial of the scattering operator. None of the operator's
//! eigenvalues exceeds that ratio; light between two facing walls has an eigenvalue as far below 0. The
//! Chebyshev polynomial is smallest between both bounds.

/// Weights of one iteration: of the source that is left, and of the step before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    pub(super) left: f64,
    pub(super) before: f64,
}

/// Sequence of the weights of iterations.
pub(super) struct Chebyshev {
    greatest: f64,
    last: Option<f64>,
}

impl Chebyshev {
    /// `greatest` is the largest magnitude of the eigenvalues, below 1.
    pub(super) fn new(greatest: f64) -> Self {
        Self { greatest, last: None }
    }

    /// Factor by which an iteration reduces the error.
    pub(super) fn rate(&self) -> f64 {
        self.greatest / (1.0 + (1.0 - self.greatest * self.greatest).sqrt())
    }
}

impl Iterator for Chebyshev {
    type Item = Weights;

    fn next(&mut self) -> Option<Weights> {
        let squared = self.greatest * self.greatest;
        let weight = match self.last {
            None => 1.0,
            Some(1.0) => 1.0 / (1.0 - 0.5 * squared),
            Some(last) => 1.0 / (1.0 - 0.25 * squared * last),
        };
        self.last = Some(weight);
        Some(Weights { left: weight, before: weight - 1.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Solves `x = 1 + e x`, for one eigenvalue `e` each.
    #[test]
    fn series_of_any_eigenvalue_find_their_sum() {
        for eigenvalue in [-0.97, -0.5, 0.0, 0.3, 0.7, 0.9, 0.97] {
            let (mut sum, mut left, mut step) = (0.0, 1.0, 0.0);
            let chebyshev = Chebyshev::new(0.97);
            let error = 4.0 * chebyshev.rate().powi(60);
            for weights in chebyshev.take(60) {
                step = weights.left * left + weights.before * step;
                sum += step;
                left += (eigenvalue - 1.0) * step;
            }
            let truth = 1.0 / (1.0 - eigenvalue);
            assert!((sum / truth - 1.0_f64).abs() < error, "{eigenvalue}: {sum} for {truth}, within {error}");
        }
    }
}
