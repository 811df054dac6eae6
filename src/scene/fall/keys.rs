//! Reduction of poses to keys. In go poses, out come few keys. Invariant: between keys, the curves pass every
//! pose within the tolerance.

use super::leaf::Pose;
use crate::scene::{Animate, SmoothKey, Track};
use glam::{DQuat, DVec3};

/// Maximum number of poses between two keys.
const MOST_BETWEEN: usize = 64;

/// Maximum distances of curves from poses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    pub(crate) place_m: f64,
    pub(crate) turn_rad: f64,
}

/// Pose with the slopes of the curves through it.
pub(crate) struct Knot {
    time_s: f64,
    place: DVec3,
    turn: DQuat,
    velocity: DVec3,
    turning: DQuat,
    /// Factor on the tolerance; smaller on the ground, where curves of height and rotation must agree.
    care: f64,
}

/// Factor after a leaf has touched the ground.
const CARE_ON_GROUND: f64 = 1.0 / 3.0;

/// Translation and rotation of a node whose tracks start at a time; `None` without a knot.
pub(crate) fn keyed(
    knots: &[Knot],
    start_s: f64,
    tolerance: Tolerance,
) -> Option<(Track<DVec3>, Track<DQuat>)> {
    let near = |knot: &Knot, place: DVec3| place.distance(knot.place) <= knot.care * tolerance.place_m;
    let places = smooth(knots, start_s, |knot| (knot.place, knot.velocity), near);
    // The difference of two unit quaternions is half the angle between them.
    let near = |knot: &Knot, turn: DQuat| (turn - knot.turn).length() <= knot.care * 0.5 * tolerance.turn_rad;
    let turns = smooth(knots, start_s, |knot| (knot.turn, knot.turning), near);
    Some((places?, turns?))
}

/// Track with one slope a key, through as few knots as `near` allows, in the compact form of tracks.
fn smooth<T: Animate>(
    knots: &[Knot],
    start_s: f64,
    value: impl Fn(&Knot) -> (T, T),
    near: impl Fn(&Knot, T) -> bool,
) -> Option<Track<T>> {
    let key = |knot: &Knot| {
        let (value, slope) = value(knot);
        SmoothKey { time_s: knot.time_s, value, slope }.shortened(start_s)
    };
    let keys: Vec<SmoothKey<T>> = knots.iter().map(key).collect();
    let (mut kept, mut from) = (vec![*keys.first()?], 0);
    while from + 1 < keys.len() {
        from = farthest(keys.len(), from, |from, to| fits(&knots[from..=to], &keys[from..=to], &near));
        kept.push(keys[from]);
    }
    Track::smooth(start_s, &kept)
}

/// Chooses the sign of each quaternion that is nearer to its predecessor's.
pub(crate) fn to_one_side(poses: &mut [Pose], mut previous: DQuat) {
    for pose in poses {
        pose.turn = if pose.turn.dot(previous) < 0.0 { -pose.turn } else { pose.turn };
        previous = pose.turn;
    }
}

/// Knots of a node in whose space the leaf's centre is `middle`. Slopes are central differences, except where
/// a leaf first touches another object: there its fall ends, and the slope is that of the following motion.
pub(crate) fn knots(poses: &[Pose], landed_at: Option<usize>, middle: DVec3) -> Vec<Knot> {
    let poses: Vec<Pose> =
        poses.iter().map(|&pose| Pose { middle: pose.middle - pose.turn * middle, ..pose }).collect();
    let last = poses.len() - 1;
    (0..poses.len())
        .map(|at| {
            let touches = landed_at == Some(at);
            let from = &poses[if touches { at } else { at.saturating_sub(1) }];
            let to = &poses[(at + 1).min(last)];
            let rests = at == last && landed_at.is_some() || last == 0;
            let over =
                if rests || to.time_s == from.time_s { 0.0 } else { (to.time_s - from.time_s).recip() };
            let Pose { time_s, middle: place, turn } = poses[at];
            let (mut velocity, mut turning) =
                ((to.middle - from.middle) * over, (to.turn - from.turn) * over);
            // Only between evenly spaced poses on both sides.
            let end = landed_at.map_or(last, |landed_at| landed_at.saturating_sub(1));
            if at >= 2 && at + 2 <= end {
                // Fourth-order differences: with second order, slopes would dominate a curve's error.
                let (far_from, far_to) = (&poses[at - 2], &poses[at + 2]);
                velocity = (velocity * 8.0 - (far_to.middle - far_from.middle) * over) / 6.0;
                turning = (turning * 8.0 - (far_to.turn - far_from.turn) * over) / 6.0;
            }
            if landed_at.is_some_and(|landed_at| at > landed_at) {
                velocity.y = monotone(from, &poses[at], to);
            }
            let care = if landed_at.is_some_and(|landed_at| at >= landed_at) { CARE_ON_GROUND } else { 1.0 };
            Knot { time_s, place, turn, velocity, turning, care }
        })
        .collect()
}

/// Slope of the height for a monotone curve (Fritsch & Carlson 1980): the height has kinks where corners
/// touch the ground one by one.
fn monotone(before: &Pose, here: &Pose, after: &Pose) -> f64 {
    let slope = |from: &Pose, to: &Pose| (to.middle.y - from.middle.y) / (to.time_s - from.time_s);
    if after.time_s == here.time_s {
        return 0.0;
    }
    let (rise, next_rise) = (slope(before, here), slope(here, after));
    if rise * next_rise <= 0.0 { 0.0 } else { rise.signum() * rise.abs().min(next_rise.abs()) }
}

/// The farthest of `count` knots after `from` that can be the next key.
fn farthest(count: usize, from: usize, fits: impl Fn(usize, usize) -> bool) -> usize {
    let most = (from + MOST_BETWEEN).min(count - 1);
    // Exponential search, then bisection.
    let (mut near, mut far, mut reach) = (from + 1, most + 1, 2);
    while near < far && from + reach <= most {
        if !fits(from, from + reach) {
            far = from + reach;
            break;
        }
        (near, reach) = (from + reach, 2 * reach);
    }
    while near + 1 < far {
        let middle = usize::midpoint(near, far);
        if fits(from, middle) { near = middle } else { far = middle }
    }
    near
}

/// Whether the curve from the first key to the last passes near all knots between them.
fn fits<T: Animate>(knots: &[Knot], keys: &[SmoothKey<T>], near: impl Fn(&Knot, T) -> bool) -> bool {
    let (a, b) = (&keys[0], &keys[keys.len() - 1]);
    let duration_s = b.time_s - a.time_s;
    // From the end, where curves diverge first.
    knots[1..knots.len() - 1].iter().rev().all(|knot| {
        let weights = hermite((knot.time_s - a.time_s) / duration_s, duration_s);
        near(knot, T::blend([a.value, a.slope, b.value, b.slope], weights))
    })
}

/// Weights of value, slope, value, slope (glTF 2.0 specification, appendix C.4).
fn hermite(t: f64, duration_s: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [2.0 * t3 - 3.0 * t2 + 1.0, duration_s * (t3 - 2.0 * t2 + t), 3.0 * t2 - 2.0 * t3, duration_s * (t3 - t2)]
}
