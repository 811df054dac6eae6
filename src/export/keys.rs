//! Keys of motion. In go tracks and motions, out come glTF's keys. Invariant: at every moment of the file's
//! frames they equal the motion to single precision, here (slerp) and in Blender (normalized components).
//!
//! Keys of the scene are kept where glTF and Blender interpolate alike: steps, and straight lines. Everything
//! else is sampled: at every frame, where the shutter opens and closes, and at the scene's own keys. Curves
//! are sampled with their slopes, as cubic splines: Blender ignores slopes, but has the right value at every
//! frame.

use super::deformations::is_straight;
use super::{Writer, key_times};
use crate::scene::{Animate, Extend, FrameRate, Key, RenderSettings, Segment, Track};
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ops::{Add, Mul};

pub(super) struct Moments {
    /// Time of the first frame, at which constant nodes are placed.
    pub(super) start_s: f64,
    rate: FrameRate,
    /// Increasing, none negative.
    times_s: Vec<f64>,
    /// Times as stored.
    stored_s: Vec<f32>,
    /// View of the times, once written, and accessors of parts of them.
    view: Option<usize>,
    parts: BTreeMap<(usize, usize), usize>,
}

/// Curve in glTF's form.
pub(super) struct Keys<T> {
    times: Times,
    /// Values, one a time; for cubic splines three: the slope before, the value, the slope after.
    values: Vec<T>,
    interpolation: &'static str,
}

enum Times {
    /// A part of the common moments.
    Common(usize),
    Own(Vec<f32>),
}

/// Value of a glTF channel.
pub(super) trait Stored: Animate + Add<Output = Self> + Mul<f64, Output = Self> {
    type Numbers: Copy + PartialEq;
    fn stored(self) -> Self::Numbers;
    /// Representation nearest to `previous`: a rotation has two quaternions.
    fn near(self, _previous: Self) -> Self {
        self
    }
    /// The largest difference of a component.
    fn distance(self, other: Self) -> f64;
    /// Whether glTF and Blender interpolate it linearly alike.
    const IS_LINEAR: bool = true;
}

impl Stored for DVec3 {
    type Numbers = [f32; 3];
    fn stored(self) -> [f32; 3] {
        self.as_vec3().to_array()
    }
    fn distance(self, other: Self) -> f64 {
        (self - other).abs().max_element()
    }
}

impl Stored for DQuat {
    type Numbers = [f32; 4];
    const IS_LINEAR: bool = false;
    fn stored(self) -> [f32; 4] {
        self.as_quat().to_array()
    }
    fn distance(self, other: Self) -> f64 {
        (self - other).to_array().into_iter().fold(0.0, |most, component| most.max(component.abs()))
    }
    fn near(self, previous: Self) -> Self {
        if self.dot(previous) < 0.0 { -self } else { self }
    }
}

impl Moments {
    pub(super) fn new(settings: &RenderSettings) -> Self {
        let moments = settings.frames.clone().flat_map(|frame| {
            let frame = frame as f64;
            let [open, close] = settings.shutter_around(frame);
            [open, frame, close]
        });
        let rate = settings.frame_rate;
        let times_s: Vec<f64> = moments.map(|frame| rate.seconds(frame)).collect();
        let times_s = key_times::apart(rate, &times_s, &[]);
        let start_s = rate.seconds(*settings.frames.start() as f64);
        let stored_s = times_s.iter().map(|&time_s| time_s as f32).collect();
        Self { start_s, rate, times_s, stored_s, view: None, parts: BTreeMap::new() }
    }

    /// Curve sampled at the common moments; `None` if it is constant.
    pub(super) fn sampled<T: Stored>(&self, value: impl Fn(f64) -> T) -> Option<Keys<T>> {
        sampled(&self.times_s, value).map(|(first, values)| Keys {
            times: Times::Common(first),
            values,
            interpolation: "LINEAR",
        })
    }

    /// Curve of a track; `None` if it is constant.
    pub(super) fn of_track<T: Stored>(&self, track: &Track<T>) -> Option<Keys<T>> {
        if track.is_constant() {
            return None;
        }
        if let Some(keys) = own_keys(self.rate, track) {
            return Some(keys);
        }
        if track.extend() == Extend::Cycle {
            return self.sampled(|time_s| track.at(time_s));
        }
        let times_s = self.with([track], true);
        let is_curved =
            |key: &Key<T>| matches!(key.to_next, Segment::Hermite { .. } | Segment::Bezier { .. });
        let is_curved = track.keys().iter().any(is_curved);
        let times_s = if is_curved { refined(self.rate, track, &times_s) } else { times_s };
        let (first, values) = sampled(&times_s, |time_s| track.at(time_s))?;
        let times_s = &times_s[first..first + values.len()];
        let (values, interpolation) = match is_curved {
            true => (with_slopes(track, times_s, &values), "CUBICSPLINE"),
            false => (values, "LINEAR"),
        };
        let times_s = times_s.iter().map(|&time_s| time_s as f32).collect();
        Some(Keys { times: Times::Own(times_s), values, interpolation })
    }

