//! What one camera ray found. Invariant: `radiance = surface * transmittance + shafts`, plus what blended
//! surfaces show before it.

use crate::color::Rgb;
use glam::DVec3;

/// The value of one camera ray.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// Everything that reaches the camera, W m^-2 sr^-1.
    pub radiance: Rgb,
    /// The part that was scattered in fog.
    pub shafts: Rgb,
    /// What fog and blended surfaces let through from the first opaque surface, or from the background if there is none.
    pub transmittance: Rgb,
    /// Coverage, `0..=1`, by which the radiance is premultiplied.
    pub alpha: f64,
    /// What was hit, if anything.
    pub surface: Option<SurfaceFeatures>,
}

/// What the data passes show of the surface that a camera ray hit.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFeatures {
    /// Distance along the view axis (planar Z), metres.
    pub depth_m: f64,
    /// Shading normal in world space, turned towards the camera.
    pub normal: DVec3,
    /// World position, metres.
    pub position: DVec3,
    /// Lambert reflectance.
    pub albedo: Rgb,
    /// The instance's number, from 1.
    pub leaf_id: u32,
}
