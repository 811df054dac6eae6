//! Probes: camera rays along which indirect light is found twice, from the grid and by one random walk. In go
//! a snapshot, a job and the grid, out come both values. Invariant: a probe depends on its number, those of
//! its group and the seed alone, for any size of picture and any wanted part.

use super::importance::Importance;
use super::{Job, Method};
use crate::color::Rgb;
use crate::indirect::Indirect;
use crate::math::Sampler;
use crate::scene::Bounces;
use crate::snapshot::Snapshot;
use crate::transport::{Branches, Component, Learned, Noted, Roots, Scratch, Transport, shared_light};
use glam::DVec2;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Passes that have indirect light: of surfaces, and of fog.
pub(super) const PASSES: usize = 2;

/// Indirect light of one camera ray, by pass, W m^-2 sr^-1.
pub(super) struct Probe {
    /// Place in the picture, `0..1` across and down.
    pub(super) place: DVec2,
    /// Weight: the inverse of the density of probes.
    pub(super) weight: f64,
    pub(super) walk: [Rgb; PASSES],
    pub(super) grid: [Rgb; PASSES],
    /// Number of random points of the walk, as its length.
    pub(super) drawn: u32,
    /// Sunlit points that the walk met, until beams are learned.
    pub(super) noted: Noted,
}

/// Density of probes, the number of walks that branch off each, and beams that guide these.
pub(super) struct Plan {
    pub(super) importance: Importance,
    pub(super) branches: Branches,
    pub(super) learned: Option<Arc<Learned>>,
    /// Whether groups of probes share walks.
    pub(super) shares: bool,
}

/// Number of successive probes that share walks. They lie far apart, as Sobol points do.
pub(super) const GROUP: u32 = 8;

/// Probes of these numbers, distributed over the picture (Owen-scrambled Sobol points).
pub(super) fn probes(
    numbers: Range<u32>,
    plan: &Plan,
    snapshot: &Snapshot,
    job: &Job,
    indirect: &Indirect,
) -> Vec<Probe> {
    let by_walk = Transport { volume: Method::Paths.volume(job.bounces), ..job.transport(Some(indirect)) };
    let by_grid = Transport { volume: Method::Segments.volume(job.bounces), ..by_walk };
    // Walks of counted bounces have to end together, and blended surfaces are several of a ray.
    let shares = plan.shares && job.bounces == Bounces::All && snapshot.blended.is_empty();
    let probe = |number: u32, scratch: &mut Scratch| {
        let sampler =
            |column: u32| Sampler::new(job.seed, u32::MAX - column, number / Sampler::MAX_SAMPLES, number);
        let (place, weight) = plan.importance.sample(sampler(0).next_2d().into());
        let ray = snapshot.view.ray(place.x, place.y);
        let [(walk, drawn), (grid, _)] = [(by_walk, 1), (by_grid, 2)].map(|(transport, column)| {
            let (all, mut sampler) = (Component::Indirect(plan.branches), sampler(column));
            scratch.share_walks(shares && column == 1);
            let sample = transport.radiance_of(all, snapshot, &ray, &mut sampler, scratch);
            (sample, sampler.drawn())
        });
        let transmittance = walk.transmittance;
        let [walk, grid] = [walk, grid].map(|sample| [sample.indirect, sample.indirect_shafts]);
        let probe = Probe { place, weight, walk, grid, drawn, noted: scratch.take_noted() };
        (probe, (transmittance, scratch.take_roots()))
    };
    let groups: Vec<u32> = numbers.clone().step_by(GROUP as usize).collect();
    let of_group = |scratch: &mut Scratch, first: u32| {
        let numbers = first..numbers.end.min(first + GROUP);
        let (mut probes, shared): (Vec<_>, Vec<_>) = numbers.map(|number| probe(number, scratch)).unzip();
        if shares {
            add_shared(&mut probes, snapshot, shared);
        }
        probes
    };
    let scratch = || Scratch::with_learned(plan.learned.clone());
    groups.into_par_iter().map_init(scratch, of_group).flatten_iter().collect()
}

/// Adds the light of walks that a group shares, on surfaces past the transmittance of each probe's ray.
fn add_shared(probes: &mut [Probe], snapshot: &Snapshot, shared: Vec<(Rgb, Roots)>) {
    let (transmittances, roots): (Vec<Rgb>, Vec<Roots>) = shared.into_iter().unzip();
    let lights = shared_light(snapshot, &roots);
    for (probe, (transmittance, light)) in probes.iter_mut().zip(transmittances.into_iter().zip(lights)) {
        let [on_surface, in_fog] = light;
        probe.walk[0] += transmittance * on_surface;
        probe.walk[1] += in_fog;
    }
}
