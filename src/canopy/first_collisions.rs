//! First collisions of lamps' and suns' light with leaves and fog. In go a snapshot and rays of its lights,
//! out come sources on the grid. Invariant: power is conserved, and is deposited where the ray collides.

use super::delta_scaled_fog::{DeltaScaledFog, scatters_ahead};
use super::emitter_rays::{BUNDLE, Emitters, PowerRay, of_lamp};
use super::fluence::{Fluence, ForwardPeak};
use super::leaf_index::LeafIndex;
use super::leaf_power::{self, LeafHit, LeafPower};
use super::surface_optics::{cover_of, optics_of};
use super::turbid_medium::TurbidMedium;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::fog::{exp_minus, exp_minus_with_mean};
use crate::math::Ray;
use crate::ordinates::first_collision_source::BeamSource;
use crate::ordinates::grid::CellInterval;
use crate::ordinates::harmonics::{DEGREE, basis, cosine_lobe};
use crate::ordinates::moments::{Moments, NodeMoments};
use crate::ordinates::occluders::{CutGrid, OFF_WALL};
use crate::snapshot::{FrozenLight, Snapshot, SurfacePoint};
use glam::DVec3;
use rayon::prelude::*;
use std::collections::HashSet;
use std::f64::consts::FRAC_1_PI;

/// Number of groups of rays, whose sums are added up in order.
const CHUNKS: usize = 8;

/// Distance from a leaf, in cells, at which its scattered light begins. Its area is spread as far to either
/// side, and its lit side must not light the other.
const AWAY: f64 = 0.8;

/// Collisions of a group of rays.
struct Left {
    fluence: Fluence,
    /// Sources from leaves that scatter it.
    scattered: NodeMoments,
    /// Power that collides again with leaves of the same clump, W m^-3 by node.
    met_again: Vec<[f32; 3]>,
    /// Hits on leaves, in the order of the rays.
    on_leaves: Vec<LeafHit>,
}

/// Sources of all first collisions.
pub(crate) struct Found {
    /// Sources by harmonics, of leaves and fog.
    pub(crate) sources: Moments,
    /// Sources of suns in fog, in degrees beyond the harmonics.
    pub(crate) beams: Vec<BeamSource>,
    pub(crate) forward_peaks: Vec<ForwardPeak>,
    /// Power that collides again with leaves of the same clump, W m^-3 by node.
    pub(crate) met_again: Vec<[f32; 3]>,
    pub(crate) on_leaves: LeafPower,
}

pub(crate) struct FirstCollisions<'a> {
    pub(crate) snapshot: &'a Snapshot<'a>,
    pub(crate) fog: &'a DeltaScaledFog<'a>,
    pub(crate) cut: CutGrid<'a>,
    pub(crate) medium: &'a TurbidMedium,
    pub(crate) cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Triangles that are walls: `wall_light.rs` computes their light.
    pub(crate) are_walls: &'a HashSet<PrimitiveId>,
    pub(crate) leaves: &'a LeafIndex,
}

