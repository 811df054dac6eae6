//! Microfacets of one roughness. In go unit vectors, out come factors of a BRDF, and sampled directions.
//! Invariant: [`Microfacets::pdf`] is the density of [`Microfacets::sample`].

use super::albedos::{CoatAlbedos, LEAST_ROUGHNESS};
use super::ggx::{self, Shadowing, visible_normal};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

#[derive(Clone, Copy, Debug)]
pub(super) struct Microfacets {
    /// glTF's alpha, the square of its roughness.
    pub(super) alpha: f64,
    shadowing: Shadowing,
    /// Albedos of fully reflecting microfacets, by single scattering.
    pub(super) albedos: CoatAlbedos,
}

impl Microfacets {
    /// Microfacets of glTF's roughness, `0..=1`.
    pub(super) fn new(roughness: f64, shadowing: Shadowing) -> Self {
        let roughness = roughness.clamp(LEAST_ROUGHNESS, 1.0);
        Self { alpha: roughness * roughness, shadowing, albedos: CoatAlbedos::new(roughness, shadowing) }
    }

    /// Microfacets of the same roughness under another shadowing.
    pub(super) fn under(self, shadowing: Shadowing) -> Self {
        Self { shadowing, albedos: self.albedos.under(shadowing), ..self }
    }

    /// Microfacets at least as rough as an alpha, with unchanged albedos.
    pub(super) fn widened(self, least_alpha: f64) -> Self {
        Self { alpha: self.alpha.max(least_alpha), ..self }
    }

    /// Density of microfacets that face `half`.
    pub(super) fn distribution(&self, normal: DVec3, half: DVec3) -> f64 {
        ggx::distribution(self.alpha * self.alpha, normal, half)
    }

    /// Divisor of the distribution in a BRDF, for the cosines of both directions. B.3.2: `G / (4 n.v n.l)`.
    pub(super) fn smith(&self, cos_eye: f64, cos_light: f64) -> f64 {
        let alpha2 = self.alpha * self.alpha;
        ggx::smith(alpha2, cos_eye) * self.shadowing.smith_of_light(alpha2, cos_eye, cos_light)
    }

    /// Samples a direction to the light by two uniform numbers, with a density close to the BRDF times the
    /// cosine: a visible microfacet mirrors the eye. It may lie below the surface.
    pub(super) fn sample(&self, normal: DVec3, to_eye: DVec3, u: DVec2) -> DVec3 {
        let [across, up] = across(normal);
        let local = DVec3::new(to_eye.dot(across), to_eye.dot(up), to_eye.dot(normal));
        let half = self.visible(local, u);
        let to_light = 2.0 * local.dot(half) * half - local;
        to_light.x * across + to_light.y * up + to_light.z * normal
    }

    /// Samples the normal of a visible microfacet by two uniform numbers.
    pub(super) fn sample_facet(&self, normal: DVec3, to_eye: DVec3, u: DVec2) -> DVec3 {
        let [across, up] = across(normal);
        let half = self.visible(DVec3::new(to_eye.dot(across), to_eye.dot(up), to_eye.dot(normal)), u);
        half.x * across + half.y * up + half.z * normal
    }

    fn visible(&self, local: DVec3, u: DVec2) -> DVec3 {
        visible_normal(self.alpha, local, DVec2::from_angle(2.0 * PI * u.x), u.y)
    }

    /// Probability density of [`Microfacets::sample`], 1/sr (Heitz 2018, equations 2, 3 and 17).
    pub(super) fn pdf(&self, normal: DVec3, to_eye: DVec3, to_light: DVec3) -> f64 {
        // No microfacet faces down.
        let half = (to_eye + to_light).try_normalize().filter(|half| half.dot(normal) > 0.0);
        let Some(half) = half else { return 0.0 };
        let cos_eye = normal.dot(to_eye).max(0.0);
        // G1(v) D(h) / (4 n.v), with G1(v) = 2 n.v / smith(n.v).
        0.5 * self.distribution(normal, half) / ggx::smith(self.alpha * self.alpha, cos_eye)
    }
}

/// Two unit vectors at right angles to a normal.
fn across(normal: DVec3) -> [DVec3; 2] {
    let across = normal.any_orthonormal_vector();
    [across, normal.cross(across)]
}

/// Energy that fully reflecting microfacets lack, over their albedo: `(1 - E) / E`.
pub(super) fn lacking([part0, part90]: [f64; 2]) -> f64 {
    (1.0 - part0 - part90) / (part0 + part90)
}
