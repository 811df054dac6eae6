//! Chebyshev acceleration of source iteration (Hageman & Young 1981, "Applied Iterative Methods", chapter 4).
//! In goes by what share of themselves orders go on, out come the weights with which iterations are added.
//! Invariant: weights know nothing of the light.
//!
//! In thick fog that absorbs little, light of each order is nearly that of the one before, and hundreds of
//! them count. The error of an iteration is a polynomial of the scattering operator. No eigenvalue of it is
//! larger than that share, and light that goes to and fro between two walls has one as negative. Chebyshev's
//! polynomial is least between both.

/// Weights of one iteration: of what is left of the source, and of the step before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights {
    pub(super) left: f64,
    pub(super) before: f64,
}

/// Weights of iterations, one after the other.
pub(super) struct Chebyshev {
    greatest: f64,
    last: Option<f64>,
}

impl Chebyshev {
    /// `greatest` size of all eigenvalues, below 1.
    pub(super) fn new(greatest: f64) -> Self {
        Self { greatest, last: None }
    }

    /// Factor by which an iteration makes errors smaller.
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

    /// `x = 1 + e x` of one eigenvalue each.
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
