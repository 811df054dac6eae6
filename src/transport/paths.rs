//! Light of all orders by random walks: the alternative to the grid of `indirect`. It is unbiased and noisy.
//! In goes a vertex of a camera ray. Out comes an estimate of the indirect radiance that it scatters towards
//! the eye. Invariant: the expected value is the solution of the equation of transfer, without light of more
//! than [`MOST_VERTICES`] scatterings.
//!
//! A walk goes from the eye towards the light (Kajiya 1986, "The rendering equation"). In fog see Pharr,
//! Jakob & Humphreys 2023, "Physically Based Rendering", 4th edition, section 14.2.2. Lights and sky are
//! sampled at each vertex, so no walk need hit them (Veach 1997, "Robust Monte Carlo methods for light
//! transport simulation", section 8.3.1). Emissive surfaces are sampled as well, and met. Lights are those
//! of the camera ray, one point of each. Light transport is linear, so the mean over points is theirs.

use super::connection::Receiver;
use super::direct;
use super::emissive;
use super::emissive_fog_light::{Collision, Collisions};
use super::fog_emission;
use super::lamp_fog;
use super::lamp_spots;
use super::lobes::{matte_share, sample_bsdf};
use super::path::{Illumination, Path};
use super::shared_walks::{First, Root, Second, over};
use super::sky_light;
use super::sun_shafts;
use super::sun_spots;
use super::turn::Turn;
use super::visibility::Way;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::fog::henyey_greenstein_pdf;
use crate::math::Ray;
use crate::scene::Bounces;
use crate::snapshot::SurfacePoint;
use glam::DVec3;
use std::cell::Cell;

/// Maximum number of vertices of a walk. In a closed scene without absorption a walk would never end; light
/// of later vertices is left out.
const MOST_VERTICES: u32 = 1024;
/// Number of first vertices that roulette spares.
const SURE_VERTICES: u32 = 3;

/// A walk between two vertices.
struct Leg {
    ray: Ray,
    /// Throughput from the leg to the eye.
    throughput: Rgb,
    leaving: Option<PrimitiveId>,
    /// Vertex where it began; `None` after a mirror, where lights were not sampled.
    turn: Option<Turn>,
}

/// Start of a walk, or of its continuation.
#[derive(Clone, Copy)]
struct Start {
    /// Number of its next vertex, from 1.
    number: u32,
    /// Largest channel of the throughput at its start.
    at_first: f64,
}

/// Vertex at which light is scattered.
#[derive(Clone, Copy)]
#[allow(clippy::large_enum_variant, reason = "a walk has one at a time, on the stack")]
enum Vertex {
    Surface(SurfacePoint),
    /// A point in fog, with its ray from the eye; and its collision, if anything emits.
    Fog(Ray, Option<Collision>),
}

/// Radiance of indirect light that a surface scatters towards the eye, W m^-2 sr^-1.
pub(super) fn scattered(path: &mut Path, bounces: Bounces, point: &SurfacePoint) -> Rgb {
    // The mirror's reflection is traced by itself.
    let point = SurfacePoint { mirror: Rgb::ZERO, ..*point };
    let (vertex, count) = (Vertex::Surface(point), path.light.branches.at_surfaces);
    let shares = std::mem::take(&mut path.scratch.shares_on_surface);
    let mut root = shares.then(|| Root::new(First::Surface(point), Rgb::ONE, (count, 1.0)));
    let lit = mean_of(path, count, |path| vertex.lit_by_scattered(path, bounces, Rgb::ONE, root.as_mut()));
    path.scratch.roots.on_surface = path.scratch.roots.on_surface.take().or(root);
    lit
}

/// Radiance of indirect light that fog scatters into a camera ray on its way, W m^-2 sr^-1.
pub(super) fn in_scattered(path: &mut Path, bounces: Bounces, ray: &Ray, way: &Way) -> Rgb {
    let medium = &path.snapshot.medium;
    let along = medium.along(ray, way.distance);
    let Some(losses) = along.losses(Rgb::ONE) else { return Rgb::ZERO };
    let collisions = Collisions { along, losses, weights: Rgb::ONE, chance: 1.0 };
    let (count, shares) = (path.light.branches.in_fog, std::mem::take(&mut path.scratch.shares_in_fog));
    mean_of(path, count, |path| {
        let (t, by_emission) = collisions.lit(path, ray);
        let lit = way.seen_through(t) * by_emission;
        let u = path.sampler.next_2d();
        let Some(loss) = collisions.along.sample_loss(Rgb::ONE, &losses, u.into()) else { return lit };
        let throughput = loss.through_per_density * way.seen_through(loss.t);
        let collision = path.snapshot.emissive().map(|_| collisions.at(ray, loss.t));
        let ray = Ray { origin: ray.at(loss.t), ..*ray };
        let vertex = Vertex::Fog(ray, collision);
        let mut root = shares.then(|| Root::new(First::Fog(ray), throughput, (1, 1.0 / f64::from(count))));
        let scattered = vertex.lit_by_scattered(path, bounces, throughput, root.as_mut());
        path.scratch.roots.in_fog.extend(root);
        lit + scattered
    })
}

