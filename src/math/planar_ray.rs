//! A ray in a half plane, from its edge. In go reach, the distance from the edge, and height, the distance
//! along it, both per metre; out comes a slope. Invariant: the ray leads away from the edge.

use glam::DVec2;

/// A ray from the origin of a half plane.
#[derive(Clone, Copy, Debug)]
pub struct PlanarRay {
    /// Unit vector: reach and height per metre.
    pub direction: DVec2,
    /// Height over reach.
    pub slope: f64,
}

impl PlanarRay {
    /// Ray in the direction of a unit vector.
    pub fn new(direction: DVec2) -> Self {
        Self { direction, slope: direction.y / direction.x }
    }
}
