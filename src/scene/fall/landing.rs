//! Landing of a leaf on the ground or on other leaves. In go poses before the touch, out come poses until it
//! rests. Invariant: no point of its outline goes below the ground, and it slides to a halt. Settling is
//! chosen for looks: the air under the leaf is not modelled.

use super::ground::Ground;
use super::leaf::{Leaf, Pose, Surroundings};
use glam::{DQuat, DVec2, DVec3};

/// Time to settle in the leaf's unit of time: for a flat leaf, and the addition for one on its edge.
const SETTLING: (f64, f64) = (2.0, 4.0);
/// Minimum interval of keys, as closer ones could coincide in the single precision of files, seconds.
pub(super) const LEAST_INTERVAL_S: f64 = 1e-3;

/// Samples between two poses, as corners swing.
const LOOKS: u32 = 4;

/// Whether the leaf is above all ground that it could touch between two poses.
fn is_high(leaf: &Leaf, ground: &Ground, [from, to]: [&Pose; 2]) -> bool {
    let lowest_m = from.middle.y.min(to.middle.y) - leaf.reach_m - leaf.clearance_m;
    let within = || {
        let places = [from, to].map(|pose| DVec2::new(pose.middle.x, pose.middle.z));
        let (low, high) = (places[0].min(places[1]), places[0].max(places[1]));
        ground.highest_within(low - leaf.reach_m, high + leaf.reach_m)
    };
    lowest_m > ground.highest_m || lowest_m > within()
}

/// Height of the centre at which no point of the outline is below the ground.
pub(super) fn lowest_height_m(leaf: &Leaf, ground: &Ground, pose: &Pose) -> f64 {
    let heights = leaf.outline.iter().map(|&point| {
        let point = pose.turn * point;
        ground.height_m(pose.middle.x + point.x, pose.middle.z + point.z) - point.y
    });
    heights.fold(f64::NEG_INFINITY, f64::max) + leaf.clearance_m
}

/// Whether a point of the outline is below the ground.
pub(super) fn is_below(leaf: &Leaf, ground: &Ground, pose: &Pose) -> bool {
    !is_high(leaf, ground, [pose, pose]) && pose.middle.y < lowest_height_m(leaf, ground, pose)
}

/// Interpolated pose at which the leaf first touches the ground, if it does.
pub(super) fn first_touch(leaf: &Leaf, ground: &Ground, before: Pose, after: Pose) -> Option<Pose> {
    if is_high(leaf, ground, [&before, &after]) {
        return None;
    }
    first_below(before, after, |pose| is_below(leaf, ground, pose))
}

/// Last interpolated pose before one that is below.
pub(super) fn first_below(before: Pose, after: Pose, is_below: impl Fn(&Pose) -> bool) -> Option<Pose> {
    let is_below = |fraction: f64| is_below(&between(before, after, fraction));
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

/// Interpolation along the chord of the arc, for small rotations; all machines agree.
fn blend(from: DQuat, to: DQuat, fraction: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    (from * (1.0 - fraction) + to * fraction).normalize()
}

/// Appends a pose, or replaces the last one if it is too close in time.
pub(super) fn push_apart(poses: &mut Vec<Pose>, pose: Pose) {
    if poses.len() > 1 && pose.time_s - poses[poses.len() - 1].time_s < LEAST_INTERVAL_S {
        poses.pop();
    }
    poses.push(pose);
}

/// Motion of a leaf from its first touch to rest.
#[derive(Clone, Debug)]
pub(super) struct Settling {
    touch: Pose,
    /// Evenly timed places of its centre, without heights.
    places: Vec<DVec3>,
    pub(super) rest: Pose,
}

impl Settling {
    /// Slide on bare ground, to rest on the nearer side on three of the leaf's points; poses are about
    /// `interval_s` apart.
    pub(super) fn new(
        leaf: &Leaf,
        around: Surroundings<'_>,
        touch: Pose,
        velocity: DVec3,
        interval_s: f64,
    ) -> Self {
        let normal = around.ground.normal(touch.middle.x, touch.middle.z, leaf.reach_m);
        let side = usize::from((touch.turn * DVec3::Y).dot(normal) < 0.0);
        let own_normal = touch.turn * leaf.rests[side];
        let flat = DQuat::from_rotation_arc(own_normal, normal) * touch.turn;
        let steepness = 1.0 - own_normal.dot(normal);
        let duration_s = (SETTLING.0 + SETTLING.1 * steepness) * leaf.own_time_s();
        let count = (duration_s / interval_s).ceil().max(6.0);
        let along = DVec3::new(velocity.x, 0.0, velocity.z);
        let mut slid_to = touch.middle;
        let places: Vec<DVec3> = (1..=count as usize)
            .map(|number| {
                let fraction = number as f64 / count;
                let square = fraction * fraction;
                // Decelerating.
                let slid_s = duration_s * (fraction - square + square * fraction / 3.0);
                let to = touch.middle + along * slid_s;
                let stopped = around.obstacles.slide(slid_to, to, leaf.reach_m);
                slid_to = stopped.map_or(to, |contact| contact.place);
                slid_to
            })
            .collect();
        let mut rest = Pose { time_s: touch.time_s + duration_s, middle: slid_to, turn: flat };
        rest.middle.y = lowest_height_m(leaf, around.ground, &rest);
        Self { touch, places, rest }
    }

    /// Poses after the touch, until it rests.
    pub(super) fn poses(&self, leaf: &Leaf, ground: &Ground) -> Vec<Pose> {
        let Self { touch, places, rest } = self;
        // Height above bare ground, due to leaves below.
        let lift = |pose: &Pose| (pose.middle.y - lowest_height_m(leaf, ground, pose)).max(0.0);
        let (first_lift, last_lift) = (lift(touch), lift(rest));
        let count = places.len() as f64;
        let moments = places.iter().enumerate().map(|(at, place)| {
            let fraction = (at + 1) as f64 / count;
            // Smooth start and end of the tilt.
            let eased = fraction * fraction * (3.0 - 2.0 * fraction);
            let time_s = touch.time_s + (rest.time_s - touch.time_s) * fraction;
            let mut pose = Pose { time_s, middle: *place, turn: blend(touch.turn, rest.turn, eased) };
            let lift = first_lift + (last_lift - first_lift) * eased;
            pose.middle.y = lowest_height_m(leaf, ground, &pose) + lift;
            pose
        });
        moments.collect()
    }
}
