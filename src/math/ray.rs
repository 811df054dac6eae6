//! A ray, in double precision. Invariant: the direction has unit length.

use glam::DVec3;

/// The half line `origin + t * direction`, `t > 0`, in metres.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin, relative to the camera.
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

impl Ray {
    /// The ray translated by `by`.
    pub fn moved(&self, by: DVec3) -> Self {
        Self { origin: self.origin + by, direction: self.direction }
    }

    /// The point at distance `t`, in metres.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}
