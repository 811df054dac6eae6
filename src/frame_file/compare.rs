//! Comparison of two frames. In go frames, out come errors by channel. Invariant: values that are not finite
//! are counted apart, and are in no mean.

use crate::film::{Channel, Frame, PixelPlace};
use crate::scene::Window;
use std::fmt;

/// Difference of one frame from another.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Errors over R, G and B together, if both frames have them.
    pub color: Option<Errors>,
    /// Errors of each channel of amounts in both frames, in the output's order.
    pub channels: Vec<ChannelErrors>,
    /// Errors of each channel of ids in both frames, in the output's order.
    pub ids: Vec<IdErrors>,
    /// Channels in only one of the frames.
    pub unmatched: Vec<String>,
}

/// Errors of one channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelErrors {
    /// The channel.
    pub name: String,
    /// Errors.
    pub errors: Errors,
}

/// Errors of an output o against a reference r, over all values that are finite in both.
#[derive(Clone, Debug, PartialEq)]
pub struct Errors {
    /// mean(o) / mean(r), which first shows wrong units, phase functions or transmittance. NaN where r is
    /// black.
    pub mean_ratio: f64,
    /// sqrt(mean((o - r)^2)).
    pub rmse: f64,
    /// mean((o - r)^2 / (r^2 + (0.1 mean(r))^2)).
    pub relative_mse: f64,
    /// The largest |o - r|.
    pub max_error: f64,
    /// Place of that error; `None` if both are equal.
    pub max_error_at: Option<PixelPlace>,
    /// Number of values that are NaN or infinite in either frame, except equal infinities.
    pub not_finite: usize,
    /// Number of compared values.
    pub values: usize,
}

/// Differences of a channel of ids.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdErrors {
    /// The channel.
    pub name: String,
    /// Number of different pixels.
    pub different: usize,
    /// First different pixel, by row, then column.
    pub first: Option<PixelPlace>,
    /// Number of compared pixels.
    pub values: usize,
}

/// Reason why two frames cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The pictures differ in size.
    #[error("the pictures differ in size: {0} x {1} against {2} x {3} pixels")]
    Size(usize, usize, usize, usize),
    /// The data windows have no common pixel.
    #[error("the two crops have no pixel in common")]
    NoCommonPixel,
    /// The frames have no common channel.
    #[error("the two pictures have no channel in common")]
    NoCommonChannel,
}

/// RMSE without the reference's noise, whose standard error (root mean square over the picture) is known.
pub fn net_rmse(rmse: f64, reference_standard_error: f64) -> f64 {
    (rmse * rmse - reference_standard_error * reference_standard_error).max(0.0).sqrt()
}

/// Compares the channels and pixels that two frames have in common.
///
/// # Errors
/// If there are none, or the full pictures differ in size.
pub fn compare(output: &Frame, reference: &Frame) -> Result<Comparison, CompareError> {
    let (a, b) = (output.full, reference.full);
    if a != b {
        return Err(CompareError::Size(a.width, a.height, b.width, b.height));
    }
    let window = intersection(output.window, reference.window).ok_or(CompareError::NoCommonPixel)?;
    let pairs: Vec<(&Channel, &Channel)> = output
        .channels
        .iter()
        .filter_map(|channel| Some((channel, reference.channel(&channel.name)?)))
        .collect();
    if pairs.is_empty() {
        return Err(CompareError::NoCommonChannel);
    }
    let errors = |pairs: &[(&Channel, &Channel)]| errors(window, output.window, reference.window, pairs);
    let color: Vec<_> = pairs
        .iter()
        .copied()
        .filter(|(channel, _)| ["R", "G", "B"].contains(&channel.name.as_str()))
        .collect();
    let only_in = |one: &Frame, other: &Frame| -> Vec<String> {
        let missing = one.channels.iter().filter(|channel| other.channel(&channel.name).is_none());
        missing.map(|channel| channel.name.clone()).collect()
    };
    let (id_pairs, pairs): (Vec<_>, Vec<_>) = pairs.into_iter().partition(|(channel, _)| channel.holds_ids());
    Ok(Comparison {
        color: (color.len() == 3).then(|| errors(&color)),
        channels: pairs
            .iter()
            .map(|&pair| ChannelErrors { name: pair.0.name.clone(), errors: errors(&[pair]) })
            .collect(),
        ids: id_pairs
            .into_iter()
            .map(|pair| id_errors(window, output.window, reference.window, pair))
            .collect(),
        unmatched: [only_in(output, reference), only_in(reference, output)].concat(),
    })
}

