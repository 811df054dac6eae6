//! Self-interaction of leaves: a leaf's own effect on the light at nodes around it. In go the light that it
//! scatters and gathers, out come moments without its own effect. Invariant: an isolated leaf gets no light
//! from itself.
//!
//! On a grid a leaf is spread over cells, so it would light and shade itself. A real leaf does neither: as
//! seen from one of many leaves at random places, the others are distributed as if it were absent (Slivnyak's
//! theorem; Chiu, Stoyan, Kendall & Mecke 2013, "Stochastic Geometry and its Applications", section 4.4). A
//! sweep is linear in a leaf's sources, and its response near them is a few products.

use super::clumping::Clumping;
use super::leaf_index::LeafIndex;
use super::leaf_power::{self, LeafPower, Scattered};
use super::recollision::bent;
use super::surroundings::Leaf;
use super::turbid_medium::TurbidMedium;
use crate::color::Rgb;
use crate::ordinates::cross_sections::{Extinction, NodeExtinction};
use crate::ordinates::grid::{Corners, Grid};
use crate::ordinates::harmonics::{
    COSINE_LOBE_4, COUNT, cosine_lobe, fourth_basis, irradiance_lobe, product,
};
use crate::ordinates::moments::NodeMoments;
use crate::ordinates::near_source::{Attenuation, Moments, NEAR, Response, lobe, near};
use crate::ordinates::occluders::CutGrid;
use crate::ordinates::quadrature::Quadrature;
use crate::scene::Bounces;
use glam::Vec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_1_PI, PI};

/// Number of leaves that are computed before their scattered light is added up.
const AT_ONCE: usize = 1 << 14;

/// Transport of light from node to node near its source.
pub(crate) struct SelfInteraction {
    responses: Vec<Response>,
    per_volume: f64,
    /// Whether the light that leaves receive is scattered again.
    goes_on: bool,
}

/// First light of leaves: power from lamps and suns, and optionally emission.
#[derive(Clone, Copy)]
pub(crate) struct OwnLight<'a> {
    pub(crate) on_leaves: Option<&'a LeafPower>,
    pub(crate) emitted: bool,
}

/// A leaf with its neighbourhood.
pub(crate) struct Alone<'a> {
    leaf: &'a Leaf,
    /// Power of first light and emission that leaves its sides, W.
    scattered: [Scattered; 2],
    /// Corners of each side, and of its backscattered first light.
    pub(crate) nodes: [[Corners; 2]; 2],
    /// Weights of the steps between them; the receiving side comes first.
    near: [[[f32; NEAR]; 3]; 2],
    extinction: NodeExtinction<'a>,
    /// Clumping index, and the irradiance in its clump relative to a single leaf's.
    index: f64,
    inside: Rgb,
}

