//! The GGX distribution of microfacets, as in appendix B.3 of glTF 2.0. In go unit vectors and alpha, the
//! square of the roughness, out come densities and shares. Invariant: `visible_normal` samples the
//! distribution of visible normals.

use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// B.3.2: `D = alpha^2 / (pi ((n.h)^2 (alpha^2 - 1) + 1)^2)`, with the sum in a form without cancellation.
pub(super) fn distribution(alpha2: f64, normal: DVec3, half: DVec3) -> f64 {
    let sin2 = normal.cross(half).length_squared();
    let spread = sin2 + alpha2 * normal.dot(half).powi(2);
    alpha2 * FRAC_1_PI / (spread * spread)
}

/// Denominator of Smith's shadowing, for `cos`: `G1 = 2 cos / smith`.
pub(super) fn smith(alpha2: f64, cos: f64) -> f64 {
    cos + (alpha2 + (1.0 - alpha2) * cos * cos).sqrt()
}

/// Shadowing and masking of microfacets.
#[derive(Clone, Copy, Debug)]
pub(super) enum Shadowing {
    /// As in glTF: masking and shadowing are independent.
    Separable,
    /// As in Cycles: low facets are hidden from both directions (Heitz 2014, "Understanding the
    /// masking-shadowing function in microfacet-based BRDFs", equation 99).
    Correlated,
}

impl Shadowing {
    /// Factor that replaces the light's [`smith`]: `G / (4 n.v n.l)` is 1 over this factor and the eye's.
    pub(super) fn smith_of_light(self, alpha2: f64, cos_eye: f64, cos_light: f64) -> f64 {
        let smith_light = smith(alpha2, cos_light);
        match self {
            Self::Separable => smith_light,
            Self::Correlated => {
                2.0 * cos_light + 2.0 * cos_eye * (smith_light - 2.0 * cos_light) / smith(alpha2, cos_eye)
            }
        }
    }
}

/// A visible normal of microfacets about +z, as a point of a spherical cap: in the direction `around` its
/// axis, at the share `to_rim` of the way to its rim (Dupuy and Benyoub 2023, "Sampling visible GGX normals
/// with spherical caps", listing 3).
pub(super) fn visible_normal(alpha: f64, to_eye: DVec3, around: DVec2, to_rim: f64) -> DVec3 {
    let stretched = (to_eye * DVec3::new(alpha, alpha, 1.0)).normalize();
    let z = (1.0 - to_rim) * (1.0 + stretched.z) - stretched.z;
    let across = around * (1.0 - z * z).max(0.0).sqrt();
    ((across.extend(z) + stretched) * DVec3::new(alpha, alpha, 1.0)).normalize()
}
