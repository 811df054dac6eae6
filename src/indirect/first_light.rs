//! Where light of lamps and suns is scattered first. In go a snapshot and its lights, out come sources on the grid and the irradiance on walls. Invariant: rays are tied to the
//! world and to the lights, never to leaves, so what a leaf gets changes evenly as it moves.

use super::grid::{Corners, Grid};
use super::harmonics::{COUNT, DEGREE, basis, cosine_lobe};
use super::matter::Matter;
use super::moments::Moments;
use super::swept_fog::SweptFog;
use super::walls::{Patch, Walls};
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::fog::exp_minus;
use crate::light::Emission;
use crate::math::{Ray, kronecker};
use crate::snapshot::{FrozenLight, Luminaire, Snapshot, SurfacePoint};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashSet;
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// Rays of a sun that go through a cell, along each side.
const RAYS_PER_CELL: f64 = 8.0;
/// Of a sun.
const MOST_RAYS: f64 = 100_000.0;
/// Of a lamp.
const LAMP_RAYS: usize = 40_000;
/// Places along a ray where fog takes its share, per cell.
const STEPS_PER_CELL: f64 = 1.0;
/// Groups of rays whose sums are added up in order.
const CHUNKS: usize = 8;
/// Shadow rays to a patch of wall, along each side.
const SHADOW_RAYS: usize = 6;

/// A ray that carries power.
struct PowerRay {
    ray: Ray,
    /// Before any fog, W.
    power: Rgb,
    /// Optical depth before its start, of fog without its forward peaks and of all of it.
    depths: [Rgb; 2],
}

/// What a leaf gets.
struct Landing {
    /// In world space.
    position: DVec3,
    /// The same, on the light's side.
    seen_from: DVec3,
    /// Towards the light.
    normal: DVec3,
    reflected: Rgb,
    transmitted: Rgb,
}

/// A sun's light that fog has scattered, but nearly straight ahead: it still goes as the sun's own does.
#[derive(Clone, Debug)]
pub(super) struct Glow {
    /// Direction of travel.
    pub(super) travel: DVec3,
    /// Irradiance on a plane that faces it, by node, W/m^2.
    pub(super) irradiance: Vec<[f32; 3]>,
}

impl Glow {
    /// On the mean of eight nodes.
    pub(super) fn mean(&self, corners: &Corners) -> Rgb {
        let at =
            |(&node, &weight): (&usize, &f64)| weight * Rgb::from_array(self.irradiance[node].map(f64::from));
        corners.nodes.iter().zip(&corners.weights).map(at).sum()
    }
}

pub(super) struct FirstLight<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) fog: &'a SweptFog<'a>,
    pub(super) grid: &'a Grid,
    pub(super) matter: &'a Matter,
    pub(super) cancelled: &'a (dyn Fn() -> bool + Sync),
    pub(super) walls: &'a Walls,
    /// Triangles that are walls: their light is told by [`FirstLight::irradiances`].
    pub(super) are_walls: HashSet<PrimitiveId>,
}

