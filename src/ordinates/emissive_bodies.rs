//! Emission of bodies narrower than cells. In go facets with the nodes about them, out comes a source along
//! each ordinate. Invariant: a body sends its radiance times its projected area along each ordinate, and
//! takes none of that itself. Harmonics would tell a cube's faces from its edges only from l = 4 on.

use super::cross_sections::OrientedExtinction;
use glam::Vec3;

/// Bodies that emit, apart from all other emission.
#[derive(Default)]
pub(crate) struct EmissiveBodies {
    pub(crate) bodies: Vec<EmissiveBody>,
    /// Extinction of the bodies themselves, by node.
    pub(crate) own: Vec<(usize, OrientedExtinction)>,
}

/// Facets of a body, or of a piece of a long one.
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

#[cfg(test)]
mod tests {
    use super::*;

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
