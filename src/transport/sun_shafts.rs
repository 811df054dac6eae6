//! Light of suns that fog scatters to the vertex of a walk. In go that vertex and uniform numbers, out comes
//! an estimate of the radiance that the vertex scatters towards the eye. Invariant: sunlit fog that walks
//! meet and points on beams have weights that add up to 1 (see `connection.rs`).
//!
//! A shaft of the sun through fog in a room lights the room. Walks from the eye hardly ever collide in it. As
//! lamps' rays do (`lamp_fog.rs`), a ray of the sun samples it, where first walks met such fog (see
//! `sun_beams.rs`). The point on that ray is even in angle from the vertex (Kulla & Fajardo 2012, "Importance
//! Sampling Techniques for Path Tracing in Participating Media").

use super::connection::Receiver;
use super::equiangular::Angle;
use super::march::scattered_at;
use super::path::Path;
use super::sun_beams::{Beam, MetPoint};
use super::turn::Turn;
use crate::color::{Rgb, luminance};
use crate::math::Ray;
use crate::snapshot::{FrozenLight, Snapshot};
use glam::DVec3;

/// Radiance of fog in the sun that the receiver scatters, W m^-2 sr^-1, from one sampled point.
pub(super) fn scattered(path: &mut Path, receiver: &Receiver) -> Rgb {
    let (snapshot, lights) = (path.snapshot, path.light.lights);
    let beams = path.scratch.learned.as_deref().map(|learned| &learned.in_fog);
    let Some(beams) = beams.filter(|beams| !beams.is_empty()) else { return Rgb::ZERO };
    let [which, u, v] = path.sampler.next_3d();
    let Some((beam, along)) = beams.choose(which) else { return Rgb::ZERO };
    let Some(light @ &FrozenLight::Sun { to_light, .. }) = lights.get(beam.light) else { return Rgb::ZERO };
    let ray = beam.ray(to_light, [u, v].into());
    let Some(range) = snapshot.medium.range(&ray, beam.length()) else { return Rgb::ZERO };
    let place = ray.at(Angle::of(&ray, receiver.place).sample(range, along));
    let way = place - receiver.place;
    let Some(direction) = way.try_normalize() else { return Rgb::ZERO };
    let scattered = (receiver.scattered)(direction);
    let by_shaft = per_m3(snapshot, beam, light, (receiver.place, place)) * way.length_squared();
    if scattered == Rgb::ZERO || by_shaft <= 0.0 {
        return Rgb::ZERO;
    }
    let (leg, distance) = (Ray { origin: receiver.place, direction }, way.length());
    // A walk's leg ends at the first surface.
    let mut trees = [&snapshot.tree, &snapshot.blended].into_iter();
    if trees.any(|tree| tree.any_hit(&leg, distance, receiver.leaving)) {
        return Rgb::ZERO;
    }
    let radiance = scattered_at(snapshot, &leg, distance, light, &[]);
    let by_leg = (receiver.pdf)(direction) * collisions_per_m(snapshot, &leg, distance);
    let sum = scattered * radiance / (by_leg + by_shaft);
    if sum.is_finite() { sum } else { Rgb::ZERO }
}

/// Radiance per metre of suns' light that fog scatters at a collision, where `ray` starts, weighted for
/// multiple importance sampling. Until there are beams, it is noted for them.
pub(super) fn met(path: &mut Path, (leg, turn): (&Ray, Option<Turn>), throughput: Rgb, ray: &Ray) -> Rgb {
    let snapshot = path.snapshot;
    // Past a blended surface the other technique does not sample.
    let turn = turn.filter(|turn| turn.place == leg.origin);
    let mut sum = Rgb::ZERO;
    for (number, light) in path.light.lights.iter().enumerate() {
        if !matches!(light, FrozenLight::Sun { .. }) {
            continue;
        }
        let scattered = scattered_at(snapshot, ray, 0.0, light, &[]);
        let share = match (&path.scratch.learned, turn) {
            (Some(learned), Some(turn)) if scattered != Rgb::ZERO => {
                learned.in_fog.of(number).map_or(1.0, |beam| {
                    let distance = turn.place.distance(ray.origin);
                    let by_leg = turn.density * collisions_per_m(snapshot, leg, distance);
                    let by_shaft = per_m3(snapshot, beam, light, (turn.place, ray.origin));
                    by_leg / (by_leg + by_shaft * distance * distance)
                })
            }
            (None, Some(_)) if path.light.indirect_alone => {
                let luminance = luminance(throughput * scattered);
                path.scratch.noted.in_fog.push(MetPoint { light: number, position: ray.origin, luminance });
                1.0
            }
            _ => 1.0,
        };
        sum += share * scattered;
    }
    sum
}

/// Probability density of collisions along a leg, 1/m, by the mean over colour channels. Walks weight the
/// channels, but both techniques need only have the same density here.
fn collisions_per_m(snapshot: &Snapshot, leg: &Ray, distance: f64) -> f64 {
    let medium = &snapshot.medium;
    let through = medium.transmittance(leg.origin, leg.direction, distance);
    (through * medium.extinction_at(leg.at(distance))).element_sum() / 3.0
}

/// Probability density of a place on the rays of a beam, for a vertex, 1/m^3.
fn per_m3(snapshot: &Snapshot, beam: &Beam, light: &FrozenLight, (vertex, place): (DVec3, DVec3)) -> f64 {
    let FrozenLight::Sun { to_light, .. } = light else { return 0.0 };
    let Some((ray, t)) = beam.ray_through(*to_light, place) else { return 0.0 };
    let Some(range) = snapshot.medium.range(&ray, beam.length()) else { return 0.0 };
    if t < range.0 || range.1 < t {
        return 0.0;
    }
    beam.per_m2(light, place, *to_light) * Angle::of(&ray, vertex).per_m(range, t)
}