/// Mean of so many walks. Their random points are stratified together, as those of as many samples of a
/// pixel.
fn mean_of(path: &mut Path, count: u32, mut walk: impl FnMut(&mut Path) -> Rgb) -> Rgb {
    if count == 1 {
        return walk(path);
    }
    let trunk = *path.sampler;
    let (mut sum, mut drawn) = (Rgb::ZERO, 0);
    for number in 0..count {
        *path.sampler = trunk.branch(number, count);
        sum += walk(path);
        drawn += path.sampler.drawn();
    }
    *path.sampler = trunk.after(drawn);
    sum / f64::from(count)
}

/// Radiance along the first leg of a walk, from its next vertex and all later ones. A root takes over the
/// vertices that it shares.
fn walk(path: &mut Path, bounces: Bounces, mut leg: Leg, root: Option<&mut Root>) -> Rgb {
    let first = leg.throughput.max_element();
    let Some(root) = root else { return walk_from(path, bounces, leg, Start { number: 1, at_first: first }) };
    let mut sum = Rgb::ZERO;
    let Some(vertex) = leg.next_vertex(path, &mut sum, true) else { return sum };
    sum += leg.throughput * vertex.met(path, &leg);
    if share(path, root, &leg, &vertex, first) {
        return sum;
    }
    sum += leg.throughput * vertex.lit_by_sampled(path);
    let next = vertex.go_on(path, leg.throughput);
    sum + next.map_or(Rgb::ZERO, |next| walk_from(path, bounces, next, Start { number: 2, at_first: first }))
}

/// Follows a walk from its second vertex, and keeps the light that arrives there with its root, if that may
/// be shared. `first` is the largest channel of its throughput at the root.
fn share(path: &mut Path, root: &mut Root, leg: &Leg, vertex: &Vertex, first: f64) -> bool {
    let Some(point) = vertex.shared() else { return false };
    let Some(density) = root.density(path.snapshot, point, leg.throughput) else { return true };
    let mut arriving = arriving_beside_the_walk(path, point);
    if let Some(next) = vertex.go_on(path, leg.throughput) {
        let direction = next.ray.direction;
        let scattered = leg.throughput * direct::scattered_per_radiance(point, direction);
        if let Some(density) = over(scattered, next.throughput) {
            // Roulette goes on by the throughput to the eye.
            let start = Start { number: 2, at_first: first / (density * next.throughput.max_element()) };
            let next = Leg { throughput: Rgb::splat(1.0 / density), ..next };
            arriving.push((direction, walk_from(path, Bounces::All, next, start)));
        }
    }
    root.keep(Second { point: *point, density, arriving });
    true
}

/// Directions in which light was sampled by brightness, each with the radiance over its density.
fn arriving_beside_the_walk(path: &mut Path, point: &SurfacePoint) -> Vec<(DVec3, Rgb)> {
    let Some((lobes, share)) = matte_share(point) else { return Vec::new() };
    let sampled = Cell::new(DVec3::ZERO);
    let receiver = Receiver {
        place: point.position,
        leaving: Some(point.primitive),
        scattered: &|direction| {
            sampled.set(direction);
            let is_lit = direct::scattered_per_radiance(point, direction) != Rgb::ZERO;
            if is_lit { Rgb::ONE } else { Rgb::ZERO }
        },
        pdf: &|direction| share * lobes.pdf(point, direction),
    };
    let of_emission: Technique = |path, receiver| emissive::scattered(path, receiver, None);
    let techniques = [of_emission].into_iter().chain(beside_the_walk());
    let found = techniques.map(|technique| (technique(path, &receiver), sampled.get()));
    found.filter(|(radiance, _)| *radiance != Rgb::ZERO).map(|(radiance, to)| (to, radiance)).collect()
}

