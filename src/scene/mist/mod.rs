//! Drifting mist: octaves of noise, times a shape. In go a description and a time, out come voxels.
//! Invariant: they depend on these two alone. The voxels are fixed in the shape's space, and wind moves the
//! noise through it.

mod ground;

pub use ground::GroundHeights;

use super::Track;
use super::drift::Drift;
pub use crate::description::ron::MistShape;
use crate::math::{
    BRICK, FLOW_NOISE_DEVIATION, FlowNoise, LitVoxels, NoiseWithin, Recent, Voxels, VoxelsBuilder,
};
use glam::{DVec3, IVec3};
use rayon::prelude::*;
use std::sync::Arc;

/// Default width in voxels of the smallest billows.
const VOXELS_A_BILLOW: f64 = 4.0;
/// Default maximum number of voxels.
const USUAL_VOXELS: f64 = (1 << 22) as f64;
/// Maximum number of voxels in any case: 64 MB.
pub const MOST_MIST_VOXELS: f64 = (1 << 24) as f64;
/// Range of the noise from no mist to the densest mist, in standard deviations.
const FROM_NONE_TO_ALL: f64 = 2.0;
/// Number of cached times: neighbouring frames need one each.
const KEPT: usize = 2;

/// Volume of mist. Lengths are in the shape's space.
#[derive(Clone, Debug)]
pub struct Mist {
    /// Corners of its box.
    pub bounds: [DVec3; 2],
    /// Shape of the mist.
    pub shape: MistShape,
    /// Distance over which it fades, metres.
    pub edge_m: f64,
    /// Width of the largest billows.
    pub size_m: f64,
    /// Number of octaves, each with billows half as wide and half as strong.
    pub octaves: u32,
    /// Fraction of the shape that it fills, `0..=1`.
    pub cover: Track<f64>,
    pub(crate) wind: Drift,
    /// Turns of the billows' evolution.
    pub evolution_turns: Track<f64>,
    /// Height `base_m` above which density falls off, by 1/e over `scale_height_m`.
    pub base_m: f64,
    /// See `base_m`.
    pub scale_height_m: Option<Track<f64>>,
    /// Ground from which heights count, where it exists.
    pub ground: Option<Arc<GroundHeights>>,
    /// Seed of the billows.
    pub seed: u32,
    /// Size of voxels.
    pub voxel_m: f64,
    pub(super) kept: Recent<State, MistVoxels>,
}

/// `None` without any mist.
type MistVoxels = Option<Arc<LitVoxels>>;

/// Time-dependent parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    way: DVec3,
    turns: f64,
    cover: f64,
    scale_height_m: Option<f64>,
}

/// Default size of voxels for billows in a box.
pub(super) fn usual_voxel_m(bounds: [DVec3; 2], size_m: f64, octaves: u32) -> f64 {
    // A limit, for very small billows: a row of more voxels than this is refused anyway.
    let least_m = (bounds[1] - bounds[0]).max_element() / USUAL_VOXELS;
    let mut voxel_m = (size_m * 0.5_f64.powi(octaves as i32 - 1) / VOXELS_A_BILLOW).max(least_m);
    while voxel_count(bounds, voxel_m) > USUAL_VOXELS {
        voxel_m *= 1.05;
    }
    voxel_m
}

/// Number of voxels in a box; a thin one has at least one layer.
pub(super) fn voxel_count([low, high]: [DVec3; 2], voxel_m: f64) -> f64 {
    (((high - low) / voxel_m).ceil() + 1.0).element_product()
}

/// Octaves with billows narrower than this many voxels are left out, as voxels cannot resolve them.
pub(super) const FEWEST_VOXELS_A_BILLOW: f64 = 2.0;

impl Mist {
    /// Tracks that change it, except the wind.
    pub(super) fn tracks(&self) -> impl Iterator<Item = &Track<f64>> {
        [&self.cover, &self.evolution_turns].into_iter().chain(&self.scale_height_m)
    }

    /// Voxels at a time, one every `voxel_m` of the shape's space; densities are at most 1.
    pub fn voxels(&self, time_s: f64) -> MistVoxels {
        let state = State {
            way: self.wind.way(time_s),
            turns: self.evolution_turns.at(time_s),
            cover: self.cover.at(time_s),
            scale_height_m: self.scale_height_m.as_ref().map(|track| track.at(time_s)),
        };
        self.kept.of(state, KEPT, || self.made(&state).map(|voxels| Arc::new(voxels.into())))
    }

