//! Clumps of leaves, where light is gathered. In goes a place, out comes its [`Clump`]. Invariant: without
//! absorption, in uniform light, leaves of a clump have the irradiance of single leaves.

use super::clumping::Clumping;
use super::surroundings::Leaf;
use crate::color::Rgb;
use crate::ordinates::grid::Grid;
use glam::DVec3;

pub(crate) struct Clumps {
    pub(crate) clumping: Clumping,
    /// Irradiance that leaves of a clump give each other by first-scattered light, W/m^2 by node.
    given: Vec<[f32; 3]>,
}

/// The clump around a leaf.
#[derive(Clone, Copy)]
pub(crate) struct Clump {
    index: f32,
    /// Irradiance that its leaves give each other by first-scattered light, W/m^2.
    given: [f32; 3],
}

impl Clump {
    /// No clump: a leaf by itself.
    pub(crate) const NONE: Self = Self { index: 1.0, given: [0.0; 3] };

    /// In single precision, as each leaf has one on both sides.
    fn new(index: f64, given: Rgb) -> Self {
        Self { index: index as f32, given: given.as_vec3().to_array() }
    }

    fn given(self) -> Rgb {
        Rgb::from_array(self.given.map(f64::from))
    }
}

impl Clumps {
    pub(crate) fn new(clumping: Clumping, given: Vec<[f32; 3]>) -> Self {
        Self { clumping, given }
    }

    /// Clump at a place in world space.
    pub(crate) fn at(&self, grid: &Grid, world: DVec3) -> Clump {
        if self.clumping.is_none() {
            return Clump::NONE;
        }
        let share = |(node, share): (usize, f64)| share * Rgb::from_array(self.given[node].map(f64::from));
        let corners = grid.corners(world);
        Clump::new(self.clumping.about(&corners), corners.iter().map(share).sum())
    }

    /// Clump of one leaf, as a bent leaf is a clump by itself. Its side scatters the first light `unmet`, W,
    /// and receives a share of that again.
    pub(crate) fn of_leaf(&self, clump: Clump, leaf: &Leaf, unmet: Rgb) -> Clump {
        let index = f64::from(clump.index) * leaf.exposed;
        let out = self.clumping.inside(index, leaf.optics.albedo());
        let met_again = (1.0 - leaf.exposed) / index * out * unmet / leaf.area_m2.max(f64::MIN_POSITIVE);
        Clump::new(index, clump.given() + met_again)
    }

    /// Irradiance on a leaf of a clump, from that on a single leaf and the albedo `sent`.
    pub(crate) fn gathered(&self, clump: Clump, by_itself: Rgb, sent: Rgb) -> Rgb {
        if clump.index < 1.0 {
            self.clumping.inside(f64::from(clump.index), sent) * by_itself + clump.given()
        } else {
            by_itself
        }
    }
}