    /// Moments for sampling several tracks together, so that linear interpolation is exact: their keys, and
    /// the moments before jumps. If a track is curved or endless, the common moments are added.
    pub(super) fn of_tracks<'a, T: Animate + 'a>(
        &self,
        tracks: impl IntoIterator<Item = &'a Track<T>> + Clone,
    ) -> Vec<f64> {
        let all_straight = tracks.clone().into_iter().all(is_straight);
        let times_s = self.with(tracks, !all_straight);
        if times_s.is_empty() { vec![0.0] } else { times_s }
    }

    /// Keys of tracks, and the common moments if wanted.
    fn with<'a, T: Animate + 'a>(
        &self,
        tracks: impl IntoIterator<Item = &'a Track<T>>,
        common: bool,
    ) -> Vec<f64> {
        let (mut times_s, mut jumps_s) = (Vec::new(), Vec::new());
        for track in tracks {
            let (reached_s, jumped_s) = key_times::reached_and_jumped_to(track);
            times_s.extend(reached_s);
            jumps_s.extend(jumped_s);
        }
        // Added after the keys, so that a key at a frame keeps its exact time.
        if common {
            times_s.extend(&self.times_s);
        }
        key_times::apart(self.rate, &times_s, &jumps_s)
    }
}

/// Values at moments, without constant stretches at the start and the end: the index of the first, and the
/// values. `None` if they are all equal.
fn sampled<T: Stored>(times_s: &[f64], value: impl Fn(f64) -> T) -> Option<(usize, Vec<T>)> {
    let mut values: Vec<T> = Vec::with_capacity(times_s.len());
    for &time_s in times_s {
        let value = value(time_s);
        values.push(values.last().map_or(value, |&previous| value.near(previous)));
    }
    let differs = |pair: &[T]| pair[0].stored() != pair[1].stored();
    let mut first = values.windows(2).position(differs)?;
    // Blender needs the third key of a jump.
    if first > 0 && (times_s[first] as f32).next_up() == times_s[first + 1] as f32 {
        first -= 1;
    }
    let last = values.windows(2).rposition(differs)? + 1;
    Some((first, values[first..=last].to_vec()))
}

/// Times, refined until a cubic spline through values and slopes matches the track.
fn refined<T: Stored>(rate: FrameRate, track: &Track<T>, times_s: &[f64]) -> Vec<f64> {
    /// Tolerance in metres, and of a quaternion's components.
    const TOLERANCE: f64 = 1e-6;
    let shortest_s = rate.seconds(4.0 * key_times::APART_FRAMES);
    let mut refined_s = Vec::from_iter(times_s.first().copied());
    // In reverse, so that `pop` takes the next.
    let mut ahead_s: Vec<f64> = times_s.iter().skip(1).rev().copied().collect();
    while let (Some(&from_s), Some(&to_s)) = (refined_s.last(), ahead_s.last()) {
        let (way_s, middle_s) = (to_s - from_s, 0.5 * (from_s + to_s));
        let from = track.at(from_s);
        let to = track.at(to_s).near(from);
        let ends = [from, slope(track, from, from_s, to_s), to, slope(track, to, to_s, from_s)];
        let middle = T::blend(ends, [0.5, 0.125 * way_s, 0.5, -0.125 * way_s]);
        if way_s < shortest_s || middle.distance(track.at(middle_s).near(middle)) <= TOLERANCE {
            refined_s.push(to_s);
            ahead_s.pop();
        } else {
            ahead_s.push(middle_s);
        }
    }
    refined_s
}

/// Values with their slopes before and after, per second.
fn with_slopes<T: Stored>(track: &Track<T>, times_s: &[f64], values: &[T]) -> Vec<T> {
    let slope = |from: usize, to: usize| slope(track, values[from], times_s[from], times_s[to]);
    let last = values.len() - 1;
    let with_slopes = |at: usize| {
        let arrive = if at == 0 { T::ZERO } else { slope(at, at - 1) };
        [arrive, values[at], if at == last { T::ZERO } else { slope(at, at + 1) }]
    };
    (0..values.len()).flat_map(with_slopes).collect()
}

/// Slope of a track at a value in the direction of another time, from three values (Abramowitz & Stegun
/// 25.3.4).
fn slope<T: Stored>(track: &Track<T>, value: T, from_s: f64, to_s: f64) -> T {
    const LONGEST_STEP_S: f64 = 1e-4;
    // A jump has no slope.
    const JUMP_S: f64 = 1e-6;
    let way_s = to_s - from_s;
    if way_s.abs() < JUMP_S {
        return T::ZERO;
    }
    let step_s = (way_s / 4.0).clamp(-LONGEST_STEP_S, LONGEST_STEP_S);
    let [near, far] = [1.0, 2.0].map(|steps| track.at(from_s + steps * step_s).near(value));
    (value * -1.5 + near * 2.0 + far * -0.5) * step_s.recip()
}

