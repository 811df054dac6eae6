//! Sample of one camera ray. Invariant: `radiance = surface * transmittance + shafts`, plus light of the
//! blended surfaces in front.

use crate::color::Rgb;
use glam::DVec3;

/// The value of one camera ray.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sample {
    /// All radiance that reaches the camera, W m^-2 sr^-1.
    pub radiance: Rgb,
    /// Part of `radiance` that surfaces and the background emit, in mirrors too.
    pub emitted: Rgb,
    /// Hue of the sampled point of the light in a picture of one light, not multiplied in yet; else 1. See
    /// [`Luminaire::hued_point`](crate::snapshot::Luminaire::hued_point). Emission and indirect light already
    /// have theirs.
    pub hue: Rgb,
    /// Part of `radiance` that is indirect light of surfaces, in mirrors too.
    pub indirect: Rgb,
    /// Part of `radiance` that fog scattered.
    pub shafts: Rgb,
    /// Part of `shafts` that had been scattered before.
    pub indirect_shafts: Rgb,
    /// Transmittance of fog and blended surfaces to the first opaque surface, or to the background if
    /// there is none.
    pub transmittance: Rgb,
    /// Coverage, `0..=1`, by which the radiance is premultiplied.
    pub alpha: f64,
    /// Features of the surface that was hit, if one was.
    pub surface: Option<SurfaceFeatures>,
    /// Motion in pixels to the right and up: from the place now to that a frame before, and to the place
    /// now from that a frame after. 0 unless the snapshot has a motion field.
    pub motion_px: [f64; 4],
    /// Visible objects, front to back; none unless the snapshot has matte ids.
    pub mattes: [Matte; MATTES_OF_A_SAMPLE],
}

/// Maximum number of objects of a sample: blended ones, and the opaque one behind them. The last are left out
/// if there are more.
pub const MATTES_OF_A_SAMPLE: usize = 4;

/// An object's share of a sample; none if the share is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Matte {
    /// See [`crate::scene::matte_id`].
    pub id: u32,
    /// `0..=1`.
    pub share: f32,
}

/// Features for the data passes, of the surface that a camera ray hit.
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
