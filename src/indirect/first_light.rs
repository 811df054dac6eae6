//! Where light of lamps and suns is scattered first by leaves and fog. In go a snapshot and rays of its lights, out come sources on the grid. Invariant: power is
//! conserved; what a ray carries lands where the ray does.

use super::fluence::{Fluence, Glow};
use super::grid::Grid;
use super::harmonics::{COUNT, DEGREE, basis, cosine_lobe};
use super::matter::Matter;
use super::moments::Moments;
use super::power_rays::{Emitters, PowerRay, of_lamp};
use super::swept_fog::SweptFog;
use super::walls::Walls;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::fog::exp_minus;
use crate::math::Ray;
use crate::snapshot::{FrozenLight, Snapshot, SurfacePoint};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashSet;
use std::f64::consts::FRAC_1_PI;

/// Places along a ray where fog takes its share, per cell.
const STEPS_PER_CELL: f64 = 1.0;
/// Groups of rays whose sums are added up in order.
const CHUNKS: usize = 8;

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

pub(super) struct FirstLight<'a> {
    pub(super) snapshot: &'a Snapshot<'a>,
    pub(super) fog: &'a SweptFog<'a>,
    pub(super) grid: &'a Grid,
    pub(super) matter: &'a Matter,
    pub(super) cancelled: &'a (dyn Fn() -> bool + Sync),
    pub(super) walls: &'a Walls,
    /// Triangles that are walls: their light is another matter, see `wall_light.rs`.
    pub(super) are_walls: HashSet<PrimitiveId>,
}

impl FirstLight<'_> {
    /// What all lights make of fog and leaves, and what of suns goes on nearly straight.
    pub(super) fn sources(&self) -> (Moments, Vec<Glow>) {
        let mut sources = Moments::zero(self.grid.count());
        let mut glows = Vec::new();
        let emitters = Emitters { snapshot: self.snapshot, grid: self.grid, fog: self.fog };
        for light in &self.snapshot.lights {
            match light.centre() {
                FrozenLight::Sun { to_light, .. } => {
                    let rays = emitters.of_sun(light, to_light);
                    let glow = self.add_rays(&rays, Some(-to_light), &mut sources);
                    glows.extend(glow);
                }
                FrozenLight::Point { .. } => {
                    self.add_rays(&of_lamp(light), None, &mut sources);
                }
            }
        }
        (sources, glows)
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
