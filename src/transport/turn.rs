//! Turn of a random walk, for the weight of the light that the walk then meets. In go a turn and the density
//! with which a point is sampled, out comes the point's weight. Invariant: the weights of both techniques add
//! up to 1; see `connection.rs`.

use super::connection::per_sr;
use super::emissive_fog_light::Collision;
use crate::snapshot::SurfacePoint;
use glam::DVec3;

/// Vertex at which a walk took a new direction, and the density of that direction, 1/sr.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub(super) place: DVec3,
    pub(super) density: f64,
    /// Collision with fog, where emissive surfaces are sampled.
    pub(super) collision: Option<Collision>,
}

impl Turn {
    /// Weight of a point that a walk meets, where `per_m2` is the density with which it is sampled otherwise.
    pub(super) fn share_of_met(&self, point: &SurfacePoint, per_m2: f64) -> f64 {
        let pdf = per_sr(per_m2, point, self.place.distance(point.position));
        // Seen edge-on, the point has an infinite density by sampling.
        if pdf.is_finite() { self.density / (self.density + pdf) } else { 0.0 }
    }
}
