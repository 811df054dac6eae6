//! Light of lamps that fog scatters to the vertex of a walk. In go that vertex, or the leg after it, and
//! uniform numbers. Out comes an estimate of that radiance. Invariant: points sampled on a leg and on a
//! lamp's rays have weights that add up to 1, by the balance heuristic (see `connection.rs`).
//!
//! A leg hardly ever crosses a narrow beam. One that passes a lamp at a distance h has light in proportion to
//! 1 / h, with infinite variance. So direction and distance to a point near the lamp are sampled jointly, on
//! a ray of the lamp (Georgiev, Křivánek, Hachisuka, Nowrouzezahrai & Jarosz 2013, "Joint importance sampling
//! of low-order volumetric scattering").

use super::connection::Receiver;
use super::equiangular;
use super::lamp_spots::Lamp;
use super::march::scattered_at;
use super::path::Path;
use super::turn::Turn;
use crate::accel::InstanceTree;
use crate::color::Rgb;
use crate::math::Ray;
use glam::DVec3;

/// Radiance of a lamp's light in fog that the receiver scatters, W m^-2 sr^-1.
pub(super) fn scattered(path: &mut Path, receiver: &Receiver) -> Rgb {
    let snapshot = path.snapshot;
    let lamps = Lamp::among(path.light.lights);
    let count = lamps.clone().count();
    if count == 0 || snapshot.medium.is_empty() {
        return Rgb::ZERO;
    }
    let [which, u, v] = path.sampler.next_3d();
    let Some(lamp) = lamps.clone().nth((which * count as f64) as usize) else { return Rgb::ZERO };
    let reach = Reach::of(&lamp, receiver.place);
    let place = lamp.ray([u, v]).at(reach.sample(path.sampler.next_1d()));
    let way = place - receiver.place;
    let Some(direction) = way.try_normalize() else { return Rgb::ZERO };
    let scattered = (receiver.scattered)(direction);
    if scattered == Rgb::ZERO || snapshot.medium.extinction_at(place) == Rgb::ZERO {
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
    let by_leg = (receiver.pdf)(direction) * per_m;
    let by_lamp = reach.per_m3(&lamp, place) * distance * distance;
    let sum = scattered * radiance / (by_leg + by_lamp);
    // At the lamp itself the density is undefined.
    if by_lamp > 0.0 && sum.is_finite() { sum } else { Rgb::ZERO }
}

/// Radiance of lamps that fog scatters into a leg before `distance`, from one point for each lamp. Points are
/// equiangular: near a lamp its light grows as 1 / r^2, and other sampling would have infinite variance.
pub(super) fn on_leg(path: &mut Path, ray: &Ray, turn: Option<Turn>, distance: f64) -> Rgb {
    let snapshot = path.snapshot;
    // Past a blended surface the other technique does not sample.
    let turn = turn.filter(|turn| turn.place == ray.origin);
    let mut sum = Rgb::ZERO;
    for lamp in Lamp::among(path.light.lights) {
        let Some((t, per_m)) = equiangular::sample(path, ray, distance, lamp.light) else { continue };
        let found = scattered_at(snapshot, ray, t, lamp.light, &[]) / per_m;
        if found == Rgb::ZERO {
            continue;
        }
        let share = |turn: Turn| {
            let by_leg = turn.density * per_m;
            by_leg / (by_leg + Reach::of(&lamp, turn.place).per_m3(&lamp, ray.at(t)) * t * t)
        };
        sum += turn.map_or(1.0, share) * found;
    }
    sum
}

/// Scale of the distances sampled along a lamp's rays, metres: half of them are shorter. It is the vertex's
/// distance from the lamp, and needs neither fog nor walls.
struct Reach(f64);

impl Reach {
    fn of(lamp: &Lamp, vertex: DVec3) -> Self {
        Self(vertex.distance(lamp.position))
    }

    /// Maps a uniform number to a distance from the lamp, metres.
    fn sample(&self, u: f64) -> f64 {
        self.0 * u / (1.0 - u)
    }

    /// Probability density of a point on the lamp's rays, 1/m^3.
    fn per_m3(&self, lamp: &Lamp, place: DVec3) -> f64 {
        let way = place - lamp.position;
        let (Some(direction), distance) = (way.try_normalize(), way.length()) else { return 0.0 };
        let per_m = self.0 / (self.0 + distance).powi(2);
        lamp.chance * lamp.emission.pdf(direction) * per_m / (distance * distance)
    }
}