/// Radiance along a leg, from its next vertex and all later ones.
fn walk_from(path: &mut Path, bounces: Bounces, mut leg: Leg, start: Start) -> Rgb {
    let most = match bounces {
        Bounces::UpTo(count) => count.min(MOST_VERTICES),
        Bounces::All => MOST_VERTICES,
    };
    let (mut sum, light) = (Rgb::ZERO, path.light);
    // A last leg that collects emission alone, so that emission is scattered as often as light of lamps.
    let emits = path.snapshot.emissive().is_some() || path.snapshot.medium.emits();
    let legs = most + u32::from(emits);
    for number in start.number..=legs {
        let Some(vertex) = leg.next_vertex(path, &mut sum, number <= most) else { break };
        sum += leg.throughput * vertex.met(path, &leg);
        if number == legs {
            break;
        }
        if number == most {
            path.light = Illumination { lights: &[], sky: false, ..light };
        }
        sum += leg.throughput * vertex.lit_by_sampled(path);
        let Some(next) = vertex.go_on(path, leg.throughput) else { break };
        leg = next;
        // Russian roulette by the throughput, as a fraction of the walk's first.
        let survives = (leg.throughput.max_element() / start.at_first).min(1.0);
        if number >= SURE_VERTICES && survives < 1.0 {
            if path.sampler.next_1d() >= survives {
                break;
            }
            leg.throughput /= survives;
        }
    }
    path.light = light;
    sum
}

impl Leg {
    /// Next vertex, where the leg's light is scattered; `None` if the leg leaves the scene. Adds light of
    /// lamps on the way to `sum`, and emission too if the leg `is_lit` by it.
    fn next_vertex(&mut self, path: &mut Path, sum: &mut Rgb, is_lit: bool) -> Option<Vertex> {
        let snapshot = path.snapshot;
        loop {
            let opaque = snapshot.tree.nearest_hit(&self.ray, f64::INFINITY, self.leaving);
            let end = opaque.map_or(f64::INFINITY, |hit| hit.t);
            let blended = snapshot.blended.nearest_hit(&self.ray, end, self.leaving);
            let hit = blended.or(opaque);
            let distance = hit.map_or(f64::INFINITY, |hit| hit.t);
            *sum += self.throughput * lamp_fog::on_leg(path, &self.ray, self.turn, distance);
            let way = Way { distance, ..Way::default() };
            *sum += self.throughput * fog_emission::on_the_way(path, &self.ray, &way);
            if let Some(vertex) = self.lost_in_fog(path, distance, is_lit.then_some(&mut *sum)) {
                return Some(vertex);
            }
            let Some(hit) = hit else {
                *sum += self.throughput * self.beyond(path);
                return None;
            };
            let point = snapshot.surface(&self.ray, &hit);
            if blended.is_none() || !self.passes(path, &point) {
                return Some(Vertex::Surface(point));
            }
            (self.ray.origin, self.leaving) = (point.position, Some(point.primitive));
        }
    }

    /// Samples a collision with fog before `distance`. The throughput is then that of a collision per metre
    /// at this point. Light of emissive surfaces on the way is added to `lit`.
    fn lost_in_fog(&mut self, path: &mut Path, distance: f64, lit: Option<&mut Rgb>) -> Option<Vertex> {
        let (medium, ray, weights) = (&path.snapshot.medium, self.ray, self.throughput);
        let along = medium.along(&ray, distance);
        let losses = along.losses(weights)?;
        let emissive = path.snapshot.emissive();
        let collisions = Collisions { along, losses, weights, chance: losses.chance };
        if let Some(sum) = lit.filter(|_| emissive.is_some()) {
            *sum += self.throughput * collisions.lit(path, &ray).1;
        }
        let (u, v) = path.sampler.next_2d();
        if u >= losses.chance {
            let through = medium.transmittance(self.ray.origin, self.ray.direction, distance);
            self.throughput *= through / (1.0 - losses.chance);
            return None;
        }
        let loss = collisions.along.sample_loss(weights, &losses, [u / losses.chance, v])?;
        self.throughput *= loss.through_per_density / losses.chance;
        let collision = emissive.map(|_| collisions.at(&ray, loss.t));
        Some(Vertex::Fog(Ray { origin: ray.at(loss.t), ..ray }, collision))
    }

    /// Whether the walk passes a blended surface; chosen at random.
    fn passes(&mut self, path: &mut Path, point: &SurfacePoint) -> bool {
        let [seen_through, stopped] =
            [point.see_through, Rgb::splat(point.alpha)].map(|share| (self.throughput * share).element_sum());
        let chance = seen_through / (seen_through + stopped);
        let passes = path.sampler.next_1d() < chance;
        self.throughput *=
            if passes { point.see_through / chance } else { Rgb::splat(point.alpha / (1.0 - chance)) };
        passes
    }

    /// Radiance of the sky in a mirror: all other vertices sampled the sky before.
    fn beyond(&self, path: &Path) -> Rgb {
        if self.turn.is_some() {
            return Rgb::ZERO;
        }
        let (snapshot, direction) = (path.snapshot, self.ray.direction);
        let sky = snapshot.sky.as_ref().filter(|sky| path.light.sky && sky.lights_surfaces());
        sky.map_or(Rgb::ZERO, |sky| sky.along(direction))
    }
}

