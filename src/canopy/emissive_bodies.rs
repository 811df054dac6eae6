//! Small closed bodies that glow: lanterns, bulbs, embers. In go surroundings and their surfels, out come
//! facets with the nodes about them. Invariant: all facets of a body count, while a few of them stand for
//! its extinction.

use super::clumping::Clumping;
use super::surfels::{Surfel, Surfels};
use super::surroundings::{EmissivePart, Surroundings};
use crate::ordinates::cross_sections::OrientedExtinction;
use crate::ordinates::emissive_bodies::{EmissiveBodies, EmissiveBody, Facet};
use crate::ordinates::occluders::{CutGrid, OFF_WALL};

/// Bodies of a grid whose emission is apart from that of surfels.
pub(crate) fn emissive_bodies(
    cut: CutGrid,
    (surroundings, width_m): (&Surroundings, f64),
    (surfels, clumping): (&Surfels, &Clumping),
) -> EmissiveBodies {
    let volume_m3 = cut.grid.cell_volume();
    let nodes = |surfel: &Surfel| {
        let off_wall = surfel.position + OFF_WALL * cut.grid.cell_m * surfel.normal;
        let corners = cut.corners(surfel.position, off_wall);
        corners.seen().map(|(node, weight)| (node, (weight / volume_m3) as f32)).collect::<Vec<_>>()
    };
    let mut bodies = EmissiveBodies::default();
    for EmissivePart { pieces, radiance } in surroundings.emissive_bodies(width_m, cut.grid.cell_m) {
        let facet = |surfel: &Surfel| Facet {
            normal: surfel.normal.as_vec3(),
            emission: (f64::from(surfel.exposed) * surfel.area * radiance).as_vec3().to_array(),
        };
        for piece in pieces.iter().filter(|piece| cut.grid.holds(piece[0].position)) {
            let facets = piece.iter().map(facet).collect();
            bodies.bodies.push(EmissiveBody { nodes: nodes(&piece[0]), facets });
        }
    }
    if bodies.bodies.is_empty() {
        return bodies;
    }
    surfels.for_each_in(cut.grid, |surfel| {
        if surfel.emits == 0.0 {
            let area = surfel.exposed * surfel.area as f32;
            let extinction = |(node, share): (usize, f32)| {
                let density = clumping.at(node) as f32 * area * share;
                (node, OrientedExtinction::of_facet(surfel.normal, density))
            };
            bodies.own.extend(nodes(surfel).into_iter().map(extinction));
        }
    });
    bodies
}
