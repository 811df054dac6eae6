//! Limits on the difference of two frames. In go a comparison and limits, out come sentences. Invariants:
//! each channel has one limit for each measure: that of the last pattern that matches, else the general one.
//! A pattern that matches no channel is exceeded.

use super::{Comparison, Errors};
use glob::Pattern;

/// Measure of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// [`Errors::rmse`].
    Rmse,
    /// [`Errors::relative_mse`].
    RelativeMse,
    /// [`Errors::max_error`].
    MaxError,
    /// Share of different ids.
    Ids,
}

/// Maximum difference of two frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Limit {
    /// Measure.
    pub measure: Measure,
    /// Pattern of channels, each checked by itself. Without a pattern: red, green and blue together, and
    /// every other channel.
    pub channels: Option<Pattern>,
    /// Maximum.
    pub most: f64,
}

/// Sentence for each limit that is exceeded, or has nothing to measure.
pub fn exceeded(found: &Comparison, limits: &[Limit]) -> Vec<String> {
    let is_light = |name: &str| name == "Y" || !is_data(name);
    let is_finite = found.channels.iter().all(|of| of.errors.not_finite == 0 || !is_light(&of.name));
    let not_finite = (!is_finite && !limits.is_empty()).then(|| String::from("values are not finite"));
    let of_measures = [Measure::Rmse, Measure::RelativeMse, Measure::MaxError, Measure::Ids]
        .into_iter()
        .flat_map(|measure| of_measure(measure, found, limits));
    not_finite.into_iter().chain(of_measures).collect()
}

/// Whether a channel is a component of positions, directions or distances, which may be infinite.
fn is_data(name: &str) -> bool {
    let component = name.rsplit('.').next().unwrap_or(name);
    ["X", "Y", "Z", "W", "U", "V"].iter().any(|data| component.eq_ignore_ascii_case(data))
}

fn of_measure(measure: Measure, found: &Comparison, limits: &[Limit]) -> Vec<String> {
    let limits: Vec<&Limit> = limits.iter().rev().filter(|limit| limit.measure == measure).collect();
    let for_all = limits.iter().find(|limit| limit.channels.is_none()).map(|limit| limit.most);
    let (label, values) = (measure.label(), measure.of_channels(found));
    let color = found.color.as_ref().and_then(|errors| measure.of(errors));
    let mut sentences = Vec::new();
    match (color, for_all) {
        (Some(color), Some(most)) => sentences.extend(too_much(label, color, most)),
        (None, Some(most)) if values.is_empty() => {
            sentences.push(format!("{label} unknown, allowed {most}"));
        }
        _ => {}
    }
    let names = |limit: &Limit, name: &str| limit.channels.as_ref().is_some_and(|named| named.matches(name));
    for (name, value) in &values {
        let is_of_color = color.is_some() && ["R", "G", "B"].contains(name);
        let own = limits.iter().find(|limit| names(limit, name)).map(|limit| limit.most);
        if let Some(most) = own.or(for_all.filter(|_| !is_of_color)) {
            sentences.extend(too_much(&format!("{label} of {name}"), *value, most));
        }
    }
    let in_vain = limits.iter().rev().filter(|limit| values.iter().all(|(name, _)| !names(limit, name)));
    let patterns = in_vain.filter_map(|limit| limit.channels.as_ref());
    sentences.extend(patterns.map(|pattern| format!("no channel that both have is named {pattern}")));
    sentences
}

fn too_much(what: &str, value: f64, most: f64) -> Option<String> {
    // NaN exceeds any limit.
    let is_kept = value <= most;
    (!is_kept).then(|| format!("{what} {value:.3e}, allowed {most}"))
}

