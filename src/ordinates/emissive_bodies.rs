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
/// that sent it stop it. It is the mean by the light at the node, of which `fluence` is told for a body and a
/// node: in a heap most of it comes from other bodies than those there.
pub(crate) fn own_extinction(
    bodies: &[Vec<OwnFacet>],
    fluence: impl Fn(usize, usize) -> f64,
) -> Vec<(usize, OrientedExtinction)> {
    let mut at_nodes: HashMap<usize, f64> = HashMap::new();
    let mut part = |(body, facet): (usize, &OwnFacet)| {
        let node = facet.node;
        let of_all = || (0..bodies.len()).map(|body| fluence(body, node)).sum();
        let all = *at_nodes.entry(node).or_insert_with(of_all);
        let share = if all > 0.0 { (fluence(body, node) / all) as f32 } else { 0.0 };
        (node, OrientedExtinction::of_facet(facet.normal, share * facet.density))
    };
    let facets = bodies.iter().enumerate();
    let facets = facets.flat_map(|(body, facets)| facets.iter().map(move |facet| (body, facet)));
    facets.map(&mut part).collect()
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

    /// The light of one of four equal bodies at one place meets the other three.
    #[test]
    fn light_meets_all_bodies_but_its_own() {
        let body = |node: usize| {
            let facet = |normal: DVec3| OwnFacet { node, normal, density: 0.2 };
            vec![facet(DVec3::X), facet(DVec3::Y)]
        };
        let taken = |bodies: &[Vec<OwnFacet>], fluences: &[f64]| {
            let products = OrientedExtinction::products(DVec3::new(0.6, 0.0, 0.8));
            let own = own_extinction(bodies, |body, _| fluences[body]);
            own.iter().filter(|(node, _)| *node == 5).map(|(_, own)| own.along(&products)).sum::<f32>()
        };
        let alone = taken(&[body(5)], &[3.0]);
        assert!(alone > 0.0);
        let bodies = [body(5), body(5), body(5), body(5)];
        assert!((taken(&bodies, &[3.0; 4]) - alone).abs() < 1e-5 * alone);
        // Where three quarters of the light are another body's, a quarter of the light does not meet its own.
        assert!((taken(&[body(5), body(6)], &[1.0, 3.0]) - 0.25 * alone).abs() < 1e-5 * alone);
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
