//! A leaf that touches the ground and comes to rest on it, on three of its points, on the side that is nearer. Invariant:
//! no point of its outline goes below the ground, and it slides to a halt. How it settles is dressing:
//! the air between leaf and ground is not modelled.

use super::flight::{Leaf, Pose, Surroundings};
use super::ground::Ground;
use glam::{DQuat, DVec3};

/// Time to settle in units of the leaf's own time: for one that lies flat already, and what is added
/// for one that stands on its edge.
const SETTLING: (f64, f64) = (2.0, 4.0);
/// Keys closer than this could fall together in the single precision of files, seconds.
const LEAST_INTERVAL_S: f64 = 1e-3;

/// How often is looked from one pose to the next: corners swing.
const LOOKS: u32 = 4;

/// Whether no ground is so high that the leaf could touch it.
fn is_high(leaf: &Leaf, ground: &Ground, pose: &Pose) -> bool {
    pose.middle.y > ground.highest_m() + leaf.reach_m + leaf.clearance_m
}

/// How high the middle must be for no point of the outline to be below the ground.
pub(super) fn lowest_height_m(leaf: &Leaf, ground: &Ground, pose: &Pose) -> f64 {
    if is_high(leaf, ground, pose) {
        return f64::NEG_INFINITY;
    }
    let heights = leaf.outline.iter().map(|&point| {
        let point = pose.turn * point;
        ground.height_m(pose.middle.x + point.x, pose.middle.z + point.z) - point.y
    });
    heights.fold(f64::NEG_INFINITY, f64::max) + leaf.clearance_m
}

/// The pose between two at which the leaf first touches the ground, if it does.
pub(super) fn first_touch(leaf: &Leaf, ground: &Ground, before: Pose, after: Pose) -> Option<Pose> {
    if is_high(leaf, ground, &before) && is_high(leaf, ground, &after) {
        return None;
    }
    let is_below = |fraction: f64| {
        let pose = between(before, after, fraction);
        pose.middle.y < lowest_height_m(leaf, ground, &pose)
    };
    let mut looks = (1..=LOOKS).map(|look| f64::from(look) / f64::from(LOOKS));
    let mut high = looks.find(|&fraction| is_below(fraction))?;
    let mut low = high - 1.0 / f64::from(LOOKS);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        if is_below(middle) { high = middle } else { low = middle }
    }
    Some(between(before, after, low))
}

fn between(from: Pose, to: Pose, fraction: f64) -> Pose {
    Pose {
        time_s: from.time_s + (to.time_s - from.time_s) * fraction,
        middle: from.middle + (to.middle - from.middle) * fraction,
        turn: blend(from.turn, to.turn, fraction),
    }
}

/// Along the chord of the arc: for small turns, and all machines agree.
fn blend(from: DQuat, to: DQuat, fraction: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    (from * (1.0 - fraction) + to * fraction).normalize()
}

/// Adds a pose; one that comes right after the last takes its place.
pub(super) fn push_apart(poses: &mut Vec<Pose>, pose: Pose) {
    if poses.len() > 1 && pose.time_s - poses[poses.len() - 1].time_s < LEAST_INTERVAL_S {
        poses.pop();
    }
    poses.push(pose);
}

/// The poses after a touch, until the leaf lies.
pub(super) fn settle(
    leaf: &Leaf,
    around: Surroundings<'_>,
    touch: Pose,
    velocity: DVec3,
    interval_s: f64,
) -> Vec<Pose> {
    let ground = around.ground;
    let along = DVec3::new(velocity.x, 0.0, velocity.z);
    let mut slid_to = touch.middle;
    let at = |time_s: f64, middle: DVec3, turn: DQuat| {
        let pose = Pose { time_s, middle, turn };
        let height_m = lowest_height_m(leaf, ground, &pose);
        Pose { middle: DVec3::new(middle.x, height_m, middle.z), ..pose }
    };
    let normal = ground.normal(touch.middle.x, touch.middle.z, leaf.reach_m);
    let side = usize::from((touch.turn * DVec3::Y).dot(normal) < 0.0);
    let own_normal = touch.turn * leaf.rests[side];
    let flat = DQuat::from_rotation_arc(own_normal, normal) * touch.turn;
    let steepness = 1.0 - own_normal.dot(normal);
    let duration_s = (SETTLING.0 + SETTLING.1 * steepness) * leaf.own_time_s();
    let count = (duration_s / interval_s).ceil().max(6.0);
    (1..=count as usize)
        .map(|number| {
            let fraction = number as f64 / count;
            let square = fraction * fraction;
            // Tips over, faster and faster, and is caught; slides ever slower.
            let turn = blend(touch.turn, flat, square * (3.0 - 2.0 * fraction));
            let slid_s = duration_s * (fraction - square + square * fraction / 3.0);
            let to = touch.middle + along * slid_s;
            let stopped = around.obstacles.slide(slid_to, to, leaf.reach_m);
            slid_to = stopped.map_or(to, |contact| contact.place);
            at(touch.time_s + duration_s * fraction, slid_to, turn)
        })
        .collect()
}
