//! Recollision: light that a leaf or a clump of leaves scatters, and meets again. In go the share that
//! escapes and an albedo, out comes what escapes in the end. Invariant: what absorbs nothing keeps nothing.
//!
//! A photon that was scattered escapes with the probability `q`, or meets leaves of the same clump again
//! (Smolander & Stenberg 2005, "Simple parameterizations of the radiation budget of uniform broadleaved and
//! coniferous canopies").

use crate::color::Rgb;
use crate::ordinates::surface_optics::SurfaceOptics;

/// Share of scattered light that escapes: `q / (1 - (1 - q) a)`, the sum of a geometric series.
pub(crate) fn escaped(share: f64, albedo: Rgb) -> Rgb {
    share / (Rgb::ONE - (1.0 - share) * albedo.min(Rgb::ONE))
}

/// Optics of a bent leaf of which a share is exposed: what meets it again is scattered again.
pub(crate) fn bent(optics: &SurfaceOptics, exposed: f64) -> SurfaceOptics {
    let out = escaped(exposed, optics.albedo());
    SurfaceOptics {
        reflectance: out * optics.reflectance,
        transmittance: out * optics.transmittance,
        emission: out * optics.emission,
        cover: optics.cover,
    }
}
