//! Response of a sweep to a source in neighbouring nodes. In go an ordinate and the nodes of a source, out
//! comes the source's radiance at nodes beside it. Invariant: it is the result of `angle_set.rs` in a medium
//! that is uniform around the source.

use super::cross_sections::{NodeExtinction, OrientedExtinction};
use super::grid::{Corners, Grid};
use super::harmonics::{COUNT, basis, fourth_basis};
use super::quadrature::Ordinate;
use super::sweep_kernels::Means;
use glam::{DVec3, Vec3};

/// Number of nodes around a node, with itself; the index of a step to itself.
pub(crate) const NEAR: usize = 27;
const HERE: usize = 13;

/// Moments by channel, then by harmonic.
pub(crate) type Moments = [[f32; COUNT]; 3];

/// Radiance in its own cell, and in the next, of a source of 1 per metre, by channel.
pub(crate) type Attenuation = [[f32; 2]; 3];

/// Response along one ordinate.
pub(crate) struct Response {
    pub(crate) direction: DVec3,
    products: [f32; 8],
    /// Path through a cell, metres.
    way_m: f32,
    /// Steps to the nodes downwind of the source, with their shares.
    taps: [(usize, f32); 4],
    /// Weight times basis, for degrees up to 2 and for degree 4.
    factors: [[f32; COUNT]; 2],
    pub(crate) basis: [f32; COUNT],
}

impl Response {
    pub(crate) fn of(&Ordinate { direction, weight }: &Ordinate, cell_m: f64) -> Self {
        let main = direction.abs().max_position();
        let along = direction / direction[main].abs();
        let step = |axis: usize| direction[axis].signum() as i32 * [1, 3, 9][axis];
        let [a, b] = [[1, 2], [2, 0], [0, 1]][main];
        let taps = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(is_a, is_b)| {
            let share = |axis: usize, is_beside: i32| {
                if is_beside == 1 { along[axis].abs() } else { 1.0 - along[axis].abs() }
            };
            let place = HERE as i32 + step(main) + is_a * step(a) + is_b * step(b);
            (place as usize, (share(a, is_a) * share(b, is_b)) as f32)
        });
        let (basis, fourth) = (basis(direction), fourth_basis(direction));
        Self {
            direction,
            products: OrientedExtinction::products(direction),
            way_m: (cell_m / direction[main].abs()) as f32,
            taps,
            factors: [basis, fourth].map(|basis| basis.map(|value| (weight * value) as f32)),
            basis: basis.map(|value| value as f32),
        }
    }

    /// Attenuation by an isotropic extinction by channel, 1/m, and by leaves: the mean in the source's cell,
    /// and the mean of its outgoing radiance in the next cell.
    pub(crate) fn attenuation(&self, NodeExtinction { isotropic, oriented }: NodeExtinction) -> Attenuation {
        let oriented = oriented.map_or(0.0, |oriented| oriented.along(&self.products));
        isotropic.map(|isotropic| {
            let Means { mean, mean_of_mean, .. } = Means::of(self.way_m * (isotropic + oriented));
            [self.way_m * mean_of_mean, self.way_m * mean * mean]
        })
    }

    /// Gain for the positions of source and receiver.
    pub(crate) fn gain(&self, reach: &Attenuation, near: &[f32; NEAR]) -> Vec3 {
        let next: f32 = self.taps.iter().map(|(place, share)| share * near[*place]).sum();
        Vec3::from_array(reach.map(|[here, there]| here * near[HERE] + there * next))
    }

    /// Subtracts radiance along the ordinate from moments up to degree 2, and of degree 4.
    pub(crate) fn take(&self, radiance: Vec3, from: &mut [Moments; 2]) {
        for (moments, factors) in from.iter_mut().zip(&self.factors) {
            for (moments, radiance) in moments.iter_mut().zip(radiance.to_array()) {
                moments.iter_mut().zip(factors).for_each(|(sum, factor)| *sum -= radiance * factor);
            }
        }
    }
}

/// Clamped cosine from harmonics up to l = 2.
pub(crate) fn lobe(cos: f32) -> f32 {
    0.25 + 0.5 * cos + 5.0 / 16.0 * (1.5 * cos * cos - 0.5)
}

/// Weights of each step from nodes of a source to nodes of a receiver. Farther nodes are left out.
pub(crate) fn near(grid: &Grid, from: &Corners, to: &Corners) -> [f32; NEAR] {
    let [lowest_from, lowest_to] = [from, to].map(|corners| grid.cell_of(corners.nodes[0]));
    let apart: [i32; 3] = std::array::from_fn(|axis| lowest_to[axis] as i32 - lowest_from[axis] as i32);
    let mut near = [0.0; NEAR];
    for (a, of_source) in from.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
        for (b, of_seen) in to.weights.iter().enumerate() {
            let step = |axis: usize| apart[axis] + (b >> axis & 1) as i32 - (a >> axis & 1) as i32;
            let [x, y, z] = [step(0), step(1), step(2)];
            if [x, y, z].iter().all(|step| step.abs() <= 1) {
                near[(HERE as i32 + x + 3 * y + 9 * z) as usize] += (of_source * of_seen) as f32;
            }
        }
    }
    near
}