impl FirstLight<'_> {
    /// What all lights make of fog and leaves, and what of suns goes on nearly straight.
    pub(super) fn sources(&self) -> (Moments, Vec<Glow>) {
        let mut sources = Moments::zero(self.grid.count());
        let mut glows = Vec::new();
        for light in &self.snapshot.lights {
            match light.centre() {
                FrozenLight::Sun { to_light, .. } => {
                    let rays = self.sun_rays(light, to_light);
                    let glow = self.add_rays(&rays, Some(-to_light), &mut sources);
                    glows.extend(glow);
                }
                FrozenLight::Point { .. } => {
                    self.add_rays(&self.lamp_rays(light), None, &mut sources);
                }
            }
        }
        (sources, glows)
    }

    /// Evenly spaced across the sun's direction; where they lie depends on nothing but that.
    fn sun_rays(&self, light: &Luminaire, to_light: DVec3) -> Vec<PowerRay> {
        let (low, high) = self.grid.volume();
        let (right, up) = to_light.any_orthonormal_pair();
        let corners = (0..8).map(|corner| {
            DVec3::new(
                if corner & 1 == 0 { low.x } else { high.x },
                if corner & 2 == 0 { low.y } else { high.y },
                if corner & 4 == 0 { low.z } else { high.z },
            )
        });
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in corners {
            let place = DVec3::new(corner.dot(right), corner.dot(up), corner.dot(to_light));
            (least, most) = (least.min(place), most.max(place));
        }
        let span = most - least;
        let spacing = (self.grid.cell_m / RAYS_PER_CELL).max((span.x * span.y / MOST_RAYS).sqrt());
        let irradiance = mean_irradiance(light);
        let eye = self.snapshot.view.eye;
        let boxes = [self.snapshot.tree.bounds(), self.snapshot.blended.bounds()].into_iter().flatten();
        let farthest =
            boxes.map(|(low, high)| DVec3::select(to_light.cmpgt(DVec3::ZERO), high, low).dot(to_light));
        let start = farthest.fold(most.z - eye.dot(to_light), f64::max) + self.grid.cell_m;
        let first = [least.x, least.y].map(|least| (least / spacing).floor() as i64);
        let last = [most.x, most.y].map(|most| (most / spacing).ceil() as i64);
        let mut rays = Vec::new();
        for row in first[1]..=last[1] {
            for column in first[0]..=last[0] {
                let across = (column as f64 + 0.5) * spacing * right + (row as f64 + 0.5) * spacing * up;
                let across = across - across.dot(to_light) * to_light;
                let relative = across - (eye - eye.dot(to_light) * to_light);
                let origin = relative + start * to_light;
                let depths = [&self.fog.dimming, &self.snapshot.medium]
                    .map(|medium| medium.optical_depth(origin, to_light, f64::INFINITY));
                let ray = Ray { origin, direction: -to_light };
                rays.push(PowerRay { ray, power: spacing * spacing * irradiance, depths });
            }
        }
        rays
    }

    /// Evenly spread over the directions in which the lamp shines.
    fn lamp_rays(&self, light: &Luminaire) -> Vec<PowerRay> {
        let FrozenLight::Point { emission, .. } = light.centre() else { return Vec::new() };
        let (axis, least_cos) = match &emission {
            Emission::Even => (DVec3::Y, -1.0),
            Emission::Spot(cone) => (cone.axis, cone.cos_outer),
            Emission::Flat { normal } => (*normal, 0.0),
        };
        let (right, up) = axis.any_orthonormal_pair();
        let solid_angle = TAU * (1.0 - least_cos) / LAMP_RAYS as f64;
        let ray = |number: usize| {
            let along = 1.0 - (1.0 - least_cos) * (number as f64 + 0.5) / LAMP_RAYS as f64;
            let (sin, cos) = (TAU * kronecker(0.0, number)).sin_cos();
            let across = (1.0 - along * along).max(0.0).sqrt();
            let direction = along * axis + across * (cos * right + sin * up);
            let point = light.point([0.37, 0.11, 0.73].map(|phase| kronecker(phase, number * 7)));
            let FrozenLight::Point { position, intensity, emission } = point else {
                unreachable!("a lamp is one all over")
            };
            let power = solid_angle * intensity * emission.share(direction);
            PowerRay { ray: Ray { origin: position, direction }, power, depths: [Rgb::ZERO; 2] }
        };
        (0..LAMP_RAYS).map(ray).filter(|ray| ray.power != Rgb::ZERO).collect()
    }

    /// `travel` is the direction of all of them, if it is the same.
    fn add_rays(&self, rays: &[PowerRay], travel: Option<DVec3>, sources: &mut Moments) -> Option<Glow> {
        let count = self.grid.count();
        let chunk = rays.len().div_ceil(CHUNKS).max(1);
        let fluences: Vec<(Fluence, Vec<Landing>)> = rays
            .par_chunks(chunk)
            .map(|rays| {
                let mut fluence = Fluence::zero(count, travel.is_none());
                let mut landings = Vec::new();
                for ray in rays {
                    if (self.cancelled)() {
                        break;
                    }
                    self.follow(ray, &mut fluence, &mut landings);
                }
                (fluence, landings)
            })
            .collect();
        let volume = self.grid.cell_volume();
        let basis = travel.map(basis);
        for (fluence, landings) in &fluences {
            for channel in 0..3 {
                for index in 0..COUNT {
                    let shares = self.matter.fog_scattering(channel, DEGREE[index]);
                    let (values, factor) = match &basis {
                        Some(basis) => (fluence.of(channel, 0), basis[index]),
                        None => (fluence.of(channel, index), 1.0),
                    };
                    let factor = (factor / volume) as f32;
                    let into = sources.channel_mut(channel, index);
                    for ((into, value), share) in into.iter_mut().zip(values).zip(shares) {
                        *into += factor * share * value;
                    }
                }
            }
            landings.iter().for_each(|landing| self.land(landing, sources));
        }
        let travel = travel.filter(|_| !self.snapshot.medium.is_empty())?;
        let mut irradiance = vec![[0.0; 3]; count];
        for (fluence, _) in &fluences {
            for (channel, values) in (0..3).map(|channel| (channel, fluence.glow(channel))) {
                for (sum, value) in irradiance.iter_mut().zip(values) {
                    sum[channel] += value / volume as f32;
                }
            }
        }
        Some(Glow { travel, irradiance })
    }

    /// Leaves its light in fog and on leaves, up to where it ends.
    fn follow(
        &self,
        PowerRay { ray, power, depths }: &PowerRay,
        fluence: &mut Fluence,
        landings: &mut Vec<Landing>,
    ) {
        let snapshot = self.snapshot;
        let opaque = snapshot.tree.nearest_hit(ray, f64::INFINITY, None);
        let end = opaque.map_or(f64::INFINITY, |hit| hit.t);
        let mut stops: Vec<(f64, SurfacePoint)> = Vec::new();
        if snapshot.has_blended() {
            let (mut from, mut leaving) = (0.0, None);
            while let Some(hit) = {
                let rest = Ray { origin: ray.at(from), direction: ray.direction };
                snapshot.blended.nearest_hit(&rest, end - from, leaving)
            } {
                let rest = Ray { origin: ray.at(from), direction: ray.direction };
                let point = snapshot.surface(&rest, &hit);
                (from, leaving) = (from + hit.t, Some(hit.primitive));
                stops.push((from, point));
            }
        }
        if let Some(hit) = opaque {
            stops.push((end, snapshot.surface(ray, &hit)));
        }
        let (enter, leave) = self.inside(ray);
        let mut power = *power;
        let mut from = enter;
        for (t, point) in stops.iter().map(|(t, point)| (*t, Some(point))).chain([(f64::INFINITY, None)]) {
            self.light_fog(ray, (from, t.min(leave)), power, depths, fluence);
            from = from.max(t);
            let Some(point) = point.filter(|_| from <= leave + self.grid.cell_m) else { break };
            if !self.are_walls.contains(&point.primitive) && t >= enter - self.grid.cell_m {
                let fog = exp_minus(depths[0] + self.fog.dimming.optical_depth(ray.origin, ray.direction, t));
                landings.push(Landing::of(snapshot, point, power * fog * point.alpha));
            }
            power *= point.see_through;
            if power == Rgb::ZERO {
                break;
            }
        }
    }

    /// The part of a ray that lies in the grid's cells.
    fn inside(&self, ray: &Ray) -> (f64, f64) {
        let (low, high) = self.grid.volume();
        let origin = self.snapshot.world_from_relative(ray.origin);
        let (a, b) = ((low - origin) / ray.direction, (high - origin) / ray.direction);
        // Not a number where the ray runs within a face.
        let enter = a.min(b).to_array().into_iter().fold(0.0, f64::max);
        let leave = a.max(b).to_array().into_iter().fold(f64::INFINITY, f64::min);
        (enter, leave)
    }

    fn light_fog(
        &self,
        ray: &Ray,
        (start, end): (f64, f64),
        power: Rgb,
        depths: &[Rgb; 2],
        fluence: &mut Fluence,
    ) {
        if start >= end || self.snapshot.medium.is_empty() {
            return;
        }
        let steps = ((end - start) * STEPS_PER_CELL / self.grid.cell_m).ceil();
        let step = (end - start) / steps;
        let media = [&self.fog.dimming, &self.snapshot.medium];
        // To the middle of each step by the fog at the middles, which is all that the grid tells of it.
        let mut before =
            [0, 1].map(|which| depths[which] + media[which].optical_depth(ray.origin, ray.direction, start));
        for number in 0..steps as usize {
            let place = ray.at(start + (number as f64 + 0.5) * step);
            let here = [0, 1].map(|which| {
                let half = 0.5 * step * media[which].extinction_at(place);
                let here = power * exp_minus(before[which] + half);
                before[which] += 2.0 * half;
                here
            });
            let place = self.snapshot.world_from_relative(place);
            let corners = self.walls.corners(self.grid, place, place);
            fluence.add(&corners, ray.direction, step * here[0], step * (here[0] - here[1]));
        }
    }

    fn land(&self, landing: &Landing, sources: &mut Moments) {
        let corners = self.walls.corners(self.grid, landing.position, landing.seen_from);
        let (before, behind) = (cosine_lobe(landing.normal), cosine_lobe(-landing.normal));
        for (node, weight) in corners.nodes.into_iter().zip(corners.weights) {
            let factor = weight * FRAC_1_PI / self.grid.cell_volume();
            for channel in 0..3 {
                let (reflected, transmitted) = (landing.reflected[channel], landing.transmitted[channel]);
                let sum = sources.at(channel, node);
                let added = |index: usize| factor * (reflected * before[index] + transmitted * behind[index]);
                sources.set(channel, node, &std::array::from_fn(|index| sum[index] + added(index) as f32));
            }
        }
    }

    /// The irradiance of all lights on each patch of wall, W/m^2.
    pub(super) fn irradiances(&self) -> Vec<Rgb> {
        self.walls
            .patches
            .par_iter()
            .map(|patch| self.snapshot.lights.iter().map(|light| self.irradiance(light, patch)).sum())
            .collect()
    }

    fn irradiance(&self, light: &Luminaire, patch: &Patch) -> Rgb {
        let (right, up) = patch.normal.any_orthonormal_pair();
        // About the middle of the patch's cell, on its plane: where it is depends on no leaf.
        let middle =
            self.grid.position(self.grid.nearest(patch.position + 0.25 * self.grid.cell_m * patch.normal));
        let middle = middle - (middle - patch.position).dot(patch.normal) * patch.normal;
        let step = self.grid.cell_m / SHADOW_RAYS as f64;
        let off_wall = 0.02 * self.grid.cell_m * patch.normal - self.snapshot.view.eye;
        let (mut sum, mut count) = (Rgb::ZERO, 0.0);
        for number in 0..SHADOW_RAYS * SHADOW_RAYS {
            let offset = |index: usize| (index as f64 + 0.5 - 0.5 * SHADOW_RAYS as f64) * step;
            let place = middle + offset(number % SHADOW_RAYS) * right + offset(number / SHADOW_RAYS) * up;
            let (seen, origin) = (patch.position + off_wall, place + off_wall);
            let way = Ray { origin: seen, direction: (origin - seen).normalize_or_zero() };
            // Beyond a corner the wall goes on in another plane.
            if self.snapshot.tree.any_hit(&way, (origin - seen).length(), Some(patch.primitive)) {
                continue;
            }
            count += 1.0;
            let point = light.point([0.3, 0.6, 0.9].map(|phase| kronecker(phase, number)));
            let (to_light, distance, arriving) = point.arriving_at(origin);
            let cos = to_light.dot(patch.normal);
            if cos > 0.0 && arriving != Rgb::ZERO {
                let ray = Ray { origin, direction: to_light };
                sum += cos * arriving * self.reaching(&ray, distance, patch.primitive);
            }
        }
        sum / f64::max(count, 1.0)
    }

    /// What is left of light that comes along a ray from a distance.
    fn reaching(&self, ray: &Ray, distance: f64, from: PrimitiveId) -> Rgb {
        let snapshot = self.snapshot;
        if snapshot.tree.any_hit(ray, distance, Some(from)) {
            return Rgb::ZERO;
        }
        let mut through = self.fog.dimming.transmittance(ray.origin, ray.direction, distance);
        if snapshot.has_blended() {
            let (mut at, mut leaving) = (0.0, Some(from));
            while through.max_element() > 1e-6 {
                let rest = Ray { origin: ray.at(at), direction: ray.direction };
                let Some(hit) = snapshot.blended.nearest_hit(&rest, distance - at, leaving) else { break };
                through *= snapshot.surface(&rest, &hit).see_through;
                (at, leaving) = (at + hit.t, Some(hit.primitive));
            }
        }
        through
    }
}

