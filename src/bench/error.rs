//! Error of a picture against the reference. In go two frames, out come a few numbers, all relative to the
//! reference's mean. Invariant: a value that is not finite makes the error infinite.

use crate::film::Frame;

/// Errors over all pixels and colours, each relative to the mean of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeErrors {
    /// Root mean square.
    pub rmse: f64,
    /// Mean of the absolute values.
    pub mean_abs: f64,
    /// 99th percentile.
    pub p99: f64,
    /// The largest.
    pub max: f64,
}

impl RelativeErrors {
    /// Errors of `picture` against `reference`, two frames of one size.
    pub fn new(picture: &Frame, reference: &Frame) -> Self {
        let pairs = colors(picture).zip(colors(reference));
        let mut errors: Vec<f64> = pairs
            .map(|(found, wanted)| if found.is_finite() { (found - wanted).abs() } else { f64::INFINITY })
            .collect();
        let (count, mean) = (errors.len() as f64, mean(reference));
        let squares: f64 = errors.iter().map(|error| error * error).sum();
        Self {
            rmse: (squares / count).sqrt() / mean,
            mean_abs: errors.iter().sum::<f64>() / count / mean,
            p99: percentile(&mut errors, 0.99) / mean,
            max: errors.iter().copied().fold(0.0, f64::max) / mean,
        }
    }
}

/// Mean over all pixels and colours.
pub fn mean(frame: &Frame) -> f64 {
    let (sum, count) = colors(frame).fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// All values of the colour channels.
pub fn colors(frame: &Frame) -> impl Iterator<Item = f64> {
    let channels = ["R", "G", "B"].into_iter().filter_map(|name| frame.channel(name));
    channels.flat_map(|channel| channel.pixels.iter().map(|&value| f64::from(value)))
}

/// The smallest value that at least `share` of all values do not exceed (nearest rank);
/// `values` are reordered.
pub fn percentile(values: &mut [f64], share: f64) -> f64 {
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let rank = ((share * values.len() as f64).ceil() as usize).saturating_sub(1).min(last);
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::{Channel, Precision};
    use crate::scene::{Size, Window};

    fn frame(red: &[f32]) -> Frame {
        let full = Size { width: red.len(), height: 1 };
        let channel = |name, pixels: Vec<f32>| Channel::new(name, Precision::Float, pixels);
        let zero = vec![0.0; red.len()];
        let channels = vec![channel("R", red.to_vec()), channel("G", zero.clone()), channel("B", zero)];
        Frame { full, window: Window::whole(full), channels }
    }

    #[test]
    fn percentiles_are_nearest_ranks() {
        let mut values: Vec<f64> = (1..=200).rev().map(f64::from).collect();
        assert_eq!(percentile(&mut values, 0.99), 198.0);
        assert_eq!(percentile(&mut values, 1.0), 200.0);
        assert_eq!(percentile(&mut values, 0.0), 1.0);
        assert_eq!(percentile(&mut [7.0], 0.5), 7.0);
    }

    #[test]
    fn errors_are_relative_to_the_mean_of_the_reference() {
        // The mean over all channels is 1; the only difference is 3 in one of 12 values.
        let reference = frame(&[3.0, 3.0, 3.0, 3.0]);
        let errors = RelativeErrors::new(&frame(&[3.0, 0.0, 3.0, 3.0]), &reference);
        assert!((errors.rmse - (9.0_f64 / 12.0).sqrt()).abs() < 1e-15);
        assert!((errors.mean_abs - 0.25).abs() < 1e-15);
        assert_eq!((errors.p99, errors.max), (3.0, 3.0));
    }

    #[test]
    fn a_nan_is_no_small_error() {
        let errors = RelativeErrors::new(&frame(&[f32::NAN, 1.0]), &frame(&[1.0, 1.0]));
        assert_eq!(errors.rmse, f64::INFINITY);
    }
}
