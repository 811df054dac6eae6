//! Light of lamps that a surface scatters to the vertex of a walk. In go that vertex and uniform numbers, out
//! comes an estimate of the radiance that the vertex scatters towards the eye. Invariant: surface points that
//! walks meet and those on a lamp's rays have weights that add up to 1 (see `connection.rs`).
//!
//! A lamp next to a wall lights a small spot there, which reflects half of its light. Walks from the eye
//! hardly ever meet it. So a ray of the lamp samples a point as well: a light subpath of one vertex. See
//! Lafortune & Willems 1993, "Bi-directional path tracing".

use super::connection::{Receiver, Target};
use super::direct;
use super::path::Path;
use super::turn::Turn;
use crate::color::Rgb;
use crate::light::Emission;
use crate::math::Ray;
use crate::snapshot::{FrozenLight, SurfacePoint};
use glam::DVec3;

/// A lamp that rays start from.
pub(super) struct Lamp<'a> {
    pub(super) light: &'a FrozenLight,
    pub(super) position: DVec3,
    pub(super) emission: &'a Emission,
    /// Probability of choosing it.
    pub(super) chance: f64,
}

impl<'a> Lamp<'a> {
    pub(super) fn among(lights: &'a [FrozenLight]) -> impl Iterator<Item = Self> + Clone + 'a {
        let is_lamp = |light: &&FrozenLight| matches!(light, FrozenLight::Point { .. });
        let chance = 1.0 / lights.iter().filter(is_lamp).count() as f64;
        lights.iter().filter_map(move |light| match light {
            FrozenLight::Sun { .. } => None,
            FrozenLight::Point { position, emission, .. } => {
                Some(Self { light, position: *position, emission, chance })
            }
        })
    }

    /// The ray that two uniform numbers sample.
    pub(super) fn ray(&self, u: [f64; 2]) -> Ray {
        Ray { origin: self.position, direction: self.emission.sample(u) }
    }

    /// Probability density with which its rays meet an unoccluded point, 1/m^2.
    fn per_m2(&self, point: DVec3, normal: DVec3) -> f64 {
        let way = point - self.position;
        let Some(direction) = way.try_normalize() else { return 0.0 };
        let per_sr = self.chance * self.emission.pdf(direction);
        per_sr * direction.dot(normal).abs() / way.length_squared()
    }
}

/// Radiance of a spot in a lamp's light that the receiver scatters, W m^-2 sr^-1, from one sampled point.
pub(super) fn scattered(path: &mut Path, receiver: &Receiver) -> Rgb {
    let snapshot = path.snapshot;
    let lamps = Lamp::among(path.light.lights);
    let count = lamps.clone().count();
    if count == 0 {
        return Rgb::ZERO;
    }
    let [which, u, v] = path.sampler.next_3d();
    let Some(lamp) = lamps.clone().nth((which * count as f64) as usize) else { return Rgb::ZERO };
    let ray = lamp.ray([u, v]);
    let Some(hit) = snapshot.casting().nearest_hit(&ray, f64::INFINITY, None) else { return Rgb::ZERO };
    let spot = snapshot.surface(&ray, &hit);
    let per_m2 = lamp.per_m2(spot.position, spot.geometric_normal);
    let target = Target { primitive: hit.primitive, position: spot.position, per_m2 };
    receiver.lit_by(snapshot, &target, |point| direct::of_light(snapshot, lamp.light, point))
}

/// Radiance of lamps' light that a surface met by a walk scatters, weighted for multiple importance sampling.
pub(super) fn met(path: &Path, turn: Option<Turn>, point: &SurfacePoint) -> Rgb {
    let snapshot = path.snapshot;
    let turn = turn.filter(|_| snapshot.ends_light(point.primitive));
    let of_lamp = |lamp: Lamp| {
        let scattered = direct::of_light(snapshot, lamp.light, point);
        let Some(turn) = turn.filter(|_| scattered != Rgb::ZERO) else { return scattered };
        scattered * turn.share_of_met(point, lamp.per_m2(point.position, point.geometric_normal))
    };
    Lamp::among(path.light.lights).map(of_lamp).sum()
}
