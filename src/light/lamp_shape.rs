//! Extent of a lamp, for one of its sample points. In go places, out come the shares of the point's light
//! that arrive there. Invariant: a lamp without an extent has a share of 1 everywhere.

use crate::math::Ray;
use glam::DVec3;
use std::f64::consts::PI;

/// Extent of a lamp, in relative space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampShape {
    /// Its centre.
    pub centre: DVec3,
    /// Square of the radius of a lamp with soft falloff, m^2; 0 for all others.
    pub softened_m2: f64,
    /// Square of the radius of a sphere that emits inward, too, m^2; 0 for all others.
    pub inward_m2: f64,
    /// Area that smooth surfaces show as an image, m^2; 0 if they show none.
    pub shown_m2: f64,
}

impl LampShape {
    /// A lamp without an extent.
    pub const NONE: Self = Self { centre: DVec3::ZERO, softened_m2: 0.0, inward_m2: 0.0, shown_m2: 0.0 };

    /// Share of a sphere's light that arrives at a place by soft falloff.
    ///
    /// With soft falloff, Cycles' lamp is a disc that faces the lit place (`kernel/light/point.h`). It fills
    /// a cone with `sin^2 = r^2 / (d^2 + r^2)`, a sphere of the same radiance one with `r^2 / d^2`.
    #[inline]
    pub fn share(&self, place: DVec3) -> f64 {
        if self.softened_m2 == 0.0 {
            return 1.0;
        }
        let squared = place.distance_squared(self.centre);
        squared / (squared + self.softened_m2)
    }

    /// Share of a sphere's fluence that arrives at a place in fog.
    ///
    /// Inside a sphere its points give half the fluence of a surface that emits inward, too. With soft
    /// falloff the disc fills `2 pi (1 - d / s)` steradians with `s^2 = d^2 + r^2`. A sphere fills `2 pi (1 -
    /// sqrt(1 - r^2 / d^2))`, or half of all directions for a place inside.
    #[inline]
    pub fn share_in_fog(&self, place: DVec3) -> f64 {
        let squared = place.distance_squared(self.centre);
        if self.softened_m2 == 0.0 {
            return if squared < self.inward_m2 { 2.0 } else { 1.0 };
        }
        let (d, s) = (squared.sqrt(), (squared + self.softened_m2).sqrt());
        // Without differences, which would cancel far away.
        let tangent = (squared - self.softened_m2).max(0.0).sqrt();
        if tangent > 0.0 { d * (d + tangent) / (s * (s + d)) } else { self.softened_m2 / (s * (s + d)) }
    }

    /// Distances at which a ray crosses the sphere within which its share in fog differs, in order.
    pub fn crossings(&self, ray: &Ray) -> [Option<f64>; 2] {
        let to_centre = self.centre - ray.origin;
        let along = to_centre.dot(ray.direction);
        let squared = self.softened_m2.max(self.inward_m2) - to_centre.cross(ray.direction).length_squared();
        if squared > 0.0 { [along - squared.sqrt(), along + squared.sqrt()].map(Some) } else { [None; 2] }
    }

    /// Whether a GGX lobe of an alpha is narrow enough to show the lamp's outline at a place.
    pub fn shows_in(&self, alpha: f64, place: DVec3) -> bool {
        /// Minimum ratio of solid angles: below it rays to the lamp have less noise than rays of the lobe
        /// (measured, 64 samples).
        const NARROWER: f64 = 16.0;
        // Half of the reflected light is within 2 alpha of the mirror direction.
        let lobe_sr = 4.0 * PI * alpha * alpha;
        self.shown_m2 > NARROWER * lobe_sr * place.distance_squared(self.centre)
    }
}
