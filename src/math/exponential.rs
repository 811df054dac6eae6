//! An exponential for inner loops. In goes a number, out comes its exponential. Invariant: no branch and no
//! table, so loops over it compile to vector instructions.

use std::f64::consts::LOG2_E;

/// ln 2 truncated after 21 bits, so that its product with an integer below 2^32 is exact, and the remainder.
const LN_2_PARTS: (f64, f64) = (0.693_146_705_627_441_4, 4.749_325_039_031_672_6e-7);

/// `exp(x)` to a relative 1e-11 for `-700 <= x <= 700`; other numbers are clamped to that range.
///
/// `x = n ln 2 + r` with `|r| <= ln 2 / 2`, so `exp(x) = 2^n exp(r)`, where `exp(r)` is a Taylor polynomial:
/// the first omitted term is `r^10 / 10!`, below 7e-12.
#[inline(always)]
pub fn fast_exp(x: f64) -> f64 {
    /// Adding it to a small number leaves the nearest integer in the last bits of the sum.
    const ROUNDER: f64 = 1.5 * (1_u64 << 52) as f64;
    let x = x.clamp(-700.0, 700.0);
    let rounded = x * LOG2_E + ROUNDER;
    let n = rounded - ROUNDER;
    let r = (x - n * LN_2_PARTS.0) - n * LN_2_PARTS.1;
    let (r2, r4) = (r * r, r * r * r * r);
    let low = (1.0 + r) + r2 * (1.0 / 2.0 + r * (1.0 / 6.0));
    let middle = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5040.0));
    let high = 1.0 / 40_320.0 + r * (1.0 / 362_880.0);
    let power_of_two = f64::from_bits((rounded.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    power_of_two * (low + r4 * (middle + r4 * high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::LN_2;

    #[test]
    fn the_parts_of_ln_2_add_up() {
        assert_eq!(LN_2_PARTS.0 + LN_2_PARTS.1, LN_2);
        assert_eq!(LN_2_PARTS.0.to_bits() & 0xffff_ffff, 0);
    }

    #[test]
    fn equals_the_exponential() {
        for step in -70_000..=70_000 {
            let x = f64::from(step) * 0.009_999;
            let relative = fast_exp(x) / x.exp() - 1.0;
            assert!(relative.abs() < 1e-11, "exp({x}): {relative:e}");
        }
        assert_eq!(fast_exp(0.0), 1.0);
        assert!(fast_exp(-1e300) < 1e-300);
    }
}