/// Intersection of two windows.
pub(super) fn intersection(a: Window, b: Window) -> Option<Window> {
    let (x, y) = (a.x.max(b.x), a.y.max(b.y));
    let right = (a.x + a.width).min(b.x + b.width);
    let bottom = (a.y + a.height).min(b.y + b.height);
    (x < right && y < bottom).then(|| Window { x, y, width: right - x, height: bottom - y })
}

fn errors(window: Window, output: Window, reference: Window, pairs: &[(&Channel, &Channel)]) -> Errors {
    let values = || {
        pairs.iter().flat_map(move |&(o, r)| {
            window.pixels().filter_map(move |(x, y)| {
                let (o_index, r_index) = (output.index(x, y)?, reference.index(x, y)?);
                Some((f64::from(o.pixels[o_index]), f64::from(r.pixels[r_index]), &o.name, x, y))
            })
        })
    };
    let (mut count, mut not_finite, mut sum_o, mut sum_r) = (0_usize, 0, 0.0, 0.0);
    for (o, r, ..) in values() {
        if o.is_finite() && r.is_finite() {
            count += 1;
            sum_o += o;
            sum_r += r;
        } else if o != r {
            not_finite += 1;
        }
    }
    let floor = (0.1 * sum_r / count as f64).powi(2);
    let (mut squares, mut relative_squares, mut max_error, mut max_error_at) = (0.0, 0.0, 0.0, None);
    for (o, r, name, x, y) in values().filter(|(o, r, ..)| o.is_finite() && r.is_finite()) {
        let error = (o - r).abs();
        if error == 0.0 {
            // Avoids 0 / 0 where both are black.
            continue;
        }
        squares += error * error;
        relative_squares += error * error / (r * r + floor);
        if error > max_error {
            max_error = error;
            max_error_at = Some(PixelPlace { channel: name.clone(), x, y });
        }
    }
    Errors {
        mean_ratio: sum_o / sum_r,
        rmse: (squares / count as f64).sqrt(),
        relative_mse: relative_squares / count as f64,
        max_error,
        max_error_at,
        not_finite,
        values: count,
    }
}

fn id_errors(window: Window, output: Window, reference: Window, (o, r): (&Channel, &Channel)) -> IdErrors {
    let (mut different, mut first) = (0, None);
    for (x, y) in window.pixels() {
        let ids = output.index(x, y).zip(reference.index(x, y));
        // By bits, as some ids are NaN.
        if ids.is_some_and(|(of_o, of_r)| o.pixels[of_o].to_bits() != r.pixels[of_r].to_bits()) {
            different += 1;
            first.get_or_insert_with(|| PixelPlace { channel: o.name.clone(), x, y });
        }
    }
    IdErrors { name: o.name.clone(), different, first, values: window.width * window.height }
}

