//! Emission of bodies narrower than cells. In go facets with the nodes about them, out comes a source along
//! each ordinate. Invariant: a body sends its radiance times its projected area along each ordinate, and
//! takes none of that itself. Harmonics would tell a cube's faces from its edges only from l = 4 on.

use super::cross_sections::OrientedExtinction;
use glam::{DVec3, Vec3};
use std::collections::{BTreeMap, HashMap};

/// Bodies that emit, apart from all other emission.
#[derive(Default)]
pub(crate) struct EmissiveBodies {
    pub(crate) bodies: Vec<EmissiveBody>,
    /// Extinction of the body itself whose light is at a node, in parts. See [`own_extinction`].
    pub(crate) own: Vec<(usize, OrientedExtinction)>,
}

/// A body, sent from the nodes about it.
#[derive(Clone)]
pub(crate) struct EmissiveBody {
    /// Nodes about it, with their shares per volume, 1/m^3.
    pub(crate) nodes: Vec<(usize, f32)>,
    pub(crate) facets: Vec<Facet>,
}

/// A facet, seen from either side as far as the body's others do not hide it.
#[derive(Clone, Copy)]
pub(crate) struct Facet {
    pub(crate) normal: Vec3,
    /// Visible area times radiance, by channel.
    pub(crate) emission: [f32; 3],
}

impl EmissiveBodies {
    /// Bodies with nodes in another order.
    pub(super) fn laid(&self, layout: impl Fn(usize) -> usize) -> Self {
        let of_body = |body: &EmissiveBody| {
            let nodes = body.nodes.iter().map(|&(node, share)| (layout(node), share)).collect();
            EmissiveBody { nodes, ..body.clone() }
        };
        Self {
            bodies: self.bodies.iter().map(of_body).collect(),
            own: self.own.iter().map(|&(node, extinction)| (layout(node), extinction)).collect(),
        }
    }
}

impl EmissiveBody {
    /// Radiance times projected area along a direction, for one channel.
    pub(super) fn along(&self, direction: Vec3, channel: usize) -> f32 {
        let of_facet = |facet: &Facet| facet.normal.dot(direction).abs() * facet.emission[channel];
        self.facets.iter().map(of_facet).sum()
    }
}

/// A facet that stands for the extinction of a body at a node.
pub(crate) struct OwnFacet {
    pub(crate) node: usize,
    pub(crate) normal: DVec3,
    /// Visible area per volume, 1/m.
    pub(crate) density: f32,
}

/// Extinction that the light of bodies does not meet, by node: that of one body, as all bodies but the one
/// that sends it stop it. Where several share a node it is their mean by emission, of which each has as much
/// as its radiance and its area there. In go radiance and facets of each body.
pub(crate) fn own_extinction(bodies: &[(f32, Vec<OwnFacet>)]) -> Vec<(usize, OrientedExtinction)> {
    let mut emitted: HashMap<usize, f32> = HashMap::new();
    let by_body = bodies.iter().map(|(radiance, facets)| {
        let mut at_nodes: HashMap<usize, f32> = HashMap::new();
        facets.iter().for_each(|facet| *at_nodes.entry(facet.node).or_default() += radiance * facet.density);
        at_nodes.iter().for_each(|(node, of_body)| *emitted.entry(*node).or_default() += of_body);
        at_nodes
    });
    let by_body: Vec<HashMap<usize, f32>> = by_body.collect();
    let of_body = |((_, facets), at_nodes): (&'_ (f32, Vec<OwnFacet>), &HashMap<usize, f32>)| {
        let part = |facet: &OwnFacet| {
            let all = emitted[&facet.node];
            let share = if all > 0.0 { at_nodes[&facet.node] / all } else { 0.0 };
            (facet.node, OrientedExtinction::of_facet(facet.normal, share * facet.density))
        };
        facets.iter().map(part).collect::<Vec<_>>()
    };
    bodies.iter().zip(&by_body).flat_map(of_body).collect()
}

/// Steps of a normal's components within which facets count as one.
const NORMAL_STEPS: f32 = 4.0;

/// Facets of like normals as one, with their mean normal: a ball has some hundred, whatever its mesh.
pub(crate) fn merged(facets: impl Iterator<Item = Facet>) -> Vec<Facet> {
    let mut by_normal: BTreeMap<[i32; 3], (Vec3, [f32; 3])> = BTreeMap::new();
    for Facet { normal, emission } in facets {
        let steps = (NORMAL_STEPS * normal).round().as_ivec3().to_array();
        let is_down = steps < [0; 3];
        let (steps, upward) = if is_down { (steps.map(|step| -step), -normal) } else { (steps, normal) };
        let (facing, all) = by_normal.entry(steps).or_default();
        *facing += emission.iter().sum::<f32>() * upward;
        *all = std::array::from_fn(|channel| all[channel] + emission[channel]);
    }
    let facet = |(facing, emission): (Vec3, [f32; 3])| Facet { normal: facing.normalize_or_zero(), emission };
    by_normal.into_values().map(facet).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The light of one of four equal bodies meets the other three.
    #[test]
    fn light_meets_all_bodies_but_its_own() {
        let body = |density: f32| {
            let facet = |normal: DVec3| OwnFacet { node: 5, normal, density };
            (3.0, vec![facet(DVec3::X), facet(DVec3::Y)])
        };
        let taken = |bodies: &[(f32, Vec<OwnFacet>)]| {
            let products = OrientedExtinction::products(DVec3::new(0.6, 0.0, 0.8));
            own_extinction(bodies).iter().map(|(_, own)| own.along(&products)).sum::<f32>()
        };
        let alone = taken(&[body(0.2)]);
        assert!(alone > 0.0);
        assert!((taken(&[body(0.2), body(0.2), body(0.2), body(0.2)]) - alone).abs() < 1e-5 * alone);
        // Of densities 1 and 3 a quarter of the light meets the second alone, the rest the first alone.
        let mean = taken(&[body(0.2), body(0.6)]);
        assert!((mean - alone * (0.25 + 0.75 * 3.0)).abs() < 1e-5 * mean);
    }

    /// Triangles of a cube's sides are three facets, and send as much.
    #[test]
    fn like_facets_are_one() {
        let facet = |normal: Vec3| Facet { normal, emission: [0.5; 3] };
        let all = [Vec3::X, Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z].map(facet);
        let facets = merged(all.into_iter());
        assert_eq!(facets.len(), 3);
        let [cube, merged] = [all.to_vec(), facets].map(|facets| EmissiveBody { nodes: Vec::new(), facets });
        let direction = Vec3::new(0.6, 0.48, 0.64);
        assert!((cube.along(direction, 0) - merged.along(direction, 0)).abs() < 1e-6);
    }

    /// Facets of a cube of side 1, half of whose area is hidden from any side.
    #[test]
    fn a_cube_sends_its_projected_area() {
        let facet = |normal: Vec3| Facet { normal, emission: [0.5 * 2.0; 3] };
        let facets = [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|axis| [facet(axis), facet(-axis)]);
        let cube = EmissiveBody { nodes: Vec::new(), facets: facets.collect() };
        assert!((cube.along(Vec3::X, 0) - 2.0).abs() < 1e-6);
        let diagonal = cube.along(Vec3::ONE.normalize(), 1);
        assert!((diagonal - 2.0 * 3.0_f32.sqrt()).abs() < 1e-5, "{diagonal}");
    }
}
