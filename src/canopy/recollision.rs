//! Recollision: light that a leaf or a clump scatters and that meets it again. In go the probability of
//! escape and an albedo, out comes the share that finally escapes. Invariant: without absorption all light
//! escapes.
//!
//! A scattered photon escapes with the probability `q`, or collides again with leaves of the same clump
//! (Smolander & Stenberg 2005, "Simple parameterizations of the radiation budget of uniform broadleaved and
//! coniferous canopies").

use crate::color::Rgb;
use crate::ordinates::surface_optics::SurfaceOptics;

/// Share of scattered light that escapes: `q / (1 - (1 - q) a)`, the sum of a geometric series.
pub(crate) fn escaped(share: f64, albedo: Rgb) -> Rgb {
    share / (Rgb::ONE - (1.0 - share) * albedo.min(Rgb::ONE))
}

/// Optics of a bent leaf with an exposed share: light that meets it again is scattered again.
pub(crate) fn bent(optics: &SurfaceOptics, exposed: f64) -> SurfaceOptics {
    let out = escaped(exposed, optics.albedo());
    SurfaceOptics {
        reflectance: out * optics.reflectance,
        transmittance: out * optics.transmittance,
        emission: out * optics.emission,
        ..*optics
    }
}
