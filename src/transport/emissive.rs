//! Light of emissive surfaces, scattered once. In go a vertex of a random walk, or a surface whose other
//! indirect light is from a grid, and uniform numbers. Out comes an estimate of the radiance that the vertex
//! scatters towards the eye. Invariant: points that walks meet and points sampled by power have weights that
//! add up to 1 (see `connection.rs`).

use super::connection::{Receiver, Target};
use super::direct::scattered_per_radiance;
use super::emissive_fog_light::Collision;
use super::lobes::Lobes;
use super::path::Path;
use super::turn::Turn;
use crate::color::Rgb;
use crate::math::Ray;
use crate::snapshot::SurfacePoint;
use glam::{DVec2, DVec3};

/// Probability of sampling a point of an emissive surface, rather than a direction by the BSDF: where
/// emissive surfaces are small and far, and where they are all around.
const SHARES_OF_POINTS: [f64; 2] = [0.9, 0.25];

/// Radiance of emissive surfaces that a surface scatters towards the eye, W m^-2 sr^-1, by one ray. Its
/// direction is to a sampled point or sampled by the BSDF. Other rays find a share of the specular part.
pub(super) fn by_surface(path: &mut Path, point: &SurfacePoint, share_of_others: f64) -> Rgb {
    let (Some(lobes), Some(emissive)) = (Lobes::of(point), path.snapshot.emissive()) else {
        return Rgb::ZERO;
    };
    let [far, about] = SHARES_OF_POINTS;
    let share_of_points = far + (about - far) * emissive.nearness(point.position);
    let specular = SurfacePoint { albedo: Rgb::ZERO, transmission: Rgb::ZERO, ..*point };
    let of_others = |direction| match share_of_others {
        0.0 => Rgb::ZERO,
        share => share * scattered_per_radiance(&specular, direction),
    };
    let receiver = Receiver {
        place: point.position,
        leaving: Some(point.primitive),
        scattered: &|to| (scattered_per_radiance(point, to) - of_others(to)).max(Rgb::ZERO),
        // One of the two techniques is chosen for each ray.
        pdf: &|to| (1.0 / share_of_points - 1.0) * lobes.pdf(point, to),
    };
    if path.sampler.next_1d() < share_of_points {
        return scattered(path, &receiver, None) / share_of_points;
    }
    let direction = lobes.sample(point, DVec2::from(path.sampler.next_2d()));
    let per_picked =
        (receiver.scattered)(direction) / ((1.0 - share_of_points) * lobes.pdf(point, direction));
    if per_picked.is_finite() { met_along(path, &receiver, (direction, per_picked)) } else { Rgb::ZERO }
}

/// Radiance that a receiver scatters of emission that it meets in a direction sampled by its BSDF, weighted
/// for multiple importance sampling. `through` is the throughput of that direction.
fn met_along(path: &Path, receiver: &Receiver, (direction, mut through): (DVec3, Rgb)) -> Rgb {
    if through == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let snapshot = path.snapshot;
    let ray = Ray { origin: receiver.place, direction };
    let density = (receiver.pdf)(direction);
    let turn = Some(Turn { place: receiver.place, density, collision: None });
    let opaque = snapshot.tree.nearest_hit(&ray, f64::INFINITY, receiver.leaving);
    let end = opaque.map_or(f64::INFINITY, |hit| hit.t);
    let mut sum = Rgb::ZERO;
    let mut meet = |point: &SurfacePoint, t: f64| {
        let emitted = met(path, turn, point);
        if emitted != Rgb::ZERO {
            sum += through * point.alpha * emitted * snapshot.medium.transmittance(ray.origin, direction, t);
        }
        through *= point.see_through;
    };
    for hit in snapshot.blended_hits(&ray, &(0.0..end), receiver.leaving) {
        meet(&hit.point, hit.t);
    }
    if let Some(hit) = opaque {
        meet(&snapshot.surface(&ray, &hit), hit.t);
    }
    sum
}

/// Radiance of a sampled point of an emissive surface that the receiver scatters, W m^-2 sr^-1; in fog after
/// a collision.
pub(super) fn scattered(path: &mut Path, receiver: &Receiver, collision: Option<&Collision>) -> Rgb {
    let (snapshot, light) = (path.snapshot, path.light);
    let Some(emissive) = snapshot.emissive().filter(|_| light.has_rest) else { return Rgb::ZERO };
    let (primitive, position) = emissive.sample(snapshot, receiver.place, path.sampler.next_3d());
    let target =
        Target { primitive, position, per_m2: emissive.pdf_per_m2(snapshot, receiver.place, primitive) };
    receiver.lit_by(snapshot, &target, |point| {
        let by_phase =
            |collision: &Collision| collision.share(point, (receiver.pdf)(-point.to_eye), target.per_m2);
        collision.map_or(1.0, by_phase) * light.emitted(point)
    })
}

/// Emission of a surface that a walk meets, weighted for multiple importance sampling; with weight 1 after a
/// mirror.
pub(super) fn met(path: &Path, turn: Option<Turn>, point: &SurfacePoint) -> Rgb {
    let emitted = path.light.emitted(point);
    let (Some(turn), Some(emissive)) = (turn, path.snapshot.emissive()) else { return emitted };
    let per_m2 = emissive.pdf_per_m2(path.snapshot, turn.place, point.primitive);
    let share = turn.collision.map_or(1.0, |collision| collision.share(point, turn.density, per_m2));
    share * emitted * turn.share_of_met(point, per_m2)
}
