//! Directed rounding from double to single precision. Invariant: `round_down(x) <= x <= round_up(x)`.

/// Unit roundoff of single precision: the largest relative error of one rounding.
pub(super) const UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// The smallest single that is not below `x`.
#[inline(always)]
pub(super) fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// The largest single that is not above `x`.
#[inline(always)]
pub(super) fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn brackets(x in prop::num::f64::NORMAL) {
            prop_assert!(f64::from(round_down(x)) <= x && x <= f64::from(round_up(x)));
        }
    }
}
