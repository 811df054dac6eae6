//! What a leaf itself does to the light that it finds at the nodes about it. In go what it scatters and what
//! it gathers, out come moments without its own part. Invariant: a leaf that stands alone gets no light.
//!
//! On a grid a leaf is spread over cells, so it shines on itself and stands in its own way. A real one does
//! neither: seen from one of many leaves that stand anywhere, the others are as if it were not there
//! (Slivnyak's theorem; Chiu, Stoyan, Kendall & Mecke 2013, "Stochastic Geometry and its Applications", section
//! 4.4). A sweep is linear in what a leaf adds to it, and near its sources it is a few products.

use super::extinction::Shade;
use super::grid::{Corners, Grid};
use super::harmonics::{COSINE_LOBE_4, COUNT, basis, fourth_basis, irradiance_lobe, product};
use super::leaf_power::Scattered;
use super::ordinates::Ordinates;
use super::surroundings::Leaf;
use crate::color::Rgb;
use crate::scene::Bounces;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

/// Steps from a node to it and those next to it.
const NEAR: usize = 27;
const HERE: usize = 13;
/// Its light's own light is a share of a share.
const TIMES: usize = 2;

/// By channel, then by harmonic.
type Moments = [[f32; COUNT]; 3];

/// How light goes from node to node near its source.
pub(super) struct OwnLight {
    ways: Vec<Way>,
    per_volume: f64,
    /// Whether light that leaves get of it is sent on again.
    goes_on: bool,
}

/// One ordinate.
struct Way {
    direction: DVec3,
    products: [f32; 8],
    /// Through half a cell.
    half_m: f32,
    /// Steps to the nodes that get its light next, and their shares.
    taps: [(usize, f32); 4],
    /// Weight times basis, of degrees up to 2 and of 4.
    factors: [[f32; COUNT]; 2],
    basis: [f32; COUNT],
}

/// A leaf, and what is about it.
pub(super) struct Alone<'a> {
    pub(super) leaf: &'a Leaf,
    /// What leaves its sides of first light, W.
    pub(super) scattered: [Scattered; 2],
    /// For each side the nodes that stand for it, and for what it scatters back of first light.
    pub(super) nodes: [[Corners; 2]; 2],
    /// Extinction of fog about it, 1/m, and of leaves.
    pub(super) fog: [f32; 3],
    pub(super) shade: Option<&'a Shade>,
    /// Of clumping, and the share that gets out of masses of what it scatters.
    pub(super) index: f64,
    pub(super) inside: Rgb,
}

/// What comes to a side: moments up to degree 2, and of degree 4.
pub(super) struct Arriving<'a>(pub(super) &'a mut Moments, pub(super) &'a mut Moments);

impl Way {
    fn of(direction: DVec3, weight: f64, cell_m: f64) -> Self {
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
            products: Shade::products(direction),
            half_m: (0.5 * cell_m / direction[main].abs()) as f32,
            taps,
            factors: [basis, fourth].map(|basis| basis.map(|value| (weight * value) as f32)),
            basis: basis.map(|value| value as f32),
        }
    }

    /// Radiance that a source gives along it, metres, by channel: in the source's cell half a cell of it, in
    /// the next what leaves that.
    fn reach(&self, alone: &Alone) -> [[f32; 2]; 3] {
        let leaves = alone.shade.map_or(0.0, |shade| shade.along(&self.products));
        alone.fog.map(|fog| {
            let depth = self.half_m * (fog + leaves);
            let through = (-depth).exp();
            let here = self.half_m * if depth > 1e-4 { (1.0 - through) / depth } else { 1.0 - 0.5 * depth };
            [here, here * (1.0 + through) * through]
        })
    }

    /// The same by where the source is and where it is seen from.
    fn gain(&self, reach: &[[f32; 2]; 3], near: &[f32; NEAR]) -> [f32; 3] {
        let next: f32 = self.taps.iter().map(|(place, share)| share * near[*place]).sum();
        reach.map(|[here, there]| here * near[HERE] + there * next)
    }

    fn take(&self, radiance: [f32; 3], from: &mut [Moments; 2]) {
        for (moments, factors) in from.iter_mut().zip(&self.factors) {
            for (moments, radiance) in moments.iter_mut().zip(radiance) {
                moments.iter_mut().zip(factors).for_each(|(sum, factor)| *sum -= radiance * factor);
            }
        }
    }
}

impl OwnLight {
    pub(super) fn new(grid: &Grid, ordinates: &Ordinates, bounces: Bounces) -> Self {
        let way =
            |ordinate: &super::ordinates::Ordinate| Way::of(ordinate.direction, ordinate.weight, grid.cell_m);
        let goes_on = bounces != Bounces::UpTo(1);
        Self { ways: ordinates.iter().map(way).collect(), per_volume: 1.0 / grid.cell_volume(), goes_on }
    }

