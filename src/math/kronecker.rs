//! Additive recurrences: points of which any run of neighbours is well spread. In goes a number,
//! out comes a point. Invariant: every coordinate is in `[0, 1)`.

/// Point `number` of the sequence `frac(shift + number / g^k)`, with `g` the positive root of
/// `g^(D + 1) = g + 1`: the golden ratio in one dimension, its like in more (Roberts 2018, "The
/// unreasonable effectiveness of quasirandom sequences").
pub fn kronecker<const D: usize>(shift: [f64; D], number: usize) -> [f64; D] {
    let mut root = 1.5_f64;
    for _ in 0..32 {
        root = (root + 1.0).powf(1.0 / (D as f64 + 1.0));
    }
    let mut power = 1.0;
    shift.map(|shift| {
        power /= root;
        (shift + (number as f64 * power).fract()).fract()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The defining property of a low-discrepancy sequence: every run of `n` has about `n / 4` in each quadrant.
    #[test]
    fn runs_of_neighbours_are_spread() {
        for start in (0..1000).step_by(37) {
            let mut counts = [0_i32; 4];
            for number in start..start + 64 {
                let [x, y] = kronecker([0.3, 0.9], number);
                assert!((0.0..1.0).contains(&x) && (0.0..1.0).contains(&y));
                counts[2 * usize::from(x >= 0.5) + usize::from(y >= 0.5)] += 1;
            }
            assert!(counts.iter().all(|count| (count - 16).abs() <= 4), "{start}: {counts:?}");
        }
    }

    #[test]
    fn one_dimension_is_the_golden_ratio() {
        let [x] = kronecker([0.0], 1);
        assert!((x - 0.618_033_988_749_894_9).abs() < 1e-15);
    }
}