/// Keys of the track itself, if glTF and Blender interpolate them alike.
fn own_keys<T: Stored>(rate: FrameRate, track: &Track<T>) -> Option<Keys<T>> {
    let keys = track.keys();
    let segments = || keys[..keys.len() - 1].iter().map(|key| key.to_next);
    let are_steps = segments().all(|segment| matches!(segment, Segment::Step));
    let are_straight = T::IS_LINEAR && segments().all(|segment| matches!(segment, Segment::Linear));
    // A step that is rounded up would come a frame late in Blender.
    let time = |time_s: f64| {
        let rounded = time_s as f32;
        if are_steps && rounded > 0.0 { rounded.next_down() } else { rounded }
    };
    let usable = keys[0].time_s >= 0.0 && key_times::are_apart(rate, &track.times_s());
    if !(are_steps || are_straight) || track.extend() == Extend::Cycle || !usable {
        return None;
    }
    let times = keys.iter().map(|key| time(key.time_s)).collect();
    let mut values: Vec<T> = Vec::with_capacity(keys.len());
    for key in keys {
        values.push(values.last().map_or(key.value, |&previous| key.value.near(previous)));
    }
    Some(Keys { times: Times::Own(times), values, interpolation: if are_steps { "STEP" } else { "LINEAR" } })
}

impl Writer<'_> {
    /// Adds a channel that animates a node's property.
    pub(super) fn add_channel<T: Stored<Numbers = [f32; WIDTH]>, const WIDTH: usize>(
        &mut self,
        node: usize,
        path: &str,
        keys: Option<Keys<T>>,
    ) {
        let Some(Keys { times, values, interpolation }) = keys else { return };
        let input = match times {
            Times::Common(first) => self.common_times(first, values.len()),
            Times::Own(times_s) => {
                let times_s: Vec<[f32; 1]> = times_s.into_iter().map(|time_s| [time_s]).collect();
                self.binary.floats(&times_s, None, true)
            }
        };
        let values: Vec<[f32; WIDTH]> = values.into_iter().map(Stored::stored).collect();
        let output = self.binary.floats(&values, None, false);
        self.samplers.push(json!({ "input": input, "output": output, "interpolation": interpolation }));
        let target: Value = json!({ "node": node, "path": path });
        self.channels.push(json!({ "sampler": self.samplers.len() - 1, "target": target }));
    }

    fn common_times(&mut self, first: usize, count: usize) -> usize {
        let Self { moments: Moments { stored_s, view, parts, .. }, binary, .. } = self;
        let all = || binary.view(stored_s.iter().flat_map(|time_s| time_s.to_le_bytes()), None);
        let view = *view.get_or_insert_with(all);
        let part = || binary.part_of_times(view, &stored_s[first..first + count], first);
        *parts.entry((first, count)).or_insert_with(part)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn moments() -> Moments {
        Moments::new(&RenderSettings { frames: 1..=4, ..RenderSettings::default() })
    }

    #[test]
    fn what_rests_has_no_keys_and_what_comes_to_rest_has_none_after() {
        let moments = moments();
        assert!(moments.sampled(|_| DVec3::X).is_none());
        let stops_at_frame_2 = moments.sampled(|time_s| DVec3::X * time_s.min(2.0 / 24.0)).unwrap();
        assert!(matches!(stops_at_frame_2.times, Times::Common(0)));
        assert_eq!(stops_at_frame_2.values.len(), 2);
        let starts_at_frame_3 = moments.sampled(|time_s| DVec3::X * time_s.max(3.0 / 24.0)).unwrap();
        assert!(matches!(starts_at_frame_3.times, Times::Common(2)));
    }

    #[test]
    fn sampled_turns_do_not_jump_to_the_other_form_of_the_quaternion() {
        let turning = |time_s: f64| DQuat::from_rotation_y(40.0 * time_s);
        let keys = moments().sampled(turning).unwrap();
        assert!(keys.values.windows(2).all(|pair| pair[0].dot(pair[1]) > 0.0));
    }

    #[test]
    fn steps_are_not_rounded_to_after_their_frame() {
        let key = |frame: f64, value| Key { time_s: frame / 24.0, value, to_next: Segment::Step };
        let track = Track::new(vec![key(0.0, DVec3::ZERO), key(13.0, DVec3::X)], Extend::Hold).unwrap();
        let Times::Own(times_s) =
            own_keys(FrameRate { numerator: 24, denominator: 1 }, &track).unwrap().times
        else {
            panic!()
        };
        assert!(f64::from(times_s[1]) <= 13.0 / 24.0 && f64::from(times_s[1]) > 12.999 / 24.0);
    }
}
