//! Turn of a random walk, which weighs the light that the walk then meets. In go a turn and the density with
//! which a point is picked, out comes the point's share. Invariant: see `connection.rs`.

use super::connection::per_sr;
use super::lit_by_glow::Collision;
use crate::snapshot::SurfacePoint;
use glam::DVec3;

/// Vertex at which a walk took a new direction, and the density of that direction, 1/sr.
#[derive(Clone, Copy)]
pub(super) struct Turn {
    pub(super) place: DVec3,
    pub(super) density: f64,
    /// In fog, where glow is looked for.
    pub(super) collision: Option<Collision>,
}

impl Turn {
    /// The share by which a point counts that a walk meets, where `per_m2` says how densely it is picked.
    pub(super) fn share_of_met(&self, point: &SurfacePoint, per_m2: f64) -> f64 {
        let picked = per_sr(per_m2, point, self.place.distance(point.position));
        // Seen from its edge it is picked for certain.
        if picked.is_finite() { self.density / (self.density + picked) } else { 0.0 }
    }
}
