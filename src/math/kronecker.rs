//! Additive recurrence: a sequence with well distributed runs of neighbours. In goes a number, out comes a
//! point. Invariant: the point is in `[0, 1)`.

/// The golden ratio's fractional part.
pub const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Point `number` of the sequence `frac(shift + number / g)`, with `g` the golden ratio (Roberts 2018, "The
/// unreasonable effectiveness of quasirandom sequences"); `shift` is in `[0, 1)`.
pub fn kronecker(shift: f64, number: usize) -> f64 {
    let sum = shift + number as f64 * GOLDEN;
    // Equal to `fract`, which is a function call on old processors.
    sum - sum as i64 as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The defining property of a low-discrepancy sequence: every run of `n` has about `n / 4` in each
    /// quarter.
    #[test]
    fn runs_of_neighbours_are_spread() {
        for start in (0..1000).step_by(37) {
            let mut counts = [0_i32; 4];
            for number in start..start + 64 {
                let x = kronecker(0.3, number);
                assert!((0.0..1.0).contains(&x));
                counts[(4.0 * x) as usize] += 1;
            }
            assert!(counts.iter().all(|count| (count - 16).abs() <= 2), "{start}: {counts:?}");
        }
    }

    #[test]
    fn it_is_the_golden_ratio() {
        let x = kronecker(0.0, 1);
        assert!((x - 0.618_033_988_749_894_9).abs() < 1e-15);
    }
}
