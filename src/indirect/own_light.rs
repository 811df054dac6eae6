//! What a leaf itself does to the light that it finds at the nodes about it. In go what it scatters and what
//! it gathers, out come moments without its own part. Invariant: a leaf that stands alone gets no light.
//!
//! On a grid a leaf is spread over cells, so it shines on itself and stands in its own way. A real one does
//! neither: seen from one of many leaves that stand anywhere, the others are as if it were not there
//! (Slivnyak's theorem; Chiu, Stoyan, Kendall & Mecke 2013, "Stochastic Geometry and its Applications",
//! section 4.4). A sweep is linear in what a leaf adds to it, and near its sources it is a few products.

use super::clumping::Clumping;
use super::extinction::{Extinction, Shade};
use super::grid::{Corners, Grid};
use super::harmonics::{COSINE_LOBE_4, COUNT, basis, cosine_lobe, fourth_basis, irradiance_lobe, product};
use super::leaf_index::LeafIndex;
use super::leaf_power::{self, LeafPower, Scattered};
use super::matter::Matter;
use super::moments::NodeMoments;
use super::occluders::Occluders;
use super::ordinates::{Ordinate, Ordinates};
use super::surroundings::Leaf;
use crate::color::Rgb;
use crate::scene::Bounces;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_PI, PI};

/// Steps from a node to it and those next to it.
const NEAR: usize = 27;
const HERE: usize = 13;
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
    leaf: &'a Leaf,
    /// What leaves its sides of first light and glow, W.
    scattered: [Scattered; 2],
    /// For each side the nodes that stand for it, and for what it scatters back of first light.
    pub(super) nodes: [[Corners; 2]; 2],
    /// Steps between them; first by the side that sees.
    near: [[[f32; NEAR]; 3]; 2],
    /// Extinction of fog about it, 1/m, and of leaves.
    fog: [f32; 3],
    shade: Option<&'a Shade>,
    /// Of clumping, and the share that gets out of masses of what it scatters.
    index: f64,
    inside: Rgb,
}

