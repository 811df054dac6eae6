//! Cells along an ordinate. In go extinction, sources and beams, out come what each cell lets through and
//! adds, along the ordinate and its opposite. Invariant: integrals along a cell are closed forms.

use super::super::cross_sections::OrientedExtinction;
use super::super::emissive_bodies::EmissiveBodies;
use super::super::harmonics::basis;
use super::super::sweep_kernels::{AddBeam, AddSlopes, Cells, Means};
use super::{AngleSet, SweepSource};
use crate::accel::vectorized;
use glam::DVec3;

impl AngleSet<'_> {
    /// Coefficients and sources of all cells along an ordinate and its opposite.
    pub(super) fn cells(&mut self, direction: DVec3, sources: &SweepSource) {
        let products = OrientedExtinction::products(direction);
        for (oriented, &node) in
            self.cross_sections.extinction.oriented.iter().zip(self.oriented_nodes.iter())
        {
            self.own.oriented_extinction[node] = oriented.along(&products);
        }
        for (node, own) in sources.bodies.iter().flat_map(|emitting| &emitting.own) {
            let extinction = &mut self.own.oriented_extinction[*node];
            *extinction = (*extinction - own.along(&products)).max(0.0);
        }
        let way_m = (self.cell_m / direction[self.axis].abs()) as f32;
        let [along, against] = &mut self.own.added;
        let [within_along, within_against] = &mut self.own.added_within;
        vectorized(Cells {
            sources: std::array::from_fn(|index| sources.volume.channel(self.channel, index)),
            basis: &basis(direction).map(|value| value as f32),
            isotropic_extinction: &self.isotropic_extinction,
            oriented_extinction: &self.own.oriented_extinction,
            way_m,
            stretch: &self.stretch,
            through: &mut self.own.through,
            mean: &mut self.own.mean,
            added: [along, against],
            added_within: [within_along, within_against],
        });
        for beam in sources.beams {
            let [along, against] = &mut self.own.added;
            let [within_along, within_against] = &mut self.own.added_within;
            vectorized(AddBeam {
                sources: beam.channel(self.channel),
                factors: beam.factors(direction),
                isotropic_extinction: &self.isotropic_extinction,
                oriented_extinction: &self.own.oriented_extinction,
                way_m,
                stretch: &self.stretch,
                added: [along, against],
                added_within: [within_along, within_against],
            });
        }
        if let Some([x, y, z]) = &self.slopes {
            let [along, against] = &mut self.own.added;
            let [within_along, within_against] = &mut self.own.added_within;
            vectorized(AddSlopes {
                slopes: [x, y, z],
                along_axes: (basis(direction)[0] * direction).as_vec3().to_array(),
                isotropic_extinction: &self.isotropic_extinction,
                oriented_extinction: &self.own.oriented_extinction,
                way_m,
                mean: &self.own.mean,
                added: [along, against],
                added_within: [within_along, within_against],
            });
        }
    }

    /// Adds the emission of small bodies to the sources of cells.
    pub(super) fn add_bodies(&mut self, direction: DVec3, bodies: &EmissiveBodies) {
        let way_m = (self.cell_m / direction[self.axis].abs()) as f32;
        for body in &bodies.bodies {
            let emitted = body.along(direction.as_vec3(), self.channel);
            for &(node, share) in &body.nodes {
                let way_m = way_m * self.stretch[node];
                let extinction = self.isotropic_extinction[node] + self.own.oriented_extinction[node];
                let means = Means::of(way_m * extinction);
                let source = way_m * share * emitted;
                for side in [0, 1] {
                    self.own.added[side][node] += source * means.mean;
                    self.own.added_within[side][node] += source * means.mean_of_mean;
                }
            }
        }
    }
}
