//! Flight of one leaf to the ground. In goes a leaf, out come poses, evenly spaced except for the one at the
//! ground. Invariants: a flight is a pure function of the leaf and its surroundings, independent of frames
//! and their rate. Until it lands, no point of it is below the ground or in an obstacle.
//!
//! The plate of [`super::plate`] falls in a vertical plane; the leaf's width is its chord. In uniform wind
//! this is exact in the frame of the air; changing wind acts as a weight. The rest of three dimensions is not
//! physical, and is chosen for looks. The plane turns ([`Manner`](super::leaf::Manner)), the leaf banks and
//! twists about its normal, and the air carries it sideways.

use super::landing;
use super::leaf::{Flight, Leaf, Pose, Surroundings};
use super::obstacles::Obstacles;
use super::plate::{GRAVITY, Plate, State};
use super::wind::Wind;
use glam::{DQuat, DVec3};
use std::mem;

/// Maximum step of the integration in the leaf's unit of time: with it, the error of a flutter of 20 units is
/// a ten-thousandth of a chord.
const LONGEST_STEP: f64 = 0.1;
/// Maximum length of a flight, seconds; longer ones, which wind keeps up, end in the air.
pub(crate) const LONGEST_FLIGHT_S: f64 = 120.0;
/// Time constant of sideways motion with the air, in the leaf's unit of time.
const CARRIED_ALONG: f64 = 4.0;
/// Time after the release until the manner has full strength, seconds.
const TAKING_UP_S: f64 = 0.5;

/// Speed at which a leaf retreats from an obstacle within its reach at the release.
const BACKING_OFF_M_PER_S: f64 = 0.3;

/// Steps of a plate with a constant weight: `steps` of `time` each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub(super) plate: Plate,
    pub(super) state: State,
    pub(super) weight: [f64; 2],
    pub(super) time: f64,
    pub(super) steps: usize,
}

/// A leaf between two poses: it departs, its plate's steps are taken elsewhere, it arrives.
pub(super) struct Journey {
    leaf: Leaf,
    interval_s: f64,
    flier: Flier,
    poses: Vec<Pose>,
}

impl Journey {
    /// Releases a leaf, with the interval of its poses. A leaf on the ground already has finished its flight,
    /// which is returned as the error.
    pub(super) fn released(
        mut leaf: Leaf,
        interval_s: f64,
        around: Surroundings<'_>,
    ) -> Result<Self, Flight> {
        leaf.speed_gain = around.speed_gain.at(leaf.release_s);
        let flier = Flier::released(&leaf, around);
        let first = flier.pose(&leaf, 0.0);
        let poses = vec![first];
        if landing::is_below(&leaf, around.ground, &first) {
            return Err(Flight { poses, touches_with: Some(DVec3::ZERO) });
        }
        Ok(Self { leaf, interval_s, flier, poses })
    }

    /// Steps of the plate until the next pose.
    pub(super) fn depart(&mut self, around: Surroundings<'_>) -> Leg {
        let (leaf, interval_s) = (&mut self.leaf, self.interval_s);
        leaf.speed_gain = around.speed_gain.at(leaf.release_s + self.flier.time_s + 0.5 * interval_s);
        let weight = self.flier.depart(leaf, around.wind, interval_s);
        // Stable: the method's limit is 2.8.
        let longest_step = LONGEST_STEP.min(1.5 * leaf.plate.damping_time());
        let steps = (interval_s / (longest_step * leaf.own_time_s())).ceil() as usize;
        let time = interval_s / leaf.own_time_s() / steps as f64;
        Leg { plate: leaf.plate, state: self.flier.state, weight, time, steps }
    }

    /// Takes the state after the steps; returns the flight when it ends.
    pub(super) fn arrive(&mut self, state: State, around: Surroundings<'_>) -> Option<Flight> {
        self.flier.arrive(&self.leaf, state, self.interval_s, around.obstacles);
        let number = self.poses.len();
        let before = self.poses[number - 1];
        let after = self.flier.pose(&self.leaf, self.interval_s * number as f64);
        let Some(touching) = landing::first_touch(&self.leaf, around.ground, before, after) else {
            self.poses.push(after);
            let is_last = number >= (LONGEST_FLIGHT_S / self.interval_s) as usize;
            return is_last.then(|| Flight { poses: mem::take(&mut self.poses), touches_with: None });
        };
        let velocity = (after.middle - before.middle) / self.interval_s;
        let mut poses = mem::take(&mut self.poses);
        landing::push_apart(&mut poses, touching);
        Some(Flight { poses, touches_with: Some(velocity) })
    }
}

struct Flier {
    state: State,
    time_s: f64,
    middle: DVec3,
    heading: [f64; 2],
    sway_phase: [f64; 2],
    /// Speed relative to the air, across the plane.
    sideways: f64,
    /// Velocity of the air around it, and displacement in the last interval.
    air: DVec3,
    moved: DVec3,
    /// Velocity of the air at the end of the current interval, and turning rate of the plane.
    next_air: DVec3,
    yaw_rad_per_s: f64,
    /// Radius of the ball around its centre that is kept free of obstacles.
    free_m: f64,
}

impl Flier {
    fn released(leaf: &Leaf, around: Surroundings<'_>) -> Self {
        let near = around.obstacles.nearest(leaf.middle, leaf.reach_m);
        let free_m = near.map_or(leaf.reach_m, |near| near.distance(leaf.middle).max(0.1 * leaf.reach_m));
        let air = around.wind.at(leaf.middle, leaf.release_s);
        let speed = leaf.scales.speed_m_per_s * leaf.speed_gain;
        let [along, across] = axes(leaf.heading);
        let through_air = -air;
        let state =
            State::at_rest(leaf.slope).with_velocity(through_air.dot(along) / speed, through_air.y / speed);
        Self {
            state,
            time_s: 0.0,
            middle: leaf.middle,
            heading: leaf.heading,
            sway_phase: leaf.manner.sway_phase,
            sideways: through_air.dot(across),
            air,
            moved: DVec3::ZERO,
            next_air: air,
            yaw_rad_per_s: 0.0,
            free_m,
        }
    }

