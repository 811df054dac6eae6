//! Poses in, as few keys as show them out. Invariant: between keys the curves pass every pose within
//! the tolerance.

use super::flight::{Flight, Pose};
use crate::scene::{Animate, Extend, Key, Segment, Track};
use glam::{DQuat, DVec3};

/// More poses than this between two keys are not tried.
const MOST_BETWEEN: usize = 64;

/// How far curves may pass from a pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerance {
    pub(crate) place_m: f64,
    pub(crate) turn_rad: f64,
}

/// A pose with the slopes of the curves through it.
struct Knot {
    time_s: f64,
    place: DVec3,
    turn: DQuat,
    velocity: DVec3,
    turning: DQuat,
}

/// Place and turn of a node whose own point `middle` is the leaf's; `None` without a pose.
pub(crate) fn keyed(
    flight: &Flight,
    middle: DVec3,
    tolerance: Tolerance,
) -> Option<(Track<DVec3>, Track<DQuat>)> {
    let knots = knots(flight, middle);
    let mut kept = vec![0];
    let mut from = 0;
    while from + 1 < knots.len() {
        from = farthest(&knots, from, tolerance);
        kept.push(from);
    }
    let places = smooth(&knots, &kept, |knot| (knot.place, knot.velocity));
    let turns = smooth(&knots, &kept, |knot| (knot.turn, knot.turning));
    Some((places?, turns?))
}

/// A track of one slope a key.
fn smooth<T: Animate>(knots: &[Knot], kept: &[usize], value: impl Fn(&Knot) -> (T, T)) -> Option<Track<T>> {
    let key = |place: usize| {
        let (here, leave) = value(&knots[kept[place]]);
        let arrive = kept.get(place + 1).map_or(T::ZERO, |&next| value(&knots[next]).1);
        Key { time_s: knots[kept[place]].time_s, value: here, to_next: Segment::Hermite { leave, arrive } }
    };
    Track::new((0..kept.len()).map(key).collect(), Extend::Hold)
}

/// Slopes by differences; where a leaf touches the ground, of what comes after: its fall ends there.
fn knots(flight: &Flight, middle: DVec3) -> Vec<Knot> {
    let mut previous = DQuat::IDENTITY;
    let mut poses: Vec<Pose> = flight.poses.clone();
    for pose in &mut poses {
        // Of the two forms of a rotation, the one on the side of the one before.
        pose.turn = if pose.turn.dot(previous) < 0.0 { -pose.turn } else { pose.turn };
        previous = pose.turn;
        pose.middle -= pose.turn * middle;
    }
    let last = poses.len() - 1;
    (0..poses.len())
        .map(|at| {
            let touches = flight.landed_at == Some(at);
            let from = &poses[if touches { at } else { at.saturating_sub(1) }];
            let to = &poses[(at + 1).min(last)];
            let rests = at == last && flight.landed_at.is_some() || last == 0;
            let over =
                if rests || to.time_s == from.time_s { 0.0 } else { (to.time_s - from.time_s).recip() };
            let Pose { time_s, middle: place, turn } = poses[at];
            let (mut velocity, turning) = ((to.middle - from.middle) * over, (to.turn - from.turn) * over);
            if flight.landed_at.is_some_and(|landed_at| at > landed_at) {
                velocity.y = monotone(from, &poses[at], to);
            }
            Knot { time_s, place, turn, velocity, turning }
        })
        .collect()
}

/// Slope of the height with which a curve stays between the heights of its keys (Fritsch & Carlson 1980):
/// where one corner after the other touches the ground, the height has kinks.
fn monotone(before: &Pose, here: &Pose, after: &Pose) -> f64 {
    let slope = |from: &Pose, to: &Pose| (to.middle.y - from.middle.y) / (to.time_s - from.time_s);
    if after.time_s == here.time_s {
        return 0.0;
    }
    let (rise, next_rise) = (slope(before, here), slope(here, after));
    if rise * next_rise <= 0.0 { 0.0 } else { rise.signum() * rise.abs().min(next_rise.abs()) }
}

/// The knot farthest from `from` that can be the next key.
fn farthest(knots: &[Knot], from: usize, tolerance: Tolerance) -> usize {
    let most = (from + MOST_BETWEEN).min(knots.len() - 1);
    // Twice as far while that goes well, then by halves between what does and what does not.
    let (mut near, mut far, mut reach) = (from + 1, most + 1, 2);
    while near < far && from + reach <= most {
        if !fits(knots, from, from + reach, tolerance) {
            far = from + reach;
            break;
        }
        (near, reach) = (from + reach, 2 * reach);
    }
    while near + 1 < far {
        let middle = usize::midpoint(near, far);
        if fits(knots, from, middle, tolerance) { near = middle } else { far = middle }
    }
    near
}

/// Whether one curve passes all knots between the two.
fn fits(knots: &[Knot], from: usize, to: usize, tolerance: Tolerance) -> bool {
    let (a, b) = (&knots[from], &knots[to]);
    let duration_s = b.time_s - a.time_s;
    // From the ends, where curves part first where they do.
    (from + 1..to).rev().all(|at| {
        let knot = &knots[at];
        let weights = hermite((knot.time_s - a.time_s) / duration_s, duration_s);
        let place = DVec3::blend([a.place, a.velocity, b.place, b.velocity], weights);
        if place.distance_squared(knot.place) > tolerance.place_m * tolerance.place_m {
            return false;
        }
        let turn = DQuat::blend([a.turn, a.turning, b.turn, b.turning], weights);
        // The chord between two rotations is half the angle.
        (turn - knot.turn).length() <= 0.5 * tolerance.turn_rad
    })
}

/// Weights of value, slope, value, slope (glTF 2.0 specification, appendix C.4).
fn hermite(t: f64, duration_s: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [2.0 * t3 - 3.0 * t2 + 1.0, duration_s * (t3 - 2.0 * t2 + t), 3.0 * t2 - 2.0 * t3, duration_s * (t3 - t2)]
}
