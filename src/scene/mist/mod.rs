//! Mist that drifts: octaves of noise, times a shape. In go a description and a time, out come voxels.
//! Invariant: they are a function of the description and the time alone; their places are tied to the shape's
//! space, through which wind carries the noise.

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

/// The smallest billows are this many voxels wide, unless one says otherwise.
const VOXELS_A_BILLOW: f64 = 4.0;
/// Voxels at most, unless one says otherwise.
const USUAL_VOXELS: f64 = (1 << 22) as f64;
/// Voxels at most in any case: 64 MB.
pub const MOST_MIST_VOXELS: f64 = (1 << 24) as f64;
/// Range of noise from where it makes mist to where mist is densest, in deviations of the noise.
const FROM_NONE_TO_ALL: f64 = 2.0;
/// Times that are kept: frames side by side ask for one each.
const KEPT: usize = 2;

/// A bank of mist. Lengths are of the shape's own space.
#[derive(Clone, Debug)]
pub struct Mist {
    /// Corners of its box.
    pub bounds: [DVec3; 2],
    /// Form of the mist.
    pub shape: MistShape,
    /// Distance over which it fades, metres.
    pub edge_m: f64,
    /// Width of the largest billows.
    pub size_m: f64,
    /// Each has billows half as wide and half as strong as the one before.
    pub octaves: u32,
    /// The share of the shape that it fills, `0..=1`.
    pub cover: Track<f64>,
    pub(crate) wind: Drift,
    /// Turns that the billows have made.
    pub evolution_turns: Track<f64>,
    /// Height `base_m` from which on it thins out, to 1/e every so many metres.
    pub base_m: f64,
    /// See `base_m`.
    pub scale_height_m: Option<Track<f64>>,
    /// Heights count from it where it is.
    pub ground: Option<Arc<GroundHeights>>,
    /// Seed of the billows.
    pub seed: u32,
    /// Between voxels.
    pub voxel_m: f64,
    pub(super) kept: Recent<State, MistVoxels>,
}

/// Nothing where there is no mist at all.
type MistVoxels = Option<Arc<LitVoxels>>;

/// All that changes in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct State {
    way: DVec3,
    turns: f64,
    cover: f64,
    scale_height_m: Option<f64>,
}

/// The usual distance between voxels for billows in a box.
pub(super) fn usual_voxel_m(bounds: [DVec3; 2], size_m: f64, octaves: u32) -> f64 {
    // A row of more voxels is too many in any case: so it ends for billows next to nothing, too.
    let least_m = (bounds[1] - bounds[0]).max_element() / USUAL_VOXELS;
    let mut voxel_m = (size_m * 0.5_f64.powi(octaves as i32 - 1) / VOXELS_A_BILLOW).max(least_m);
    while voxel_count(bounds, voxel_m) > USUAL_VOXELS {
        voxel_m *= 1.05;
    }
    voxel_m
}

/// Voxels in a box; a thin one has a layer all the same.
pub(super) fn voxel_count([low, high]: [DVec3; 2], voxel_m: f64) -> f64 {
    (((high - low) / voxel_m).ceil() + 1.0).element_product()
}

/// Billows narrower than so many voxels are left out: none of their shape would be left.
pub(super) const FEWEST_VOXELS_A_BILLOW: f64 = 2.0;

impl Mist {
    /// Tracks that change it, wind aside.
    pub(super) fn tracks(&self) -> impl Iterator<Item = &Track<f64>> {
        [&self.cover, &self.evolution_turns].into_iter().chain(&self.scale_height_m)
    }

    /// Voxels at a time, one every `voxel_m` of the shape's space; the densest is at most 1.
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
        /// Bricks that are made at a time, 8 MB: beside them all are held once.
        const AT_ONCE: usize = 1 << 12;
        let [low, high] = self.bounds.map(|corner| corner / self.voxel_m);
        let first = low.ceil().as_ivec3().div_euclid(IVec3::splat(EDGE));
        let count = high.floor().as_ivec3().div_euclid(IVec3::splat(EDGE)) - first + 1;
        /// Bricks that room is kept for, 128 MB.
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

    /// `None` where the shape has nothing.
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

    /// Density at a place, without its billows, `0..=1`.
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
        // What lies in the ground is not seen, but for what is between voxels.
        if inside == 0.0 || ground.is_some() && height_m < -2.0 * self.voxel_m {
            return 0.0;
        }
        inside * state.scale_height_m.map_or(1.0, |scale_m| (-height_m.max(0.0) / scale_m).exp())
    }
}

/// All octaves in a box, and how much of them is mist.
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
            // What is half as wide turns over twice as fast, as eddies do.
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

/// Quantile of the normal distribution, within 0.01 from 0.02 to 0.98: Tukey's lambda distribution of
/// shape 0.14.
fn normal_quantile(share: f64) -> f64 {
    4.91 * (share.powf(0.14) - (1.0 - share).powf(0.14))
}

#[cfg(test)]
mod tests;
