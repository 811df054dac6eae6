//! Light of emissive surfaces that fog scatters into a walk. In go a leg and uniform numbers, out comes an
//! estimate of that radiance. Invariant: points sampled near emissive surfaces and the walk's collisions have
//! weights that add up to 1 (balance heuristic, see `connection.rs`).
//!
//! Fog around a lantern is bright: light falls as 1 / r^2, and hardly any walk collides there. Equiangular
//! points about a point of the emissive surface sample this light without that noise (Kulla & Fajardo 2012).

use super::connection::{Receiver, Target, per_sr};
use super::equiangular::Angle;
use super::path::Path;
use crate::color::Rgb;
use crate::fog::{FoggyRay, Losses, henyey_greenstein_pdf};
use crate::math::Ray;
use crate::snapshot::SurfacePoint;

/// Collisions of a walk with fog on a part of its way.
pub(super) struct Collisions<'a> {
    pub(super) along: FoggyRay<'a>,
    pub(super) losses: Losses,
    /// Weights of the colour channels.
    pub(super) weights: Rgb,
    /// Probability that the walk collides at all.
    pub(super) chance: f64,
}

#[derive(Clone, Copy)]
pub(super) struct Collision {
    /// Ray of the walk, with its origin at the collision.
    ray: Ray,
    /// Part of that ray in fog, as distances from the collision.
    range: (f64, f64),
    /// Probability density of the collision, 1/m.
    per_m: f64,
}

impl Collisions<'_> {
    fn per_m(&self, t: f64) -> f64 {
        self.chance * self.along.pdf(self.weights, &self.losses, t)
    }

    /// Collision at a distance along the ray.
    pub(super) fn at(&self, ray: &Ray, t: f64) -> Collision {
        let (start, end) = self.losses.range();
        Collision {
            ray: Ray { origin: ray.at(t), ..*ray },
            range: (start - t, end - t),
            per_m: self.per_m(t),
        }
    }

    /// Radiance of emissive surfaces that fog scatters into the ray before its collisions end, W m^-2 sr^-1.
    /// It is estimated at one point, which is equiangular about a point of an emissive surface. Returns that
    /// point's distance, too.
    pub(super) fn lit(&self, path: &mut Path, ray: &Ray) -> (f64, Rgb) {
        let (snapshot, light) = (path.snapshot, path.light);
        let Some(emissive) = snapshot.emissive().filter(|_| light.has_rest) else {
            return (0.0, Rgb::ZERO);
        };
        let range = self.losses.range();
        let (primitive, position, per_m2) =
            emissive.sample_along(snapshot, (ray, range), path.sampler.next_3d());
        let angle = Angle::of(ray, position);
        let t = angle.sample(range, path.sampler.next_1d());
        let (medium, place) = (&snapshot.medium, ray.at(t));
        let (g, collision) = (medium.anisotropy_at(place), self.at(ray, t));
        let receiver = Receiver {
            place,
            leaving: None,
            scattered: &|to| medium.scattering_at(place, ray.direction.dot(to)),
            pdf: &|_| 0.0,
        };
        let by_point = emissive.pdf_per_m2(snapshot, place, primitive);
        let scattered = receiver.lit_by(snapshot, &Target { primitive, position, per_m2 }, |point| {
            let by_phase = henyey_greenstein_pdf(g, -ray.direction.dot(point.to_eye));
            light.emitted(point) * (1.0 - collision.share(point, by_phase, by_point))
        });
        let through = medium.transmittance(ray.origin, ray.direction, t);
        let sum = through * scattered / angle.per_m(range, t);
        (t, if sum.is_finite() { sum } else { Rgb::ZERO })
    }
}

impl Collision {
    /// Weight of light from a point of an emissive surface. The phase function samples its direction with the
    /// density `by_phase`, 1/sr; the point itself is sampled with `by_point`, 1/m^2.
    pub(super) fn share(&self, point: &SurfacePoint, by_phase: f64, by_point: f64) -> f64 {
        let by_angle = Angle::of(&self.ray, point.position).per_m(self.range, 0.0);
        let by_point = per_sr(by_point, point, self.ray.origin.distance(point.position));
        // Both techniques sample the collision with the same density.
        let by_walk = self.per_m * (1.0 + by_phase / by_point);
        match (by_angle.is_finite(), by_walk.is_finite()) {
            (true, true) => by_walk / (by_walk + by_angle),
            // At the very point equiangular sampling has an infinite density, and so all of the weight.
            (false, _) => 0.0,
            (true, false) => 1.0,
        }
    }
}