impl<'a> Alone<'a> {
    /// `unmet` is the first light that its sides scatter, before any of it meets the leaf or its clump again.
    pub(crate) fn new(
        cut: CutGrid,
        (extinction, clumping): (&'a Extinction, &Clumping),
        (leaf, unmet): (&'a Leaf, [Scattered; 2]),
    ) -> Self {
        let grid = cut.grid;
        let node = grid.nearest(leaf.position);
        let index = clumping.about(&grid.corners(leaf.position));
        let sent = leaf.optics.albedo();
        let out = clumping.inside(index * leaf.exposed, sent);
        let nodes = [leaf.normal, -leaf.normal].map(|facing| leaf_power::nodes_of(cut, (leaf, facing)));
        let from = [nodes[0][0], nodes[0][1], nodes[1][1]];
        let near = nodes.map(|[to, _]| from.map(|from| near(grid, &from, &to)));
        let extinction = extinction.at(node);
        let inside = clumping.inside(index, sent);
        let bent = bent(&leaf.optics, leaf.exposed);
        let emitted = PI * leaf.exposed * leaf.area_m2 * inside * bent.emission;
        let scattered =
            unmet.map(|side| Scattered { back: out * side.back, through: out * side.through + emitted });
        Self { leaf, scattered, nodes, near, extinction, index, inside }
    }

    /// Power of later light that leaves its sides, W.
    fn sent(&self, arriving: [Rgb; 2]) -> [Rgb; 2] {
        let optics = bent(&self.leaf.optics, self.leaf.exposed);
        let factor = self.leaf.exposed * self.leaf.area_m2 * self.index * self.inside;
        [0, 1].map(|side| {
            let [here, other] = [arriving[side], arriving[1 - side]];
            factor * (optics.reflectance * here + optics.through() * other)
        })
    }

    fn has_first(&self) -> bool {
        self.scattered.iter().any(|side| side.all() != Rgb::ZERO)
    }
}

/// Attenuation along each ordinate towards a side of a leaf.
struct Reached<'a> {
    side: usize,
    by_ordinate: &'a [Attenuation],
}

/// Moments of radiance at a side: up to degree 2, and of degree 4.
pub(crate) struct Arriving<'a>(pub(crate) &'a mut Moments, pub(crate) &'a mut Moments);

impl SelfInteraction {
    pub(crate) fn new(grid: &Grid, quadrature: &Quadrature, bounces: Bounces) -> Self {
        let responses = quadrature.iter().map(|ordinate| Response::of(ordinate, grid.cell_m)).collect();
        let goes_on = bounces != Bounces::UpTo(1);
        Self { responses, per_volume: 1.0 / grid.cell_volume(), goes_on }
    }

    /// Sources that all leaves scatter of their own light: from lamps and suns, from emission, or both.
    /// Leaves without such light are left out.
    pub(crate) fn all_sent_again(
        &self,
        cut: CutGrid,
        medium: &TurbidMedium,
        leaves: &LeafIndex,
        OwnLight { on_leaves, emitted }: OwnLight,
    ) -> NodeMoments {
        let mut sources = NodeMoments::zero(cut.grid.count());
        let of_leaf = |(leaf, scattered): (&Leaf, [Scattered; 2])| {
            let matter = (&medium.cross_sections.extinction, &medium.clumping);
            let dark = if emitted { None } else { leaf.dark() };
            let alone = Alone::new(cut, matter, (dark.as_ref().unwrap_or(leaf), scattered));
            (leaf.normal, alone.nodes, self.sent_again(&alone))
        };
        let factor = FRAC_1_PI * self.per_volume;
        for (first, leaves) in (0..).step_by(AT_ONCE).zip(leaves.all().chunks(AT_ONCE)) {
            let lit = leaves.par_iter().enumerate().filter_map(|(number, leaf)| {
                let lit = on_leaves.map(|on_leaves| on_leaves.scattered(first + number, leaf));
                let scattered = lit.unwrap_or([Scattered::NOTHING; 2]);
                let is_lit = scattered.iter().any(|side| side.all() != Rgb::ZERO);
                (is_lit || emitted && leaf.optics.emission != Rgb::ZERO).then_some((leaf, scattered))
            });
            for (normal, nodes, sent) in lit.map(of_leaf).collect::<Vec<_>>() {
                for ((nodes, sent), facing) in nodes.iter().zip(sent).zip([normal, -normal]) {
                    sources.add_lobe(&nodes[0], &cosine_lobe(facing), factor * sent);
                }
            }
        }
        sources
    }

    /// Power that leaves a leaf's sides, W, when its own first light comes back to it on the grid and is
    /// scattered. The second order includes this power, which no real leaf has.
    fn sent_again(&self, alone: &Alone) -> [Rgb; 2] {
        let reach = self.attenuation(alone);
        let arriving = [0, 1].map(|side| {
            let mut without = [[[0.0; COUNT]; 3]; 2];
            self.take_first(alone, &Reached { side, by_ordinate: &reach }, &mut without);
            -irradiance(alone.leaf, side, &without)
        });
        alone.sent(arriving)
    }