impl FirstCollisions<'_> {
    /// Computes the first collisions of all lights.
    pub(crate) fn found(&self) -> Found {
        let nothing = Moments::zero(self.cut.grid.count());
        let (beams, forward_peaks, met_again) = (Vec::new(), Vec::new(), self.nothing_met());
        let on_leaves = LeafPower::zero(self.leaves.all().len());
        let mut found = Found { sources: nothing, beams, forward_peaks, met_again, on_leaves };
        let emitters = Emitters { snapshot: self.snapshot, grid: self.cut.grid, fog: self.fog };
        let per_volume = self.per_volume();
        for light in &self.snapshot.lights {
            match light.centre() {
                FrozenLight::Sun { to_light, .. } => {
                    let groups = self.followed(&emitters.of_sun(light, to_light));
                    add_on_leaves(&groups, &mut found);
                    self.add_sun(-to_light, &groups, &per_volume, &mut found);
                }
                FrozenLight::Point { .. } => {
                    let groups = self.followed(&of_lamp(light));
                    add_on_leaves(&groups, &mut found);
                    self.add_lamp(&groups, &per_volume, &mut found.sources);
                }
            }
        }
        self.send_from_leaves(&mut found);
        found
    }

    /// Zero power for each node, where there are clumps.
    fn nothing_met(&self) -> Vec<[f32; 3]> {
        vec![[0.0; 3]; if self.medium.clumping.is_none() { 0 } else { self.cut.grid.count() }]
    }

    /// Collisions of rays, group by group.
    fn followed(&self, rays: &[PowerRay]) -> Vec<Left> {
        let count = self.cut.grid.count();
        let chunk = rays.len().div_ceil(CHUNKS).max(1).next_multiple_of(BUNDLE);
        let groups = rays.par_chunks(chunk).map(|rays| {
            let has_directions = !rays[0].is_of_sun;
            let mut left = Left {
                fluence: Fluence::zero(count, has_directions),
                scattered: NodeMoments::zero(count),
                met_again: self.nothing_met(),
                on_leaves: Vec::new(),
            };
            for rays in rays.chunks(BUNDLE) {
                if (self.cancelled)() {
                    break;
                }
                self.follow(rays, &mut left);
            }
            left
        });
        groups.collect()
    }

    fn add_lamp(&self, groups: &[Left], per_volume: &[f32], sources: &mut Moments) {
        for Left { fluence, scattered, .. } in groups {
            for channel in 0..3 {
                let peaks = &self.medium.first_peak[channel];
                for (index, degree) in DEGREE.into_iter().enumerate() {
                    let shares = &self.medium.first_scattering[channel][degree];
                    let into = sources.channel_mut(channel, index);
                    for (node, value) in fluence.of(channel, index).enumerate() {
                        into[node] += per_volume[node] * (shares[node] + peaks[node]) * value;
                    }
                }
            }
            sources.add_nodes(scattered, 1.0);
        }
    }

    fn add_sun(&self, travel: DVec3, groups: &[Left], per_volume: &[f32], found: &mut Found) {
        let count = self.cut.grid.count();
        let mut irradiance = [const { Vec::new() }; 3].map(|_: Vec<f32>| vec![0.0; count]);
        let mut peak = vec![[0.0; 3]; count];
        for Left { fluence, scattered, .. } in groups {
            for channel in 0..3 {
                for (node, value) in fluence.of(channel, 0).enumerate() {
                    irradiance[channel][node] += per_volume[node] * value;
                }
                for (node, value) in fluence.peak(channel).enumerate() {
                    peak[node][channel] += per_volume[node] * value;
                }
            }
            found.sources.add_nodes(scattered, 1.0);
        }
        if self.snapshot.medium.is_empty() {
            return;
        }
        let basis = basis(travel).map(|value| value as f32);
        for channel in 0..3 {
            for (index, degree) in DEGREE.into_iter().enumerate() {
                let shares = &self.medium.first_scattering[channel][degree];
                let into = found.sources.channel_mut(channel, index).iter_mut();
                for ((into, irradiance), share) in into.zip(&irradiance[channel]).zip(shares) {
                    *into += basis[index] * share * irradiance;
                }
            }
        }
        if self.snapshot.medium.banks().iter().any(scatters_ahead) {
            found.beams.push(BeamSource::new(travel, &irradiance, &self.medium.first_scattering));
        }
        let all = |node: usize| irradiance.iter().map(|channel| channel[node]).sum();
        let times = peak.iter().enumerate().map(|(node, peak)| mean_times(peak.iter().sum(), all(node)));
        found.forward_peaks.push(ForwardPeak { travel, times: times.collect(), irradiance: peak });
    }

    /// Inverse of the volume that each node represents, 1/m^3: walls cut pieces off cells.
    fn per_volume(&self) -> Vec<f32> {
        /// Minimum share of a cell: less has too few collisions for an estimate.
        const LEAST: f32 = 0.1;
        let per_cell = (1.0 / self.cut.grid.cell_volume()) as f32;
        let shares = self.cut.occluders.shares(self.cut.grid).into_iter();
        shares.map(|share| per_cell / share.max(LEAST)).collect()
    }

    /// Deposits the light of rays in fog and on leaves, up to their ends.
    fn follow(&self, rays: &[PowerRay], left: &mut Left) {
        let mut ends: Vec<(f64, &PowerRay)> = Vec::with_capacity(BUNDLE);
        for ray in rays {
            let stops = self.stops(&ray.ray);
            match &stops[..] {
                [] if ray.is_of_sun => ends.push((f64::INFINITY, ray)),
                [(t, point)] if ray.is_of_sun && point.see_through == Rgb::ZERO => {
                    self.land_at(ray, (*t, point), ray.power, left);
                    ends.push((*t, ray));
                }
                _ => self.follow_alone(ray, &stops, left),
            }
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut start = 0.0;
        for first in 0..ends.len() {
            let end = ends[first].0;
            if end > start {
                let together = PowerRay::together(ends[first..].iter().map(|(_, ray)| *ray));
                self.light_fog(&together, (start, end), together.power, &mut left.fluence);
                start = end;
            }
        }
    }

    /// Surfaces that a ray meets, up to the first opaque one.
    fn stops(&self, ray: &Ray) -> Vec<(f64, SurfacePoint)> {
        let snapshot = self.snapshot;
        let opaque = snapshot.tree.nearest_hit(ray, f64::INFINITY, None);
        let end = opaque.map_or(f64::INFINITY, |hit| hit.t);
        let blended = snapshot.blended_hits(ray, &(0.0..end), None).into_iter();
        blended
            .map(|hit| (hit.t, hit.point))
            .chain(opaque.map(|hit| (end, snapshot.surface(ray, &hit))))
            .collect()
    }

    fn follow_alone(&self, from: &PowerRay, stops: &[(f64, SurfacePoint)], left: &mut Left) {
        let mut power = from.power;
        let mut start = 0.0;
        for (t, point) in stops.iter().map(|(t, point)| (*t, Some(point))).chain([(f64::INFINITY, None)]) {
            self.light_fog(from, (start, t), power, &mut left.fluence);
            start = t;
            let Some(point) = point else { break };
            self.land_at(from, (t, point), power, left);
            power *= point.see_through;
            if power == Rgb::ZERO {
                break;
            }
        }
    }

    /// Deposits a ray's power on a surface, if that is in the grid and no wall.
    fn land_at(&self, from: &PowerRay, (t, point): (f64, &SurfacePoint), power: Rgb, left: &mut Left) {
        let ray = &from.ray;
        let (enter, leave) = self.inside(ray);
        let is_inside = (enter - self.cut.grid.cell_m..=leave + self.cut.grid.cell_m).contains(&t);
        if is_inside && !self.are_walls.contains(&point.primitive) {
            let dimming = self.fog.dimming_of(from.is_of_sun);
            let fog = exp_minus(from.depths[0] + dimming.rough_optical_depth(ray, t));
            self.land(point, from.shape.share(point.position) * power * fog * cover_of(point), left);
        }
    }

    /// Range of a ray within the grid's cells.
    fn inside(&self, ray: &Ray) -> (f64, f64) {
        let (low, high) = self.cut.grid.volume();
        let origin = self.snapshot.world_from_relative(ray.origin);
        let (a, b) = ((low - origin) / ray.direction, (high - origin) / ray.direction);
        // Not a number where the ray lies in a face of the box.
        let enter = a.min(b).to_array().into_iter().fold(0.0, f64::max);
        let leave = a.max(b).to_array().into_iter().fold(f64::INFINITY, f64::min);
        (enter, leave)
    }

    fn light_fog(
        &self,
        PowerRay { ray, depths, is_of_sun, shape, .. }: &PowerRay,
        (start, end): (f64, f64),
        power: Rgb,
        fluence: &mut Fluence,
    ) {
        let (enter, leave) = self.inside(ray);
        let (start, end) = (start.max(enter), end.min(leave));
        if start >= end || self.snapshot.medium.is_empty() {
            return;
        }
        let media = [self.fog.dimming_of(*is_of_sun), &self.snapshot.medium];
        let mut left = [0, 1]
            .map(|which| power * exp_minus(depths[which] + media[which].rough_optical_depth(ray, start)));
        let in_world = Ray { origin: self.snapshot.world_from_relative(ray.origin), ..*ray };
        let spans = self.snapshot.medium.spans(ray);
        for CellInterval { node, from, to } in self.cut.grid.intervals(&in_world, start, end) {
            let (length, middle) = (to - from, 0.5 * (from + to));
            // The mean over the fog of the interval, so what collides is what is missing behind it.
            let here = [0, 1].map(|which| {
                let depth = media[which].optical_depth_between((ray, &spans), from, to);
                let (through, mean) = exp_minus_with_mean(depth);
                let here = left[which] * mean;
                left[which] *= through;
                here
            });
            let length = length * shape.share_in_fog(ray.at(middle));
            let (amount, peak) = (length * here[0], length * (here[0] - here[1]));
            if self.cut.occluders.are_near(node) {
                let place = in_world.at(middle);
                let corners = self.cut.occluders.cell_of(self.cut.grid, place);
                fluence.add(corners.iter(), ray.direction, amount, peak);
            } else {
                fluence.add(std::iter::once((node, 1.0)), ray.direction, amount, peak);
            }
        }
    }

    /// Power that leaves a leaf and its clump, as a share of its scattered power. The leaf scatters `sent` of
    /// `power`; the rest is added to `met_again`.
    fn leaves_clump(
        &self,
        world: DVec3,
        (exposed, sent): (f64, Rgb),
        power: Rgb,
        met_again: &mut [[f32; 3]],
    ) -> Rgb {
        let corners = self.cut.grid.corners(world);
        let index = self.medium.clumping.about(&corners);
        let out = self.medium.clumping.inside(index * exposed, sent);
        if index < 1.0 {
            let again = (1.0 - index) / index * out * sent * power / self.cut.grid.cell_volume();
            for (node, share) in corners.iter() {
                let sums = met_again[node].iter_mut().zip(again.to_array());
                sums.for_each(|(sum, value)| *sum += (share * value) as f32);
            }
        }
        out
    }

    /// Adds the sources of leaves that scatter the power that they received.
    fn send_from_leaves(&self, found: &mut Found) {
        let mut sent = NodeMoments::zero(self.cut.grid.count());
        for (number, leaf) in self.leaves.all().iter().enumerate() {
            let power = found.on_leaves.of(number);
            if power == [Rgb::ZERO; 2] {
                continue;
            }
            let share = (leaf.exposed, leaf.optics.albedo());
            let out = self.leaves_clump(leaf.position, share, power[0] + power[1], &mut found.met_again);
            let scattered = found.on_leaves.scattered(number, leaf);
            for (scattered, facing) in scattered.into_iter().zip([leaf.normal, -leaf.normal]) {
                let nodes = leaf_power::nodes_of(self.cut, (leaf, facing));
                let factor = FRAC_1_PI / self.cut.grid.cell_volume() * out;
                sent.add_lobe(&nodes[0], &cosine_lobe(facing), factor * scattered.through);
                sent.add_lobe(&nodes[1], &cosine_lobe(facing), factor * scattered.back);
            }
        }
        found.sources.add_nodes(&sent, 1.0);
    }

    /// Deposits power on a leaf.
    fn land(&self, point: &SurfacePoint, power: Rgb, left: &mut Left) {
        let normal = point.geometric_normal;
        if let Some(leaf) = self.leaves.number(self.snapshot, point.primitive) {
            let is_behind = normal.dot(self.leaves.all()[leaf].normal) < 0.0;
            left.on_leaves.push(LeafHit::new(leaf, usize::from(is_behind), power));
            return;
        }
        let optics = optics_of(point);
        let factor = FRAC_1_PI / self.cut.grid.cell_volume();
        let world = self.snapshot.world_from_relative(point.position);
        let out = self.leaves_clump(world, (1.0, optics.albedo()), power, &mut left.met_again);
        for (side, radiosity) in [(normal, optics.reflectance), (-normal, optics.transmittance)] {
            if radiosity == Rgb::ZERO {
                continue;
            }
            let [place, seen_from] = [AWAY, OFF_WALL].map(|cells| {
                self.snapshot.world_from_relative(point.position + cells * self.cut.grid.cell_m * side)
            });
            let corners = self.cut.corners(place, seen_from);
            left.scattered.add_lobe(&corners, &cosine_lobe(side), factor * out * power * radiosity);
        }
    }
}

fn add_on_leaves(groups: &[Left], found: &mut Found) {
    for left in groups {
        left.on_leaves.iter().for_each(|hit| found.on_leaves.add(hit));
        let sums = found.met_again.as_flattened_mut().iter_mut();
        sums.zip(left.met_again.as_flattened()).for_each(|(sum, value)| *sum += value);
    }
}

/// Mean number of scatterings of light that was scattered at least once, where `peak` of `all` was: a Poisson
/// process (van de Hulst 1980, "Multiple Light Scattering").
pub(crate) fn mean_times(peak: f32, all: f32) -> f32 {
    let share = if all > 0.0 { (peak / all).clamp(0.0, 1.0 - 1e-6) } else { 0.0 };
    let depth = -(1.0 - share).ln();
    if depth > 1e-3 { depth / share } else { 1.0 }
}