impl Vertex {
    /// The surface, if walks from other vertices may share it: a matte one scatters about alike to all sides.
    /// Fog that scatters ahead does not.
    fn shared(&self) -> Option<&SurfacePoint> {
        let Self::Surface(point) = self else { return None };
        let is_smooth = point.mirror != Rgb::ZERO || point.gloss.is_some();
        let is_matte = !is_smooth && point.dielectric.is_none() && point.layers.is_none();
        is_matte.then_some(point)
    }

    /// Radiance towards the eye of emission and of indirect light, times a throughput.
    fn lit_by_scattered(
        &self,
        path: &mut Path,
        bounces: Bounces,
        throughput: Rgb,
        root: Option<&mut Root>,
    ) -> Rgb {
        let sampled = throughput * self.lit_by_sampled(path);
        sampled + self.go_on(path, throughput).map_or(Rgb::ZERO, |leg| walk(path, bounces, leg, root))
    }

    /// Radiance that a walk meets after its turn, in fog per metre: emission, and light that was not
    /// scattered before.
    fn met(&self, path: &mut Path, &Leg { turn, throughput, ray: leg, .. }: &Leg) -> Rgb {
        match self {
            Self::Surface(point) => {
                let of_suns = sun_spots::met(path, (turn, throughput), point);
                let of_lamps = lamp_spots::met(path, turn, point);
                emissive::met(path, turn, point) + of_suns + of_lamps + sky_light::by_surface(path, point)
            }
            Self::Fog(ray, _) => {
                // Light of lamps was sampled along the leg.
                let of_suns = sun_shafts::met(path, (&leg, turn), throughput, ray);
                of_suns + sky_light::by_fog(path, ray.origin, ray.direction)
            }
        }
    }

    /// Radiance towards the eye, in fog per metre, from points sampled by brightness.
    fn lit_by_sampled(&self, path: &mut Path) -> Rgb {
        match self {
            Self::Surface(point) => {
                let Some((lobes, share)) = matte_share(point) else { return Rgb::ZERO };
                let receiver = Receiver {
                    place: point.position,
                    leaving: Some(point.primitive),
                    scattered: &|direction| direct::scattered_per_radiance(point, direction),
                    pdf: &|direction| share * lobes.pdf(point, direction),
                };
                lit_beside_the_walk(path, &receiver, None)
            }
            Self::Fog(Ray { origin, direction }, collision) => {
                let medium = &path.snapshot.medium;
                let g = medium.anisotropy_at(*origin);
                let receiver = Receiver {
                    place: *origin,
                    leaving: None,
                    scattered: &|to| medium.scattering_at(*origin, direction.dot(to)),
                    pdf: &|to| henyey_greenstein_pdf(g, direction.dot(to)),
                };
                lit_beside_the_walk(path, &receiver, collision.as_ref())
            }
        }
    }

    /// The next leg, in a sampled direction; `None` if its throughput is 0.
    fn go_on(&self, path: &mut Path, throughput: Rgb) -> Option<Leg> {
        let leg = match self {
            Self::Surface(point) => {
                let (direction, weight, density) = sample_bsdf(point, path.sampler.next_2d())?;
                let ray = Ray { origin: point.position, direction };
                let turn = density.map(|density| Turn { place: point.position, density, collision: None });
                Leg { ray, throughput: throughput * weight, leaving: Some(point.primitive), turn }
            }
            Self::Fog(Ray { origin, direction }, collision) => {
                let medium = &path.snapshot.medium;
                let (towards, weight) =
                    medium.sample_scattering(*origin, *direction, throughput, path.sampler.next_3d())?;
                let ray = Ray { origin: *origin, direction: towards };
                // In overlapping fogs the mean anisotropy: both techniques for emissive surfaces use it in
                // their weights.
                let density = henyey_greenstein_pdf(medium.anisotropy_at(*origin), direction.dot(towards));
                let turn = Some(Turn { place: *origin, density, collision: *collision });
                Leg { ray, throughput: throughput * weight, leaving: None, turn }
            }
        };
        (leg.throughput.is_finite() && leg.throughput.max_element() > 0.0).then_some(leg)
    }
}

/// Radiance of points sampled by brightness, as a vertex scatters it towards the eye.
fn lit_beside_the_walk(path: &mut Path, receiver: &Receiver, collision: Option<&Collision>) -> Rgb {
    let of_emission = emissive::scattered(path, receiver, collision);
    beside_the_walk().iter().fold(of_emission, |sum, technique| sum + technique(path, receiver))
}

/// Samples a point of light, and returns the radiance that a receiver scatters of it.
type Technique = fn(&mut Path, &Receiver) -> Rgb;

/// Techniques for light of lamps and suns.
fn beside_the_walk() -> [Technique; 4] {
    [lamp_spots::scattered, sun_spots::scattered, sun_shafts::scattered, lamp_fog::scattered]
}
