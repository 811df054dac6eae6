//! Lights without extent, placed relative to the camera at one moment. In goes a point, out come direction,
//! distance and irradiance of the light there. Invariant: this module knows no occlusion.

mod emission;
mod frozen_light;
mod lamp_shape;

pub use emission::{Cone, Emission};
pub use frozen_light::{FrozenLight, LightPlace};
pub use lamp_shape::LampShape;