impl Measure {
    fn label(self) -> &'static str {
        match self {
            Self::Rmse => "RMSE",
            Self::RelativeMse => "relative mean square error",
            Self::MaxError => "largest difference",
            Self::Ids => "share of ids that differ",
        }
    }

    fn of(self, errors: &Errors) -> Option<f64> {
        match self {
            Self::Rmse => Some(errors.rmse),
            Self::RelativeMse => Some(errors.relative_mse),
            // No value is finite in both frames, so none was compared.
            Self::MaxError if errors.values == 0 => Some(f64::NAN),
            Self::MaxError => Some(errors.max_error),
            Self::Ids => None,
        }
    }

    fn of_channels(self, found: &Comparison) -> Vec<(&str, f64)> {
        let amounts = found.channels.iter();
        let amounts = amounts.filter_map(|of| Some((of.name.as_str(), self.of(&of.errors)?)));
        let share = |different: usize, of: usize| different as f64 / of as f64;
        let ids = found.ids.iter().filter(|_| self == Self::Ids);
        amounts.chain(ids.map(|of| (of.name.as_str(), share(of.different, of.values)))).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::film::{Channel, Frame, Precision};
    use crate::frame_file::compare;
    use crate::scene::{Size, Window};

    /// Two pixels; each channel differs by so much in both.
    fn found(channels: &[(&str, f32)]) -> Comparison {
        let size = Size { width: 2, height: 1 };
        let frame = |value: &dyn Fn(f32) -> f32| Frame {
            full: size,
            window: Window::whole(size),
            channels: channels
                .iter()
                .map(|&(name, apart)| Channel::new(name, Precision::Float, vec![value(apart); 2]))
                .collect(),
        };
        compare(&frame(&|apart| 1.0 + apart), &frame(&|_| 1.0)).unwrap()
    }

    fn limit(measure: Measure, channels: &str, most: f64) -> Limit {
        let channels = (!channels.is_empty()).then(|| Pattern::new(channels).unwrap());
        Limit { measure, channels, most }
    }

    #[test]
    fn colours_count_together_and_every_other_channel_by_itself() {
        let found = found(&[("R", 0.3), ("G", 0.0), ("B", 0.0), ("diffuse.R", 0.25), ("depth.Z", 0.125)]);
        let over = |most| exceeded(&found, &[limit(Measure::Rmse, "", most)]);
        // sqrt(0.3^2 / 3) = 0.173
        assert_eq!(over(0.26), [""; 0]);
        assert_eq!(over(0.2), ["RMSE of diffuse.R 2.500e-1, allowed 0.2"]);
        assert_eq!(over(0.17).len(), 2);
        assert_eq!(over(0.1).len(), 3);
        assert!(exceeded(&found, &[]).is_empty());
    }

    #[test]
    fn the_last_pattern_that_names_a_channel_counts() {
        let found = found(&[("diffuse.R", 0.25), ("diffuse.G", 0.25), ("Z", 0.5)]);
        let over = |limits: &[(&str, f64)]| {
            let limits: Vec<_> =
                limits.iter().map(|(names, most)| limit(Measure::MaxError, names, *most)).collect();
            exceeded(&found, &limits).len()
        };
        assert_eq!(over(&[("", 0.1)]), 3);
        assert_eq!(over(&[("", 0.1), ("diffuse.*", f64::INFINITY)]), 1);
        assert_eq!(over(&[("diffuse.*", 0.1), ("", 1.0)]), 2);
        assert_eq!(over(&[("diffuse.*", 0.1), ("*.G", 1.0)]), 1);
        assert_eq!(over(&[("diffuse.[RG]", 0.1), ("?", 0.1)]), 3);
        assert_eq!(over(&[("specular.*", 1.0)]), 1, "a pattern that names none is not kept");
    }

    #[test]
    fn ids_have_a_share_that_may_differ() {
        let found = found(&[("leaf_id.X", 1.0), ("R", 0.0)]);
        assert_eq!(exceeded(&found, &[limit(Measure::Ids, "", 0.5)]).len(), 1);
        assert!(exceeded(&found, &[limit(Measure::Ids, "", 1.0)]).is_empty());
        assert!(exceeded(&found, &[limit(Measure::MaxError, "", 0.1)]).is_empty());
    }

    #[test]
    fn light_that_is_not_finite_keeps_no_limit() {
        for (name, sentences) in [("R", 2), ("diffuse.A", 2), ("depth.Z", 1)] {
            let found = found(&[(name, f32::NAN)]);
            assert_eq!(exceeded(&found, &[limit(Measure::MaxError, "", 1.0)]).len(), sentences, "{name}");
        }
    }
}
