//! Cameras of a scene file. In goes RON, out come cameras. Invariant: docs/scene-format.md describes every
//! field.

use super::animated::Animated;
use super::number::{
    Degrees, Direction, FStop, FieldOfView, FocusDistance, NonNegative, Number, Point, Positive, Quaternion,
    Vector, Whole,
};
use serde::{Deserialize, Serialize};

/// A camera: a pinhole, or a lens with an aperture, perspective or orthographic.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
#[non_exhaustive]
pub struct Camera {
    /// Name of the object that the camera follows.
    pub parent: Option<String>,
    /// Position in its parent's space.
    pub position_m: Animated<Point>,
    /// Point that it looks at, in its parent's space.
    pub look_at_m: Option<Animated<Point>>,
    /// Up direction of the picture, with `look_at_m`.
    pub up: Animated<Direction>,
    /// Rotation about x, then y, then z, from a view along -z; excludes `look_at_m`.
    pub rotation_deg: Option<Animated<Vector<Degrees>>>,
    /// Rotation as a quaternion `(x, y, z, w)`; excludes `rotation_deg`.
    pub rotation_quaternion: Option<Animated<Quaternion>>,
    /// Full vertical field of view; 45 degrees by default.
    pub fov_deg: Option<Animated<Number<FieldOfView>>>,
    /// Height of an orthographic camera's picture; excludes `fov_deg`.
    pub orthographic_height_m: Option<Animated<Number<Positive>>>,
    /// Lens for depth of field; a pinhole by default.
    pub aperture: Option<Aperture>,
    /// Clipping distances along the view; unlimited by default.
    pub clip_m: Option<(Number<NonNegative>, Number<Positive>)>,
}

impl Default for Camera {
    /// Camera at the origin, looking along -z.
    fn default() -> Self {
        Self {
            parent: None,
            position_m: Animated::default(),
            look_at_m: None,
            up: [0.0, 1.0, 0.0].into(),
            rotation_deg: None,
            rotation_quaternion: None,
            fov_deg: None,
            orthographic_height_m: None,
            aperture: None,
            clip_m: None,
        }
    }
}

/// Opening of a lens.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Aperture {
    /// Focal length over the opening's diameter.
    pub f_stop: Animated<Number<FStop>>,
    /// Distance along the view to the plane in focus.
    pub focus_distance_m: Animated<Number<FocusDistance>>,
    /// Width of the sensor, which with the angle of view determines the focal length.
    #[serde(default = "full_frame")]
    pub sensor_width_mm: Number<Positive>,
    /// Number of straight blades; a round opening by default.
    pub blades: Option<Whole<3, 32>>,
}

impl Aperture {
    /// A round opening before a sensor 36 mm wide.
    pub fn new(
        f_stop: impl Into<Animated<Number<FStop>>>,
        focus_distance_m: impl Into<Animated<Number<FocusDistance>>>,
    ) -> Self {
        let (f_stop, focus_distance_m) = (f_stop.into(), focus_distance_m.into());
        Self { f_stop, focus_distance_m, sensor_width_mm: full_frame(), blades: None }
    }
}

fn full_frame() -> Number<Positive> {
    36.0.into()
}
