//! Cost of an error, and growth of a cost. In go measured points, out come times at error levels and
//! exponents. Invariant: all is linear in logarithms between measured points; answers beyond them are marked
//! as such.

/// Time to reach an error, seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost {
    /// Interpolated between two measured points.
    Measured(f64),
    /// Upper bound: the cheapest point has a smaller error.
    AtMost(f64),
    /// Extrapolated beyond the most expensive point, by a straight line through the last points.
    Extrapolated(f64),
    /// More effort does not help, or there are too few points.
    Unknown,
}

impl Cost {
    /// Seconds, if there is a time.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::Measured(seconds) | Self::AtMost(seconds) | Self::Extrapolated(seconds) => Some(seconds),
            Self::Unknown => None,
        }
    }
}

/// Pareto front: the points (seconds, error) that no other point beats in both, cheapest first.
pub fn front(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut points: Vec<_> =
        points.iter().copied().filter(|&(seconds, error)| seconds > 0.0 && error > 0.0).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut best = f64::INFINITY;
    points.retain(|&(_, error)| {
        let better = error < best;
        best = best.min(error);
        better
    });
    points
}

/// Time at which a [`front`] reaches `error`.
pub fn cost_of(front: &[(f64, f64)], error: f64) -> Cost {
    let (Some(&first), Some(&last)) = (front.first(), front.last()) else { return Cost::Unknown };
    if first.1 <= error {
        return Cost::AtMost(first.0);
    }
    if let Some(pair) = front.windows(2).find(|pair| pair[1].1 <= error) {
        let ((t0, e0), (t1, e1)) = (pair[0], pair[1]);
        let share = (error / e0).ln() / (e1 / e0).ln();
        return Cost::Measured(t0 * (t1 / t0).powf(share));
    }
    let tail = &front[front.len().saturating_sub(4)..];
    let times_and_errors: Vec<_> = tail.iter().map(|&(seconds, error)| (error, seconds)).collect();
    match PowerLaw::fit(&times_and_errors) {
        Some(law) if law.exponent < 0.0 => Cost::Extrapolated(last.0 * (error / last.1).powf(law.exponent)),
        _ => Cost::Unknown,
    }
}

/// `y = factor * x^exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// y at x = 1.
    pub factor: f64,
    /// Slope in logarithms.
    pub exponent: f64,
    /// Standard error; infinite for two points.
    pub standard_error: f64,
}

impl PowerLaw {
    /// Least squares in logarithms through points (x, y), all positive; `None` if x does not vary.
    pub fn fit(points: &[(f64, f64)]) -> Option<Self> {
        let count = points.len() as f64;
        let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
        let mean_x = logs.iter().map(|log| log.0).sum::<f64>() / count;
        let mean_y = logs.iter().map(|log| log.1).sum::<f64>() / count;
        let xx: f64 = logs.iter().map(|log| (log.0 - mean_x).powi(2)).sum();
        let xy: f64 = logs.iter().map(|log| (log.0 - mean_x) * (log.1 - mean_y)).sum();
        let exponent = xy / xx;
        let rest: f64 = logs.iter().map(|log| (log.1 - mean_y - exponent * (log.0 - mean_x)).powi(2)).sum();
        let standard_error =
            if points.len() > 2 { (rest / (count - 2.0) / xx).sqrt() } else { f64::INFINITY };
        let factor = (mean_y - exponent * mean_x).exp();
        (exponent.is_finite() && factor.is_finite()).then_some(Self { factor, exponent, standard_error })
    }

    /// y at x.
    pub fn at(&self, x: f64) -> f64 {
        self.factor * x.powf(self.exponent)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_front_has_only_points_that_are_worth_their_time() {
        let points = [(4.0, 0.1), (1.0, 0.5), (2.0, 0.6), (2.0, 0.3), (8.0, 0.1), (3.0, 0.0)];
        assert_eq!(front(&points), [(1.0, 0.5), (2.0, 0.3), (4.0, 0.1)]);
    }

    #[test]
    fn costs_are_read_off_straight_lines_in_logarithms() {
        // error = 1 / t, in three points.
        let front = [(1.0, 1.0), (10.0, 0.1), (100.0, 0.01)];
        let seconds = |error| cost_of(&front, error);
        assert_eq!(seconds(2.0), Cost::AtMost(1.0));
        let Cost::Measured(between) = seconds(0.05) else { panic!("{:?}", seconds(0.05)) };
        assert!((between - 20.0).abs() < 1e-12);
        let Cost::Extrapolated(beyond) = seconds(0.001) else { panic!("{:?}", seconds(0.001)) };
        assert!((beyond - 1000.0).abs() < 1e-9);
        assert_eq!(cost_of(&front[..1], 0.5), Cost::Unknown);
        assert_eq!(cost_of(&[], 0.5), Cost::Unknown);
    }

    proptest! {
        /// Noise of known size shows as the textbook's standard error.
        #[test]
        fn a_fit_finds_the_law_and_its_own_error(exponent in -3.0..3.0_f64, factor in 0.01..100.0_f64, bump in 0.0..0.3_f64) {
            let x = [1.0, 10.0, 100.0, 1000.0_f64];
            // This residual has no mean and no slope: it changes neither factor nor exponent.
            let residual = [1.0, -1.0, -1.0, 1.0].map(|sign: f64| sign * bump);
            let points: Vec<_> = (0..4).map(|i| (x[i], factor * x[i].powf(exponent) * residual[i].exp())).collect();
            let law = PowerLaw::fit(&points).unwrap();
            prop_assert!((law.exponent - exponent).abs() < 1e-9);
            prop_assert!((law.factor / factor - 1.0).abs() < 1e-9);
            // sum of squares 4 bump^2 over 2 degrees of freedom; sum of (ln x - mean)^2 = 5 ln(10)^2.
            let expected = (2.0 * bump * bump / 5.0).sqrt() / 10.0_f64.ln();
            prop_assert!((law.standard_error - expected).abs() < 1e-9);
            prop_assert!((law.at(7.0) / (factor * 7.0_f64.powf(exponent)) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn one_place_has_no_slope() {
        assert_eq!(PowerLaw::fit(&[(1.0, 1.0), (1.0, 2.0)]), None);
        assert_eq!(PowerLaw::fit(&[(1.0, 1.0)]), None);
        assert_eq!(PowerLaw::fit(&[(1.0, 1.0), (2.0, 4.0)]).unwrap().standard_error, f64::INFINITY);
    }
}
