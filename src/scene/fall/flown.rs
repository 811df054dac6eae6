//! Flight of a leaf before it meets other leaves. In go poses, out come keys, and the last poses before the
//! ground, where leaves may lie. Invariant: it is a pure function of the leaf and its surroundings.

use super::keys::{self, Tolerance};
use super::leaf::{Flight, Pose};
use crate::scene::Track;
use glam::{DQuat, DVec3};

/// Time before it touches the ground in which a leaf may meet others on the ground, seconds.
const TAIL_S: f64 = 0.4;
/// Poses of the tail before its start, for differences.
const CONTEXT: usize = 2;

/// Translation and rotation of a node.
pub(super) type Tracks = (Track<DVec3>, Track<DQuat>);

/// Flight of a leaf until it touches the ground, if it does. The default has no pose.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in crate::inside::scene) struct Flown {
    /// Tracks up to the tail; `None` if the tail is all.
    pub(super) head: Option<Tracks>,
    /// Poses until it touches the ground; empty if it never does.
    pub(super) tail: Vec<Pose>,
    /// Velocity at the ground.
    pub(super) velocity: DVec3,
}

impl Flown {
    /// Flight of a node in whose space the leaf's centre is `middle`; `None` without a pose.
    pub(super) fn new(flight: Flight, middle: DVec3, tolerance: Tolerance) -> Option<Self> {
        let Flight { mut poses, touches_with } = flight;
        let start_s = poses.first()?.time_s;
        keys::to_one_side(&mut poses, DQuat::IDENTITY);
        let Some(velocity) = touches_with else {
            let head = Some(keys::keyed(&keys::knots(&poses, None, middle), start_s, tolerance)?);
            return Some(Self { head, tail: Vec::new(), velocity: DVec3::ZERO });
        };
        let from_s = poses.last()?.time_s - TAIL_S;
        let from = poses.partition_point(|pose| pose.time_s < from_s);
        if from <= CONTEXT {
            return Some(Self { head: None, tail: poses, velocity });
        }
        let knots = keys::knots(&poses, None, middle);
        let head = Some(keys::keyed(&knots[..=from], start_s, tolerance)?);
        Some(Self { head, tail: poses.split_off(from - CONTEXT), velocity })
    }

    /// Returns the flight if its parts are consistent, as those of a file need not be.
    pub(super) fn checked(self) -> Option<Self> {
        let whole = self.head.is_some() && self.tail.is_empty() || self.tail.len() > self.first();
        whole.then_some(self)
    }

    /// Index of the pose in the tail at which the head ends.
    pub(super) fn first(&self) -> usize {
        if self.head.is_some() { CONTEXT } else { 0 }
    }

    /// Tracks of the whole path: up to pose `until` of the tail, then through a touch to rest.
    pub(super) fn into_rest(
        self,
        until: usize,
        touch: Pose,
        settling: Vec<Pose>,
        middle: DVec3,
        tolerance: Tolerance,
    ) -> Option<Tracks> {
        let mut poses = self.tail[..until].to_vec();
        poses.push(touch);
        let landed_at = poses.len() - 1;
        poses.extend(settling);
        keys::to_one_side(&mut poses, self.tail[0].turn);
        let knots = keys::knots(&poses, Some(landed_at), middle);
        let start_s = self.head.as_ref().map_or(self.tail[0].time_s, |(places, _)| places.span_s().0);
        let (places, turns) = keys::keyed(&knots[self.first()..], start_s, tolerance)?;
        let Some((head_places, head_turns)) = self.head else { return Some((places, turns)) };
        Some((head_places.then(places)?, head_turns.then(turns)?))
    }
}
