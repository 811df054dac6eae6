//! Falling leaf, its surroundings and its flight. In go numbers, out come units of time and length.
//! Invariant: a leaf's whole fall follows from these.

use super::ground::Ground;
use super::obstacles::Obstacles;
use super::plate::{Plate, Scales};
use super::wind::Wind;
use crate::scene::Track;
use glam::{DQuat, DVec3};

/// Maximum interval of poses: in seconds, and in the leaf's unit of time, four steps.
const LONGEST_INTERVAL_S: f64 = 1.0 / 40.0;
const LONGEST_INTERVAL: f64 = 0.4;

#[derive(Clone, Copy, Debug)]
pub(super) struct Surroundings<'a> {
    pub(super) wind: &'a Wind,
    pub(super) ground: &'a Ground,
    pub(super) obstacles: &'a Obstacles,
    /// Factor on all speeds of leaves, over time.
    pub(super) speed_gain: &'a Track<f64>,
}

#[derive(Clone, Debug)]
pub(crate) struct Leaf {
    pub(crate) plate: Plate,
    pub(crate) scales: Scales,
    /// Factor on all speeds: before the fall the largest, then the current one.
    pub(crate) speed_gain: f64,
    pub(crate) manner: Manner,
    /// Centre of the leaf before the release.
    pub(crate) middle: DVec3,
    pub(crate) release_s: f64,
    /// Cosine and sine: of the plane's rotation about the vertical, and of the chord's slope in it.
    pub(crate) heading: [f64; 2],
    pub(crate) slope: [f64; 2],
    /// Rotation of the leaf about its normal.
    pub(crate) twist: DQuat,
    /// Points of its outline relative to its centre, metres.
    pub(crate) outline: Vec<DVec3>,
    /// Up directions at rest on either side.
    pub(crate) rests: [DVec3; 2],
    pub(crate) reach_m: f64,
    /// Gap below it at rest.
    pub(crate) clearance_m: f64,
}

/// Motion that extends a fall in a plane to three dimensions; chosen for looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Manner {
    /// Turning rate of the plane.
    pub(crate) yaw_rad_per_s: f64,
    /// Decay of that rate, 1/s: the circles widen.
    pub(crate) widening_per_s: f64,
    /// Lean to one side, and amplitude of its sway, radians.
    pub(crate) bank: f64,
    pub(crate) sway: f64,
    pub(crate) sway_rad_per_s: f64,
    /// Cosine and sine of the sway's phase at the release.
    pub(crate) sway_phase: [f64; 2],
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    pub(crate) time_s: f64,
    pub(crate) middle: DVec3,
    pub(crate) turn: DQuat,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Flight {
    /// Poses from the release on; the last one touches the ground, if any does.
    pub(crate) poses: Vec<Pose>,
    /// Velocity at the ground.
    pub(crate) touches_with: Option<DVec3>,
}

impl Leaf {
    /// Time between two poses.
    pub(super) fn interval_s(&self) -> f64 {
        LONGEST_INTERVAL_S.min(LONGEST_INTERVAL * self.own_time_s())
    }

    /// Time in which the leaf falls about half its width.
    pub(crate) fn own_time_s(&self) -> f64 {
        self.scales.time_s() / self.speed_gain
    }
}