impl<'a> Alone<'a> {
    /// `unmet` is what its sides scatter of first light, before the leaf or others of its mass meet it again.
    pub(super) fn new(
        (grid, occluders): (&Grid, &Occluders),
        (extinction, clumping): (&'a Extinction, &Clumping),
        (leaf, unmet): (&'a Leaf, [Scattered; 2]),
    ) -> Self {
        let node = grid.nearest(leaf.position);
        let index = clumping.about(&grid.corners(leaf.position));
        let sent = leaf.scatters.sent();
        let out = clumping.inside(index * leaf.exposed, sent);
        let nodes =
            [leaf.normal, -leaf.normal].map(|facing| leaf_power::nodes_of((grid, occluders), (leaf, facing)));
        let from = [nodes[0][0], nodes[0][1], nodes[1][1]];
        let near = nodes.map(|[to, _]| from.map(|from| near(grid, &from, &to)));
        let (fog, shade) = extinction.at(node);
        let inside = clumping.inside(index, sent);
        let bent = leaf.scatters.out_of_bent(leaf.exposed);
        let glow = PI * leaf.exposed * leaf.area_m2 * inside * bent.emission;
        let scattered =
            unmet.map(|side| Scattered { back: out * side.back, through: out * side.through + glow });
        Self { leaf, scattered, nodes, near, fog, shade, index, inside }
    }

    /// What leaves its sides of the light that arrives later, W.
    fn sent(&self, arriving: [Rgb; 2]) -> [Rgb; 2] {
        let scatters = self.leaf.scatters.out_of_bent(self.leaf.exposed);
        let factor = self.leaf.exposed * self.leaf.area_m2 * self.index * self.inside;
        [0, 1].map(|side| {
            let [here, other] = [arriving[side], arriving[1 - side]];
            factor * (scatters.reflectance * here + scatters.transmittance * other)
        })
    }

    fn has_first(&self) -> bool {
        self.scattered.iter().any(|side| side.all() != Rgb::ZERO)
    }
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
        let way = |ordinate: &Ordinate| Way::of(ordinate.direction, ordinate.weight, grid.cell_m);
        let goes_on = bounces != Bounces::UpTo(1);
        Self { ways: ordinates.iter().map(way).collect(), per_volume: 1.0 / grid.cell_volume(), goes_on }
    }

    /// What all leaves scatter of their own first light, as sources.
    pub(super) fn all_sent_again(
        &self,
        (grid, occluders): (&Grid, &Occluders),
        matter: &Matter,
        (leaves, on_leaves): (&LeafIndex, &LeafPower),
    ) -> NodeMoments {
        let mut sources = NodeMoments::zero(grid.count());
        let of_leaf = |(number, leaf): (usize, &Leaf)| {
            let told = (&matter.extinction, &matter.clumping);
            let alone = Alone::new((grid, occluders), told, (leaf, on_leaves.scattered(number, leaf)));
            (alone.nodes, self.sent_again(&alone))
        };
        let all: Vec<_> = leaves.kept().par_iter().enumerate().map(of_leaf).collect();
        let factor = FRAC_1_PI * self.per_volume;
        for (leaf, (nodes, sent)) in leaves.kept().iter().zip(all) {
            for ((nodes, sent), facing) in nodes.iter().zip(sent).zip([leaf.normal, -leaf.normal]) {
                sources.add_lobe(&nodes[0], &cosine_lobe(facing), factor * sent);
            }
        }
        sources
    }

    /// What a leaf scatters of its own first light when that has come back to it, where nothing else did:
    /// power that leaves its sides, W. The second round has it, and nobody should.
    pub(super) fn sent_again(&self, alone: &Alone) -> [Rgb; 2] {
        if !alone.has_first() {
            return [Rgb::ZERO; 2];
        }
        let reach = self.reach(alone);
        let arriving = [0, 1].map(|side| {
            let mut without = [[[0.0; COUNT]; 3]; 2];
            self.take_first(alone, (&reach, side), &mut without);
            -irradiance(alone.leaf, side, &without)
        });
        alone.sent(arriving)
    }

    /// Takes a leaf's own part out of what comes to its sides.
    pub(super) fn take(&self, alone: &Alone, sides: [Arriving; 2]) {
        let reach = self.reach(alone);
        let mut left = sides.each_ref().map(|Arriving(moments, fourth)| [**moments, **fourth]);
        if alone.has_first() {
            for (side, left) in left.iter_mut().enumerate() {
                self.take_first(alone, (&reach, side), left);
            }
        }
        let arriving = [0, 1].map(|side| irradiance(alone.leaf, side, &left[side]).max(Rgb::ZERO));
        let arriving = if self.goes_on { arriving } else { [Rgb::ZERO; 2] };
        let sent = alone.sent(arriving);
        for (side, (left, Arriving(moments, fourth))) in left.iter_mut().zip(sides).enumerate() {
            let light = left[0];
            self.take_later(alone, (&reach, side), (sent, &light), left);
            [*moments, *fourth] = *left;
        }
    }

    fn reach(&self, alone: &Alone) -> Vec<[[f32; 2]; 3]> {
        self.ways.iter().map(|way| way.reach(alone)).collect()
    }

    /// What it scatters of first light, as a side sees it.
    fn take_first(&self, alone: &Alone, (reach, side): (&[[[f32; 2]; 3]], usize), from: &mut [Moments; 2]) {
        let factor = FRAC_1_PI * self.per_volume;
        let [[back, through], [back_of_other, through_other]] =
            alone.scattered.map(|side| [side.back, side.through].map(|power| (factor * power).as_vec3()));
        for (way, reach) in self.ways.iter().zip(reach) {
            let cos = way.direction.dot(alone.leaf.normal) as f32;
            let (facing, other) = (lobe(cos), lobe(-cos));
            let [of_middle, of_back, of_other] =
                alone.near[side].each_ref().map(|near| Vec3::from_array(way.gain(reach, near)));
            let radiance = of_middle * (facing * through + other * through_other)
                + of_back * (facing * back)
                + of_other * (other * back_of_other);
            way.take(radiance.to_array(), from);
        }
    }

    /// What it makes of all other light, and what it stops of that.
    fn take_later(
        &self,
        alone: &Alone,
        (reach, side): (&[[[f32; 2]; 3]], usize),
        (sent, light): ([Rgb; 2], &Moments),
        from: &mut [Moments; 2],
    ) {
        let [sent, sent_by_other] = sent.map(|sent| (FRAC_1_PI * self.per_volume * sent).as_vec3());
        let stopped = (alone.index * alone.leaf.exposed * alone.leaf.area_m2 * self.per_volume) as f32;
        for (way, reach) in self.ways.iter().zip(reach) {
            let cos = way.direction.dot(alone.leaf.normal) as f32;
            let emitted = lobe(cos) * sent + lobe(-cos) * sent_by_other;
            let facing = 3.0 / 16.0 + 15.0 / 16.0 * cos * cos;
            let radiance = light.map(|moments| {
                moments.iter().zip(&way.basis).map(|(moment, basis)| moment * basis).sum::<f32>().max(0.0)
            });
            let source = emitted - stopped * facing * Vec3::from_array(radiance);
            let gain = Vec3::from_array(way.gain(reach, &alone.near[side][0]));
            way.take((source * gain).to_array(), from);
        }
    }
}

/// Irradiance on a side.
fn irradiance(leaf: &Leaf, side: usize, [moments, fourth]: &[Moments; 2]) -> Rgb {
    let facing = if side == 0 { leaf.normal } else { -leaf.normal };
    let of_fourth = fourth_basis(-facing).map(|value| COSINE_LOBE_4 * value);
    product(&irradiance_lobe(facing), moments) + product(&of_fourth, fourth)
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
