//! Rays of a light within a half plane. In goes a point, out comes the coordinate of the ray through it,
//! called its name. Invariant: names grow from one side of the half plane to the other.

use glam::DVec2;

/// Names of the light's rays within a half plane: one number each.
#[derive(Clone, Copy, Debug)]
pub(super) enum LightRays {
    /// Parallel to the axis: the name is the distance from it.
    Parallel,
    /// From a point on the axis at this height: the name is the angle with the direction back to the camera.
    From(f64),
}

impl LightRays {
    /// Name of the light's ray through a point.
    pub(super) fn through(self, point: DVec2) -> f64 {
        match self {
            Self::Parallel => point.x,
            Self::From(height) => point.x.atan2(height - point.y),
        }
    }

    /// A point and the direction of the ray of a name.
    pub(super) fn line(self, name: f64) -> (DVec2, DVec2) {
        match self {
            Self::Parallel => (DVec2::new(name, 0.0), DVec2::Y),
            Self::From(height) => {
                let (sin, cos) = name.sin_cos();
                (DVec2::new(0.0, height), DVec2::new(sin, -cos))
            }
        }
    }

    /// Reach of the point where a ray of the light meets the camera's ray of a slope;
    /// infinite if it does not.
    pub(super) fn reach(self, name: f64, slope: f64) -> f64 {
        match self {
            Self::Parallel => name,
            Self::From(height) => {
                // reach = tan(name) (height - slope reach).
                let (sin, cos) = name.sin_cos();
                let divisor = cos + slope * sin;
                if divisor > 0.0 { height * sin / divisor } else { f64::INFINITY }
            }
        }
    }
}