impl fmt::Display for IdErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} ids differ", self.different, self.values)?;
        if let Some(place) = &self.first {
            write!(f, ", first at {}, {}", place.x, place.y)?;
        }
        Ok(())
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.values == 0 {
            return write!(f, "not finite {}", self.not_finite);
        }
        // A black reference has no ratio.
        if self.mean_ratio.is_finite() {
            write!(f, "mean ratio {:.6}  ", self.mean_ratio)?;
        }
        write!(f, "RMSE {:.6}  ", self.rmse)?;
        if self.relative_mse.is_finite() {
            write!(f, "relMSE {:.3e}  ", self.relative_mse)?;
        }
        write!(f, "max {:.6}", self.max_error)?;
        if let Some(place) = &self.max_error_at {
            write!(f, " at {}, {} in {}", place.x, place.y, place.channel)?;
        }
        if self.not_finite > 0 {
            write!(f, "  not finite {}", self.not_finite)?;
        }
        Ok(())
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.channels.iter().map(|channel| &channel.name);
        let names = names.chain(self.ids.iter().map(|channel| &channel.name)).map(String::len);
        let width = names.max().unwrap_or(0).max(3);
        if let Some(color) = &self.color {
            writeln!(f, "{:width$}  {color}", "RGB")?;
        }
        for channel in &self.channels {
            writeln!(f, "{:width$}  {}", channel.name, channel.errors)?;
        }
        for channel in &self.ids {
            writeln!(f, "{:width$}  {channel}", channel.name)?;
        }
        if !self.unmatched.is_empty() {
            writeln!(f, "only in one of the two: {}", self.unmatched.join(", "))?;
        }
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::Precision;
    use crate::scene::Size;

    fn frame(window: Window, name: &str, pixels: &[f32]) -> Frame {
        let channels = vec![Channel::new(name, Precision::Float, pixels.to_vec())];
        Frame { full: Size { width: 4, height: 1 }, window, channels }
    }

    const WHOLE: Window = Window { x: 0, y: 0, width: 4, height: 1 };

    #[test]
    fn measures_are_what_their_formulas_say() {
        let reference = frame(WHOLE, "R", &[1.0, 2.0, 3.0, 4.0]);
        let output = frame(WHOLE, "R", &[1.0, 2.0, 3.0, 6.0]);
        let comparison = compare(&output, &reference).unwrap();
        let errors = &comparison.channels[0].errors;
        assert!((errors.mean_ratio - 1.2).abs() < 1e-12);
        assert!((errors.rmse - 1.0).abs() < 1e-12);
        assert!((errors.relative_mse - 1.0 / 16.0625).abs() < 1e-12);
        assert_eq!(errors.max_error, 2.0);
        assert_eq!(errors.max_error_at, Some(PixelPlace { channel: String::from("R"), x: 3, y: 0 }));
        assert_eq!(comparison.color, None);
    }

    #[test]
    fn nan_counts_and_enters_no_mean() {
        let reference = frame(WHOLE, "R", &[1.0, f32::INFINITY, 3.0, 4.0]);
        let output = frame(WHOLE, "R", &[1.0, f32::INFINITY, f32::NAN, 4.0]);
        let errors = &compare(&output, &reference).unwrap().channels[0].errors;
        assert_eq!((errors.not_finite, errors.values, errors.rmse), (1, 2, 0.0));
        assert_eq!(errors.mean_ratio, 1.0);
    }

    /// The bits of two of these ids are those of NaN and of a number next to another.
    #[test]
    fn a_black_reference_has_no_ratio() {
        for (output, said) in [
            ([0.0; 4], "R    RMSE 0.000000  relMSE 0.000e0  max 0.000000"),
            ([f32::NAN; 4], "R    not finite 4"),
        ] {
            let comparison = compare(&frame(WHOLE, "R", &output), &frame(WHOLE, "R", &[0.0; 4])).unwrap();
            assert_eq!(comparison.to_string().trim_end(), said);
        }
    }

    #[test]
    fn ids_are_equal_or_not() {
        let ids = [0, 7, 0x7fc0_0001, 0x3f80_0000].map(f32::from_bits);
        let others = [0, 7, 0x7fc0_0002, 0x3f80_0001].map(f32::from_bits);
        let name = "CryptoObject00.R";
        let ids_differ = |output: &[f32]| {
            let comparison = compare(&frame(WHOLE, name, output), &frame(WHOLE, name, &ids)).unwrap();
            assert_eq!(comparison.channels, []);
            comparison.ids[0].clone()
        };
        assert_eq!(ids_differ(&ids).different, 0);
        let found = ids_differ(&others);
        assert_eq!(found.first, Some(PixelPlace { channel: String::from(name), x: 2, y: 0 }));
        assert_eq!(found.to_string(), "2 of 4 ids differ, first at 2, 0");
    }

    #[test]
    fn crops_are_compared_where_they_overlap() {
        let reference = frame(WHOLE, "R", &[1.0, 2.0, 3.0, 4.0]);
        let output = frame(Window { x: 2, y: 0, width: 2, height: 1 }, "R", &[3.0, 4.5]);
        let errors = &compare(&output, &reference).unwrap().channels[0].errors;
        assert_eq!(errors.values, 2);
        assert_eq!(errors.max_error, 0.5);
    }

    #[test]
    fn nothing_in_common_is_an_error() {
        let reference = frame(WHOLE, "R", &[0.0; 4]);
        assert_eq!(compare(&frame(WHOLE, "Z", &[0.0; 4]), &reference), Err(CompareError::NoCommonChannel));
        let mut larger = reference.clone();
        larger.full.width = 5;
        assert_eq!(compare(&larger, &reference), Err(CompareError::Size(5, 1, 4, 1)));
    }

    #[test]
    fn noise_of_the_reference_is_taken_out() {
        assert!((net_rmse(5.0, 3.0) - 4.0).abs() < 1e-12);
        assert_eq!(net_rmse(1.0, 3.0), 0.0);
    }
}