/// Off a surface, so that rounding does not put it behind a wall that it lies on.
const LITTLE_M: f64 = 1e-6;

impl Landing {
    fn of(snapshot: &Snapshot, point: &SurfacePoint, power: Rgb) -> Self {
        let scatters = super::surroundings::scatters_of(point);
        Self {
            position: snapshot.world_from_relative(point.position),
            seen_from: snapshot.world_from_relative(point.position + LITTLE_M * point.geometric_normal),
            normal: point.geometric_normal,
            reflected: power * scatters.reflectance,
            transmitted: power * scatters.transmittance,
        }
    }
}

/// Power times way, by node: of one direction alone, or by harmonics of the direction.
struct Fluence {
    nodes: usize,
    harmonics: usize,
    values: Vec<f32>,
    /// Of one direction, that part of it that fog has scattered nearly straight ahead.
    glow: Vec<f32>,
}

impl Fluence {
    fn zero(nodes: usize, has_directions: bool) -> Self {
        let harmonics = if has_directions { COUNT } else { 1 };
        let glow = if has_directions { Vec::new() } else { vec![0.0; 3 * nodes] };
        Self { nodes, harmonics, values: vec![0.0; 3 * harmonics * nodes], glow }
    }

    fn glow(&self, channel: usize) -> &[f32] {
        &self.glow[channel * self.nodes..][..self.nodes]
    }