    fn made(&self, state: &State) -> Option<Voxels> {
        const EDGE: i32 = 8;
        /// Bricks that are computed in parallel, 8 MB beside the result.
        const AT_ONCE: usize = 1 << 12;
        let [low, high] = self.bounds.map(|corner| corner / self.voxel_m);
        let first = low.ceil().as_ivec3().div_euclid(IVec3::splat(EDGE));
        let count = high.floor().as_ivec3().div_euclid(IVec3::splat(EDGE)) - first + 1;
        /// Bricks for which memory is reserved at once, 128 MB.
        const MOST_RESERVED: usize = 1 << 16;
        let places = count.element_product().max(0);
        let brick = |place: i32| {
            let along = IVec3::new(place / (count.y * count.z), place / count.z % count.y, place % count.z);
            let first = EDGE * (first + along);
            Some((first, self.brick(first, state)?))
        };
        let mut builder = VoxelsBuilder::of_up_to((places as usize).min(MOST_RESERVED));
        for start in (0..places).step_by(AT_ONCE) {
            let bricks = start..places.min(start + AT_ONCE as i32);
            for (first, values) in bricks.into_par_iter().filter_map(brick).collect::<Vec<_>>() {
                builder.add(first, values);
            }
        }
        builder.built().ok()
    }

    /// Voxels of a brick; `None` outside the shape.
    fn brick(&self, first: IVec3, state: &State) -> Option<[f32; BRICK]> {
        let place = |index: usize| {
            let along = IVec3::new(index as i32 / 64, index as i32 / 8 % 8, index as i32 % 8);
            (first + along).as_dvec3() * self.voxel_m
        };
        let mut values: [f32; BRICK] = std::array::from_fn(|index| self.shape_at(place(index), state) as f32);
        values.iter().any(|value| *value > 0.0).then(|| {
            let noise = Billows::new(self, state, [place(0), place(BRICK - 1)]);
            for (index, value) in values.iter_mut().enumerate().filter(|(_, value)| **value > 0.0) {
                *value *= noise.at(place(index)) as f32;
            }
            values
        })
    }

    /// Density at a place without noise, `0..=1`.
    fn shape_at(&self, place: DVec3, state: &State) -> f64 {
        let [low, high] = self.bounds;
        let fade = |distance_m: f64| {
            let share = if self.edge_m > 0.0 { distance_m / self.edge_m } else { distance_m.signum() };
            let share = share.clamp(0.0, 1.0);
            share * share * (3.0 - 2.0 * share)
        };
        let inside = match self.shape {
            MistShape::Box => {
                let within = (place - low).min(high - place);
                let is_above = if place.y >= low.y { 1.0 } else { 0.0 };
                fade(within.x) * fade(within.z) * fade(high.y - place.y) * is_above
            }
            MistShape::Ellipsoid => {
                let half = 0.5 * (high - low);
                fade((1.0 - ((place - low) / half - 1.0).length()) * half.min_element())
            }
        };
        let ground = self.ground.as_ref().and_then(|ground| ground.at(place));
        let height_m = place.y - ground.unwrap_or(self.base_m);
        // Mist in the ground is invisible, except near its surface, where voxels are interpolated.
        if inside == 0.0 || ground.is_some() && height_m < -2.0 * self.voxel_m {
            return 0.0;
        }
        inside * state.scale_height_m.map_or(1.0, |scale_m| (-height_m.max(0.0) / scale_m).exp())
    }
}

/// All octaves in a box, and the threshold of mist.
struct Billows {
    octaves: Vec<NoiseWithin>,
    way: DVec3,
    per_size: f64,
    per_deviation: f64,
    threshold: f64,
}

impl Billows {
    fn new(mist: &Mist, state: &State, [low, high]: [DVec3; 2]) -> Self {
        let per_size = mist.size_m.recip();
        let least_m = FEWEST_VOXELS_A_BILLOW * mist.voxel_m;
        let is_wide = |octave: &u32| mist.size_m / f64::from(1 << octave) >= least_m;
        let count = 1 + (1..mist.octaves).take_while(is_wide).count() as u32;
        let octaves = (0..count).map(|octave| {
            let factor = f64::from(1 << octave);
            let [low, high] = [low, high].map(|corner| factor * per_size * (corner - state.way));
            // Billows half as wide evolve twice as fast, as eddies do.
            let noise = FlowNoise { seed: mist.seed.wrapping_add(octave), turns: factor * state.turns };
            noise.within(low, high)
        });
        let variance: f64 = (0..count).map(|octave| 0.25_f64.powi(octave as i32)).sum();
        Self {
            octaves: octaves.collect(),
            way: state.way,
            per_size,
            per_deviation: (variance.sqrt() * FLOW_NOISE_DEVIATION).recip(),
            threshold: normal_quantile(1.0 - state.cover),
        }
    }

    fn at(&self, place: DVec3) -> f64 {
        let (mut sum, mut factor) = (0.0, 1.0);
        let place = self.per_size * (place - self.way);
        for octave in &self.octaves {
            sum += octave.at(factor * place) / factor;
            factor *= 2.0;
        }
        ((self.per_deviation * sum - self.threshold) / FROM_NONE_TO_ALL).clamp(0.0, 1.0)
    }
}

/// Quantile of the normal distribution, accurate to 0.01 from 0.02 to 0.98: Tukey's lambda distribution of
/// shape 0.14.
fn normal_quantile(share: f64) -> f64 {
    4.91 * (share.powf(0.14) - (1.0 - share).powf(0.14))
}

#[cfg(test)]
mod tests;
