//! Power of lamps and suns that each leaf receives. In go rays that end on leaves, out come sources on the
//! grid. Invariant: a leaf scatters from one point, so its effect on itself is known; see
//! `self_interaction.rs`.

use super::surroundings::Leaf;
use crate::color::Rgb;
use crate::ordinates::grid::Corners;
use crate::ordinates::occluders::{CutGrid, OFF_WALL};
use glam::DVec3;

/// Distance in front of a lit side, in roots of its area, at which backscattered light starts. No leaf stands
/// between the side and its light, so light near that path escapes. The mean path of cosine-distributed light
/// out of a leaf's shadow, `8 r / 3 pi` across it, is .75 for normal incidence, and .6 averaged over all
/// angles. In canopies this is the hot spot (Kuusk 1991, "The hot spot effect in plant canopy reflectance").
const WAY_OUT: f64 = 0.6;

/// Power that a leaf receives from one ray, W.
pub(crate) struct LeafHit {
    leaf: u32,
    side: u8,
    power: [f32; 3],
}

impl LeafHit {
    /// Power on side 0, that of the leaf's normal, or on side 1.
    pub(crate) fn new(leaf: usize, side: usize, power: Rgb) -> Self {
        Self { leaf: leaf as u32, side: side as u8, power: power.to_array().map(|value| value as f32) }
    }
}

/// Power on both sides of each leaf, W.
pub(crate) struct LeafPower(Vec<[[f32; 3]; 2]>);

impl LeafPower {
    /// No power, for so many leaves.
    pub(crate) fn zero(leaves: usize) -> Self {
        Self(vec![[[0.0; 3]; 2]; leaves])
    }

    pub(crate) fn add(&mut self, &LeafHit { leaf, side, power }: &LeafHit) {
        let sums = self.0[leaf as usize][usize::from(side)].iter_mut().zip(power);
        sums.for_each(|(sum, value)| *sum += value);
    }

    pub(crate) fn of(&self, number: usize) -> [Rgb; 2] {
        self.0[number].map(|power| Rgb::from_array(power.map(f64::from)))
    }

    /// Power that is scattered from each of its sides.
    pub(crate) fn scattered(&self, number: usize, leaf: &Leaf) -> [Scattered; 2] {
        let power = self.of(number);
        [0, 1].map(|side| Scattered {
            back: leaf.optics.reflectance * power[side],
            through: leaf.optics.transmittance * power[1 - side],
        })
    }
}

/// Power that leaves a side of a leaf, W, before any of it meets the leaf again.
#[derive(Clone, Copy)]
pub(crate) struct Scattered {
    pub(crate) back: Rgb,
    pub(crate) through: Rgb,
}

impl Scattered {
    pub(crate) const NOTHING: Self = Self { back: Rgb::ZERO, through: Rgb::ZERO };

    pub(crate) fn all(self) -> Rgb {
        self.back + self.through
    }
}

/// Corners of a leaf on its side `facing`, and those where its backscattered light starts.
pub(crate) fn nodes_of(cut: CutGrid, (leaf, facing): (&Leaf, DVec3)) -> [Corners; 2] {
    let seen_from = leaf.position + OFF_WALL * cut.grid.cell_m * facing;
    [0.0, WAY_OUT * leaf.area_m2.sqrt()].map(|away_m| cut.corners(leaf.position + away_m * facing, seen_from))
}
