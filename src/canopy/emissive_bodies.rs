//! Small closed bodies that glow: lanterns, bulbs, embers. In go surroundings, out come facets with the nodes
//! about them. Invariant: all facets of a body count, while a few surfels stand for its extinction.

use super::clumping::Clumping;
use super::surroundings::Surroundings;
use super::surroundings::emissive::EmissivePart;
use crate::color::luminance;
use crate::ordinates::emissive_bodies::{EmissiveBodies, EmissiveBody, OwnFacet, own_extinction};
use crate::ordinates::occluders::{CutGrid, OFF_WALL};
use glam::DVec3;
use std::collections::BTreeMap;

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
    let (mut bodies, mut own) = (Vec::new(), Vec::new());
    for part in surroundings.emissive_bodies((width_m, cell_m)) {
        let EmissivePart { facets, places, surfels, radiance } = part;
        let mut about = BTreeMap::new();
        for (position, normal, all) in places {
            nodes(position, normal, all).for_each(|(node, share)| *about.entry(node).or_insert(0.0) += share);
        }
        if about.is_empty() {
            continue;
        }
        bodies.push(EmissiveBody { nodes: about.into_iter().collect(), facets });
        let of_surfels = surfels.iter().flat_map(|surfel| {
            let of_node = |(node, area_density): (usize, f32)| OwnFacet {
                node,
                normal: surfel.normal,
                density: clumping.at(node) as f32 * surfel.exposed * area_density,
            };
            nodes(surfel.position, surfel.normal, surfel.area).map(of_node)
        });
        own.push((luminance(radiance) as f32, of_surfels.collect::<Vec<_>>()));
    }
    EmissiveBodies { bodies, own: own_extinction(&own) }
}