    fn of(&self, channel: usize, index: usize) -> &[f32] {
        &self.values[(channel * self.harmonics + index) * self.nodes..][..self.nodes]
    }

    fn add(&mut self, corners: &Corners, direction: DVec3, amount: Rgb, glow: Rgb) {
        let basis = if self.harmonics == 1 { [1.0; COUNT] } else { basis(direction) };
        for (node, weight) in corners.nodes.into_iter().zip(corners.weights) {
            for channel in 0..3 {
                for (index, value) in basis[..self.harmonics].iter().enumerate() {
                    let place = (channel * self.harmonics + index) * self.nodes + node;
                    self.values[place] += (weight * amount[channel] * value) as f32;
                }
                if let Some(sum) = self.glow.get_mut(channel * self.nodes + node) {
                    *sum += (weight * glow[channel]) as f32;
                }
            }
        }
    }
}

/// Of all of a sun's disc, on a plane that faces it.
fn mean_irradiance(light: &Luminaire) -> Rgb {
    const POINTS: usize = 64;
    if light.is_delta() {
        let FrozenLight::Sun { irradiance, .. } = light.centre() else { return Rgb::ZERO };
        return irradiance;
    }
    let irradiance = |number: usize| match light.point([
        (number as f64 + 0.5) / POINTS as f64,
        kronecker(0.0, number),
        0.5,
    ]) {
        FrozenLight::Sun { irradiance, .. } => irradiance,
        FrozenLight::Point { .. } => Rgb::ZERO,
    };
    (0..POINTS).map(irradiance).sum::<Rgb>() / POINTS as f64
}

/// A wall's radiosity, as radiance.
pub(super) fn radiance(radiosity: Rgb) -> Rgb {
    radiosity / PI
}