    /// Takes a leaf's own part out of what comes to its sides.
    pub(super) fn take(&self, grid: &Grid, alone: &Alone, sides: [Arriving; 2]) {
        let reach: Vec<[[f32; 2]; 3]> = self.ways.iter().map(|way| way.reach(alone)).collect();
        let [of_matter, back, back_of_other] = [alone.nodes[0][0], alone.nodes[0][1], alone.nodes[1][1]];
        // Far from walls both sides have the same nodes.
        let both = alone.nodes[0][0] == alone.nodes[1][0];
        let mut seen = [0, 1]
            .map(|side| {
                let to = alone.nodes[side][0];
                [of_matter, back, back_of_other].map(|from| near(grid, &from, &to))
            })
            .into_iter()
            .zip(sides)
            .map(|(near, Arriving(moments, fourth))| {
                let mut left = [*moments, *fourth];
                self.take_first(alone, (&reach, &near), &mut left);
                (near, left, moments, fourth)
            })
            .collect::<Vec<_>>();
        let first: Vec<[Moments; 2]> = seen.iter().map(|(_, left, ..)| *left).collect();
        for _ in 0..TIMES {
            let arriving = [0, 1].map(|side| irradiance(alone.leaf, side, &seen[side].1));
            let sent = self.sent(alone, arriving);
            for side in 0..if both { 1 } else { 2 } {
                let light = seen[side].1[0];
                let mut left = first[side];
                self.take_later(alone, (&reach, &seen[side].0[0]), (sent, &light), &mut left);
                seen[side].1 = left;
            }
            if both {
                seen[1].1 = seen[0].1;
            }
        }
        for (_, [all, of_fourth], moments, fourth) in seen {
            (*moments, *fourth) = (all, of_fourth);
        }
    }

    /// What it scatters of first light.
    fn take_first(
        &self,
        alone: &Alone,
        (reach, near): (&[[[f32; 2]; 3]], &[[f32; NEAR]; 3]),
        from: &mut [Moments; 2],
    ) {
        let factor = FRAC_1_PI * self.per_volume;
        let scattered =
            alone.scattered.map(|side| [side.back, side.through].map(|power| (factor * power).as_vec3()));
        if scattered.as_flattened().iter().all(|power| *power == glam::Vec3::ZERO) {
            return;
        }
        for (way, reach) in self.ways.iter().zip(reach) {
            let cos = way.direction.dot(alone.leaf.normal) as f32;
            let [of_matter, back, back_of_other] =
                near.each_ref().map(|near| glam::Vec3::from_array(way.gain(reach, near)));
            let [side, other] = [lobe(cos), lobe(-cos)];
            let radiance = of_matter * (side * scattered[0][1] + other * scattered[1][1])
                + back * (side * scattered[0][0])
                + back_of_other * (other * scattered[1][0]);
            way.take(radiance.to_array(), from);
        }
    }

    /// What leaves its sides of all other light, W m^-3.
    fn sent(&self, alone: &Alone, arriving: [Rgb; 2]) -> [glam::Vec3; 2] {
        let Leaf { area_m2, exposed, scatters, .. } = alone.leaf;
        let factor = area_m2 * exposed * self.per_volume;
        [0, 1].map(|side| {
            let scattered =
                scatters.reflectance * arriving[side] + scatters.transmittance * arriving[1 - side];
            let scattered = if self.goes_on { scattered } else { Rgb::ZERO };
            (factor * alone.inside * (scattered + PI * scatters.emission)).as_vec3()
        })
    }

    /// What it makes of that, and what it stops of light.
    fn take_later(
        &self,
        alone: &Alone,
        (reach, near): (&[[[f32; 2]; 3]], &[f32; NEAR]),
        (sent, light): ([glam::Vec3; 2], &Moments),
        from: &mut [Moments; 2],
    ) {
        let stopped = (alone.index * alone.leaf.exposed * alone.leaf.area_m2 * self.per_volume) as f32;
        for (way, reach) in self.ways.iter().zip(reach) {
            let cos = way.direction.dot(alone.leaf.normal) as f32;
            let emitted = FRAC_1_PI as f32 * (lobe(cos) * sent[0] + lobe(-cos) * sent[1]);
            let facing = 3.0 / 16.0 + 15.0 / 16.0 * cos * cos;
            let radiance = light.map(|moments| {
                moments.iter().zip(&way.basis).map(|(moment, basis)| moment * basis).sum::<f32>().max(0.0)
            });
            let source = emitted - stopped * facing * glam::Vec3::from_array(radiance);
            way.take((source * glam::Vec3::from_array(way.gain(reach, near))).to_array(), from);
        }
    }
}

/// Irradiance on a side.
fn irradiance(leaf: &Leaf, side: usize, [moments, fourth]: &[Moments; 2]) -> Rgb {
    let facing = if side == 0 { leaf.normal } else { -leaf.normal };
    let of_fourth = fourth_basis(-facing).map(|value| COSINE_LOBE_4 * value);
    (product(&irradiance_lobe(facing), moments) + product(&of_fourth, fourth)).max(Rgb::ZERO)
}

/// A clamped cosine by harmonics up to l = 2.
fn lobe(cos: f32) -> f32 {
    0.25 + 0.5 * cos + 5.0 / 16.0 * (1.5 * cos * cos - 0.5)
}

/// How much of what lies at some nodes is seen at others, by the steps between them. Farther ones count for
/// nothing.
fn near(grid: &Grid, from: &Corners, to: &Corners) -> [f32; NEAR] {
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
