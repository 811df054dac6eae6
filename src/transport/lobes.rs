//! Lobes of a surface, by which directions are picked. In go a point of a surface and uniform numbers, out
//! come directions and their densities. Invariant: wherever the surface scatters light, the density is
//! more than 0.

use crate::color::{Rgb, luminance};
use crate::math::disc_from_square;
use crate::scattering::Clearcoat;
use crate::snapshot::SurfacePoint;
use glam::{DVec2, DVec3};
use std::f64::consts::FRAC_1_PI;

/// The ways that a surface scatters. Shares of 1.
pub(super) struct Lobes {
    /// Share on the eye's side.
    reflected: f64,
    /// Share on the other side.
    transmitted: f64,
    /// Share of its clear coat.
    coated: f64,
    /// Share of its gloss.
    shone: f64,
    /// Albedo of all lobes together, approximate.
    pub(super) all: f64,
}

impl Lobes {
    /// `None` if it scatters nothing.
    pub(super) fn of(point: &SurfacePoint) -> Option<Self> {
        let cos_eye = point.shading_normal.dot(point.to_eye);
        let gloss = point.gloss.as_ref().filter(|_| cos_eye > 0.0);
        let beneath = gloss.map_or(Rgb::ONE, |gloss| Rgb::ONE - gloss.albedo(cos_eye));
        // Cloth is picked as if it were matte.
        let sheen = point
            .layers
            .as_ref()
            .map_or(0.0, |layers| layers.sheen_albedo(point.shading_normal, point.to_eye));
        let coated = coat(point).map_or(0.0, |coat| coat.albedo(point.to_eye));
        let reflected = luminance(point.albedo * beneath) + sheen;
        let transmitted = luminance(point.transmission * beneath);
        let shone = gloss.map_or(0.0, |gloss| luminance(gloss.albedo(cos_eye)));
        let all = reflected + transmitted + shone + coated;
        let [reflected, transmitted, coated, shone] =
            [reflected, transmitted, coated, shone].map(|share| share / all);
        (all > 0.0).then_some(Self { reflected, transmitted, coated, shone, all })
    }

    /// A direction to the light that two uniform numbers pick, about as densely as the surface
    /// scatters towards the eye.
    pub(super) fn pick(&self, point: &SurfacePoint, mut u: DVec2) -> DVec3 {
        let normal = point.shading_normal;
        let lambert = |u: DVec2, normal: DVec3| {
            // Malley's method: a uniform disc, projected up.
            let disc = disc_from_square(u);
            about(normal, disc, (1.0 - disc.length_squared()).max(0.0).sqrt())
        };
        if u.x < self.reflected {
            u.x /= self.reflected;
            return lambert(u, normal);
        }
        u.x -= self.reflected;
        if let Some(coat) = coat(point).filter(|_| u.x < self.coated) {
            u.x /= self.coated;
            return coat.gloss.pick(coat.normal, point.to_eye, u);
        }
        u.x -= self.coated;
        match &point.gloss {
            Some(gloss) if u.x >= self.transmitted => {
                u.x = (u.x - self.transmitted) / self.shone;
                gloss.pick(normal, point.to_eye, u)
            }
            _ => {
                u.x /= self.transmitted;
                lambert(u, -normal)
            }
        }
    }

    /// Probability density of [`Lobes::pick`] for a direction, 1/sr.
    pub(super) fn picked(&self, point: &SurfacePoint, direction: DVec3) -> f64 {
        let cos = point.shading_normal.dot(direction);
        let matte = if cos > 0.0 { self.reflected } else { self.transmitted } * FRAC_1_PI * cos.abs();
        // Some of what is picked for gloss and coat lies behind the surface, where light may come through.
        let gloss = point.gloss.as_ref().filter(|_| self.shone > 0.0);
        let gloss = gloss.map_or(0.0, |gloss| gloss.picked(point.shading_normal, point.to_eye, direction));
        let coat = coat(point).filter(|_| self.coated > 0.0);
        let coat = coat.map_or(0.0, |coat| coat.gloss.picked(coat.normal, point.to_eye, direction));
        matte + self.shone * gloss + self.coated * coat
    }
}

/// The clear coat of a surface that is seen from before it.
fn coat(point: &SurfacePoint) -> Option<&Clearcoat> {
    let coat = point.layers.as_ref()?.clearcoat.as_ref()?;
    (coat.normal.dot(point.to_eye) > 0.0).then_some(coat)
}

/// A vector by its parts across an axis and along it.
pub(super) fn about(axis: DVec3, across: DVec2, along: f64) -> DVec3 {
    let right = axis.any_orthonormal_vector();
    across.x * right + across.y * axis.cross(right) + along * axis
}
