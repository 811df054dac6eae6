//! Cubic polynomials. In go coefficients, out come values and integrals. Invariant: coefficients are in the
//! order of powers, from 0 on.

/// Coefficients by powers, from 0 on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cubic(pub [f64; 4]);

impl Cubic {
    /// Value at `x`.
    pub fn at(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        a + x * (b + x * (c + x * d))
    }

    /// Integral from 0 to `x`.
    pub fn integral(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.0;
        x * (a + x * (b / 2.0 + x * (c / 3.0 + x * d / 4.0)))
    }

    /// Cubic times a factor.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self(self.0.map(|coefficient| factor * coefficient))
    }
}