    /// Weight on the plate in the next interval.
    fn depart(&mut self, leaf: &Leaf, wind: &Wind, interval_s: f64) -> [f64; 2] {
        // Extrapolated to the end of the interval by the last displacement.
        self.next_air = wind.at(self.middle + self.moved, leaf.release_s + self.time_s + interval_s);
        let acceleration = (self.next_air - self.air) / interval_s;
        self.yaw_rad_per_s =
            leaf.manner.yaw_rad_per_s * self.taken_up() / (1.0 + leaf.manner.widening_per_s * self.time_s);
        self.heading = turned(self.heading, 0.5 * self.yaw_rad_per_s * interval_s);
        let [along, _] = axes(self.heading);
        let gravity = GRAVITY * leaf.speed_gain * leaf.speed_gain;
        (self.state.x, self.state.y) = (0.0, 0.0);
        [-acceleration.dot(along) / gravity, -1.0 - acceleration.y / gravity]
    }

    /// Ends the interval, with the plate's state.
    fn arrive(&mut self, leaf: &Leaf, state: State, interval_s: f64, obstacles: &Obstacles) {
        let acceleration = (self.next_air - self.air) / interval_s;
        let [along, across] = axes(self.heading);
        let carried_s = CARRIED_ALONG * leaf.own_time_s();
        self.state = state;
        self.sideways =
            (self.sideways - acceleration.dot(across) * interval_s) / (1.0 + interval_s / carried_s);
        let fallen = (along * state.x + DVec3::Y * state.y) * leaf.scales.length_m;
        self.moved = fallen + (across * self.sideways + 0.5 * (self.air + self.next_air)) * interval_s;
        self.free_m = (self.free_m + BACKING_OFF_M_PER_S * interval_s).min(leaf.reach_m);
        if let Some(contact) = obstacles.slide(self.middle, self.middle + self.moved, self.free_m) {
            self.moved = contact.place - self.middle;
            self.stop_towards(leaf, contact.normal);
        }
        self.middle += self.moved;
        self.heading = turned(self.heading, 0.5 * self.yaw_rad_per_s * interval_s);
        self.sway_phase = turned(self.sway_phase, leaf.manner.sway_rad_per_s * interval_s);
        self.air = self.next_air;
        self.time_s += interval_s;
    }

    /// Removes the component of its velocity towards a wall with this normal.
    fn stop_towards(&mut self, leaf: &Leaf, normal: DVec3) {
        let State { u, v, cos, sin, .. } = self.state;
        let [along, across] = axes(self.heading);
        let speed = leaf.scales.speed_m_per_s * leaf.speed_gain;
        let (horizontal, upward) = (u * cos - v * sin, u * sin + v * cos);
        let through_air = (along * horizontal + DVec3::Y * upward) * speed + across * self.sideways;
        let away = normal * -(through_air + self.next_air).dot(normal).min(0.0);
        self.state = self.state.with_velocity(horizontal + away.dot(along) / speed, upward + away.y / speed);
        self.sideways += away.dot(across);
    }

    /// Strength of its manner, from 0 at the release to 1.
    fn taken_up(&self) -> f64 {
        let square = self.time_s * self.time_s;
        square / (square + TAKING_UP_S * TAKING_UP_S)
    }

    fn pose(&self, leaf: &Leaf, time_s: f64) -> Pose {
        let [along, _] = axes(self.heading);
        let lean = self.taken_up() * (leaf.manner.bank + leaf.manner.sway * self.sway_phase[1]);
        let tilt = along * (0.5 * lean);
        let bank = DQuat::from_xyzw(tilt.x, tilt.y, tilt.z, 1.0).normalize();
        // A turn from x towards z is a negative one about y.
        let [cos, sin] = half_angle(self.heading);
        let yaw = DQuat::from_xyzw(0.0, -sin, 0.0, cos);
        let [cos, sin] = half_angle([self.state.cos, self.state.sin]);
        let pitch = DQuat::from_xyzw(0.0, 0.0, sin, cos);
        let turn = (bank * yaw * pitch * leaf.twist).normalize();
        Pose { time_s: leaf.release_s + time_s, middle: self.middle, turn }
    }
}

/// Horizontal direction in the plane of fall, and the direction across it.
fn axes([cos, sin]: [f64; 2]) -> [DVec3; 2] {
    [DVec3::new(cos, 0.0, sin), DVec3::new(-sin, 0.0, cos)]
}

/// Rotates by twice the angle whose tangent is `angle / 2`: nearly `angle` if it is small, and always of unit
/// length. It avoids sines, which machines round differently.
fn turned([cos, sin]: [f64; 2], angle: f64) -> [f64; 2] {
    let tangent = 0.5 * angle;
    let over = (1.0 + tangent * tangent).recip();
    let (by_cos, by_sin) = ((1.0 - tangent * tangent) * over, 2.0 * tangent * over);
    [cos * by_cos - sin * by_sin, sin * by_cos + cos * by_sin]
}

/// Cosine and sine of half the angle with this cosine and sine.
fn half_angle([cos, sin]: [f64; 2]) -> [f64; 2] {
    let sum = 1.0 + cos;
    let length = (sum * sum + sin * sin).sqrt();
    if length < 1e-9 { [0.0, 1.0] } else { [sum / length, sin / length] }
}
