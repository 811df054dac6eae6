//! Small closed bodies that glow: lanterns, bulbs, embers. In go surroundings, out come facets with the nodes
//! about them. Invariant: all facets of a body count, while a few surfels stand for its extinction.

use super::clumping::Clumping;
use super::surroundings::Surroundings;
use super::surroundings::emissive::EmissivePart;
use crate::ordinates::emissive_bodies::{EmissiveBodies, EmissiveBody, OwnFacet, own_extinction};
use crate::ordinates::occluders::{CutGrid, OFF_WALL};
use glam::DVec3;
use std::collections::BTreeMap;

/// Distance in cells up to which the light of a body is even. A point has as much light there as an even ball
/// has inside that is as large as what trilinear weights cover, (3/2)^3 cells.
const NEAREST_CELLS: f64 = 0.6;

/// Bodies of a grid whose emission is apart from that of surfels.
pub(crate) fn emissive_bodies(
    cut: CutGrid,
    (surroundings, width_m): (&Surroundings, f64),
    clumping: &Clumping,
) -> EmissiveBodies {
    let (volume_m3, cell_m) = (cut.grid.cell_volume(), cut.grid.cell_m);
    let nodes = |position: DVec3, normal: DVec3, all: f64| {
        let holds = cut.grid.holds(position);
        let corners = holds.then(|| cut.corners(position, position + OFF_WALL * cell_m * normal));
        let share = move |(node, weight): (usize, f64)| (node, (all * weight / volume_m3) as f32);
        corners.into_iter().flat_map(move |corners| corners.seen().map(share).collect::<Vec<_>>())
    };
    let (mut bodies, mut own, mut sent) = (Vec::new(), Vec::new(), Vec::new());
    for part in surroundings.emissive_bodies((width_m, cell_m)) {
        let EmissivePart { facets, places, surfels } = part;
        let (mut about, mut middle) = (BTreeMap::new(), DVec3::ZERO);
        for (position, normal, all) in places {
            middle += all * position;
            nodes(position, normal, all).for_each(|(node, share)| *about.entry(node).or_insert(0.0) += share);
        }
        if about.is_empty() {
            continue;
        }
        let power: f32 = facets.iter().flat_map(|facet| facet.emission).sum();
        sent.push((middle, f64::from(power)));
        bodies.push(EmissiveBody { nodes: about.into_iter().collect(), facets });
        let of_surfels = surfels.iter().flat_map(|surfel| {
            let of_node = |(node, area_density): (usize, f32)| OwnFacet {
                node,
                normal: surfel.normal,
                density: clumping.at(node) as f32 * surfel.exposed * area_density,
            };
            nodes(surfel.position, surfel.normal, surfel.area).map(of_node)
        });
        own.push(of_surfels.collect::<Vec<_>>());
    }
    let fluence = |body: usize, node: usize| {
        let (middle, power): (DVec3, f64) = sent[body];
        power / middle.distance_squared(cut.grid.position(node)).max((NEAREST_CELLS * cell_m).powi(2))
    };
    EmissiveBodies { bodies, own: own_extinction(&own, fluence) }
}
