//! Sum in five bytes, as a film holds several for each pixel. In go doubles, out comes their sum. Invariant:
//! zero bytes are a sum of nothing.
//!
//! A double's upper 40 bits have 29 binary digits. An addition errs by at most `2^-29` of the sum, and so the
//! mean of 65,536 samples by less than `1.3e-4`: a quarter of what a half-precision channel rounds away.

/// The upper bytes of a double, the lowest first.
pub(super) type PixelSum = [u8; 5];

/// Maximum difference of a pixel's halves by rounding, relative to the pixel's sum: an addition errs by at
/// most `2^-29` of the sum, in colours and weights, of all samples and of one half.
pub(super) const ROUNDING: f64 = 4.0 / (1 << 29) as f64;

/// Half a unit of the last digit that is kept, as the bits of a double.
const HALF_A_UNIT: u64 = 1 << 23;

pub(super) fn value(&[a, b, c, d, e]: &PixelSum) -> f64 {
    f64::from_bits(u64::from_le_bytes([0, 0, 0, a, b, c, d, e]))
}

pub(super) fn add(sum: &mut PixelSum, added: f64) {
    let [_, _, _, upper @ ..] = ((value(sum) + added).to_bits() + HALF_A_UNIT).to_le_bytes();
    *sum = upper;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(values: impl IntoIterator<Item = f64>) -> f64 {
        let mut sum = PixelSum::default();
        values.into_iter().for_each(|value| add(&mut sum, value));
        value(&sum)
    }

    #[test]
    fn whole_numbers_are_exact_and_what_is_no_number_stays() {
        assert_eq!(sum([]), 0.0);
        assert_eq!(sum([f64::from(1 << 28), 1.0, -3.0]), f64::from((1 << 28) - 2));
        assert!(sum([1.0, f64::NAN, 1.0]).is_nan());
        assert_eq!(sum([1.0, f64::NEG_INFINITY]), f64::NEG_INFINITY);
    }

    #[test]
    fn many_equal_samples_keep_their_mean() {
        for each in [0.3, 1.0 / 3.0, 0.7] {
            let mean = sum(std::iter::repeat_n(each, 1 << 16)) / f64::from(1 << 16);
            assert!((mean / each - 1.0).abs() < 1.3e-4, "{mean} of {each}");
        }
    }
}
