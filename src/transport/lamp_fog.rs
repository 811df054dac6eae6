//! Light of lamps that fog scatters to the vertex of a walk. In go that vertex, or the leg after it, and
//! uniform numbers. Out comes an estimate of that radiance. Invariant: points sampled on a leg and on a
//! lamp's rays have weights that add up to 1, by the balance heuristic (see `connection.rs`).
//!
//! A leg hardly ever crosses a narrow beam, so rays of the lamp sample points there. Lamps that emit in all
//! directions have no such rays: legs meet their light often enough. Nor do lamps in voxels, where optical
//! depths cost more time than they save.

use super::connection::Receiver;
use super::equiangular;
use super::lamp_spots::Lamp;
use super::march::scattered_at;
use super::path::Path;
use super::turn::Turn;
use crate::accel::InstanceTree;
use crate::color::Rgb;
use crate::light::Emission;
use crate::math::Ray;
use crate::snapshot::{FrozenLight, Snapshot};
use glam::DVec3;

/// Radiance of a lamp's light in fog that the receiver scatters, W m^-2 sr^-1.
pub(super) fn scattered(path: &mut Path, receiver: &Receiver) -> Rgb {
    let snapshot = path.snapshot;
    if snapshot.medium.is_empty() {
        return Rgb::ZERO;
    }
    let lamps = beams(snapshot, path.light.lights);
    let count = lamps.clone().count();
    if count == 0 {
        return Rgb::ZERO;
    }
    let [which, u, v] = path.sampler.next_3d();
    let loss = path.sampler.next_2d();
    let Some(lamp) = lamps.clone().nth((which * count as f64) as usize) else { return Rgb::ZERO };
    let Some(place) = picked(snapshot, &lamp.ray([u, v]), loss.into()) else { return Rgb::ZERO };
    let way = place - receiver.place;
    let Some(direction) = way.try_normalize() else { return Rgb::ZERO };
    let scattered = (receiver.scattered)(direction);
    if scattered == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let (ray, distance) = (Ray { origin: receiver.place, direction }, way.length());
    // The leg that samples the same point ends at the first surface behind it.
    let nearest = |tree: &InstanceTree, most: f64| {
        tree.nearest_hit(&ray, most, receiver.leaving).map_or(most, |hit| hit.t)
    };
    let end = nearest(&snapshot.blended, nearest(&snapshot.tree, f64::INFINITY));
    if end <= distance {
        return Rgb::ZERO;
    }
    let radiance = scattered_at(snapshot, &ray, distance, lamp.light, &[]);
    if radiance == Rgb::ZERO {
        return Rgb::ZERO;
    }
    let per_m = equiangular::per_m(path, (&ray, end), lamp.light, distance);
    let by_leg = (receiver.picked)(direction) * per_m;
    let by_lamp = per_m3(snapshot, &lamp, place) * distance * distance;
    let sum = scattered * radiance / (by_leg + by_lamp);
    if sum.is_finite() { sum } else { Rgb::ZERO }
}

/// Lamps whose rays are traced, with the probability of choosing each of them.
fn beams<'a>(snapshot: &Snapshot, lights: &'a [FrozenLight]) -> impl Iterator<Item = Lamp<'a>> + Clone {
    let has_voxels = snapshot.medium.has_voxels();
    let is_beam = move |lamp: &Lamp| !has_voxels && !matches!(lamp.emission, Emission::Even);
    let beams = Lamp::among(lights).filter(is_beam);
    let chance = 1.0 / beams.clone().count() as f64;
    beams.map(move |lamp| Lamp { chance, ..lamp })
}

/// Radiance of lamps that fog scatters into a leg before `distance`, from one point for each lamp. Points are
/// equiangular: near a lamp its light grows as 1 / r^2, and other sampling would have infinite variance.
pub(super) fn on_leg(path: &mut Path, ray: &Ray, turn: Option<Turn>, distance: f64) -> Rgb {
    let snapshot = path.snapshot;
    // Past a blended surface the other technique does not sample.
    let turn = turn.filter(|turn| turn.place == ray.origin);
    let mut sum = Rgb::ZERO;
    let mut beams = beams(snapshot, path.light.lights).peekable();
    for lamp in Lamp::among(path.light.lights) {
        let beam = beams.next_if(|beam| std::ptr::eq(beam.light, lamp.light));
        let Some((t, per_m)) = equiangular::pick(path, ray, distance, lamp.light) else { continue };
        let found = scattered_at(snapshot, ray, t, lamp.light, &[]) / per_m;
        if found == Rgb::ZERO {
            continue;
        }
        let share = |(turn, beam): (Turn, Lamp)| {
            let by_leg = turn.density * per_m;
            by_leg / (by_leg + per_m3(snapshot, &beam, ray.at(t)) * t * t)
        };
        sum += turn.zip(beam).map_or(1.0, share) * found;
    }
    sum
}

/// Samples a point in fog on a ray.
fn picked(snapshot: &Snapshot, ray: &Ray, loss: [f64; 2]) -> Option<DVec3> {
    let along = snapshot.medium.along(ray, f64::INFINITY);
    let losses = along.losses(Rgb::ONE)?;
    Some(ray.at(along.pick_loss(Rgb::ONE, &losses, loss)?.t))
}

/// Probability density with which [`picked`] samples a point on a lamp's rays, 1/m^3.
fn per_m3(snapshot: &Snapshot, lamp: &Lamp, place: DVec3) -> f64 {
    let way = place - lamp.position;
    let Some(direction) = way.try_normalize() else { return 0.0 };
    let per_sr = lamp.chance * lamp.emission.picked(direction);
    if per_sr == 0.0 {
        return 0.0;
    }
    let ray = Ray { origin: lamp.position, direction };
    let along = snapshot.medium.along(&ray, f64::INFINITY);
    let losses = along.losses(Rgb::ONE);
    let per_m = losses.map_or(0.0, |losses| along.picked(Rgb::ONE, &losses, way.length()));
    per_sr * per_m / way.length_squared()
}