    /// Subtracts a leaf's own effect from the radiance on its sides.
    pub(crate) fn take(&self, alone: &Alone, sides: [Arriving; 2]) {
        let reach = self.attenuation(alone);
        let mut left = sides.each_ref().map(|Arriving(moments, fourth)| [**moments, **fourth]);
        if alone.has_first() {
            for (side, left) in left.iter_mut().enumerate() {
                self.take_first(alone, &Reached { side, by_ordinate: &reach }, left);
            }
        }
        let arriving = [0, 1].map(|side| irradiance(alone.leaf, side, &left[side]).max(Rgb::ZERO));
        let arriving = if self.goes_on { arriving } else { [Rgb::ZERO; 2] };
        let sent = alone.sent(arriving);
        for (side, (left, Arriving(moments, fourth))) in left.iter_mut().zip(sides).enumerate() {
            let light = left[0];
            self.take_later(alone, &Reached { side, by_ordinate: &reach }, (sent, &light), left);
            [*moments, *fourth] = *left;
        }
    }

    fn attenuation(&self, alone: &Alone) -> Vec<Attenuation> {
        self.responses.iter().map(|response| response.attenuation(alone.extinction)).collect()
    }

    /// Subtracts its scattered first light, as seen from a side.
    fn take_first(&self, alone: &Alone, reach: &Reached, from: &mut [Moments; 2]) {
        let factor = FRAC_1_PI * self.per_volume;
        let [[back, through], [back_of_other, through_other]] =
            alone.scattered.map(|side| [side.back, side.through].map(|power| (factor * power).as_vec3()));
        for (response, attenuation) in self.responses.iter().zip(reach.by_ordinate) {
            let cos = response.direction.dot(alone.leaf.normal) as f32;
            let (facing, other) = (lobe(cos), lobe(-cos));
            let [of_middle, of_back, of_other] =
                alone.near[reach.side].each_ref().map(|near| response.gain(attenuation, near));
            let radiance = of_middle * (facing * through + other * through_other)
                + of_back * (facing * back)
                + of_other * (other * back_of_other);
            response.take(radiance, from);
        }
    }

    /// Subtracts the light of others that the leaf scatters, and adds back the light that it stops.
    fn take_later(
        &self,
        alone: &Alone,
        reach: &Reached,
        (sent, light): ([Rgb; 2], &Moments),
        from: &mut [Moments; 2],
    ) {
        let [sent, sent_by_other] = sent.map(|sent| (FRAC_1_PI * self.per_volume * sent).as_vec3());
        let stopped = (alone.index * alone.leaf.exposed * alone.leaf.area_m2 * self.per_volume) as f32;
        for (response, attenuation) in self.responses.iter().zip(reach.by_ordinate) {
            let cos = response.direction.dot(alone.leaf.normal) as f32;
            let emitted = lobe(cos) * sent + lobe(-cos) * sent_by_other;
            let facing = 3.0 / 16.0 + 15.0 / 16.0 * cos * cos;
            let radiance = light.map(|moments| {
                moments
                    .iter()
                    .zip(&response.basis)
                    .map(|(moment, basis)| moment * basis)
                    .sum::<f32>()
                    .max(0.0)
            });
            let source = emitted - stopped * facing * Vec3::from_array(radiance);
            response.take(source * response.gain(attenuation, &alone.near[reach.side][0]), from);
        }
    }
}

fn irradiance(leaf: &Leaf, side: usize, [moments, fourth]: &[Moments; 2]) -> Rgb {
    let facing = if side == 0 { leaf.normal } else { -leaf.normal };
    let of_fourth = fourth_basis(-facing).map(|value| COSINE_LOBE_4 * value);
    product(&irradiance_lobe(facing), moments) + product(&of_fourth, fourth)
}
