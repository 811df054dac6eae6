//! Gauss-Legendre rules on `[-1, 1]`. In goes an order, out come nodes and weights. Invariant: weights are
//! positive and sum to 2.
use std::sync::LazyLock;

/// Maximum order of a rule.
const MAX_ORDER: usize = 16;

/// (node, weight) pairs of the rule with `order` nodes, `1..=16`.
pub fn gauss_legendre(order: usize) -> &'static [(f64, f64)] {
    static RULES: LazyLock<Vec<Vec<(f64, f64)>>> =
        LazyLock::new(|| (1..=MAX_ORDER).map(legendre_rule).collect());
    &RULES[order.clamp(1, MAX_ORDER) - 1]
}

/// Newton's iteration on the Legendre polynomial (Press et al., Numerical Recipes, section 4.6).
fn legendre_rule(order: usize) -> Vec<(f64, f64)> {
    let n = order as f64;
    (0..order)
        .map(|index| {
            let mut x = (std::f64::consts::PI * (index as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (mut current, mut previous) = (x, 1.0);
                for degree in 2..=order {
                    let k = degree as f64;
                    let next = ((2.0 * k - 1.0) * x * current - (k - 1.0) * previous) / k;
                    (previous, current) = (current, next);
                }
                slope = n * (x * current - previous) / (x * x - 1.0);
                let step = current / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// Legendre polynomials of degrees 0 to N - 1, by their recurrence `(l + 1) P_(l+1) = (2 l + 1) x P_l - l
/// P_(l-1)`.
pub fn legendre<const N: usize>(x: f64) -> [f64; N] {
    let mut values = [1.0; N];
    if N > 1 {
        values[1] = x;
    }
    for degree in 2..N {
        let l = (degree - 1) as f64;
        values[degree] = ((2.0 * l + 1.0) * x * values[degree - 1] - l * values[degree - 2]) / (l + 1.0);
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rule with n nodes is exact for polynomials up to degree 2n - 1.
    #[test]
    fn exact_for_polynomials() {
        for order in 1..=MAX_ORDER {
            for degree in 0..2 * order {
                let sum: f64 = gauss_legendre(order).iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let exact = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - exact).abs() < 1e-13, "order {order}, degree {degree}: {sum} {exact}");
            }
        }
    }
}
