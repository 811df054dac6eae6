//! Clumps of leaves, where light is gathered. In goes a place, out comes its [`Clump`]. Invariant: where a
//! clump absorbs nothing, in even light, its leaves get what they would each by itself.

use super::clumping::Clumping;
use super::surroundings::Leaf;
use crate::color::Rgb;
use crate::ordinates::grid::Grid;
use glam::DVec3;

/// All clumps of a grid.
pub(crate) struct Clumps {
    clumping: Clumping,
    /// Irradiance that leaves give each other of the light that they scatter first, W/m^2 by node.
    given: Vec<[f32; 3]>,
}

/// The leaves that a leaf stands among.
#[derive(Clone, Copy)]
pub(crate) struct Clump {
    /// Clumping index.
    index: f64,
    /// Irradiance that they give each other of the light that they scatter first, W/m^2.
    given: Rgb,
}

impl Clump {
    /// No clump: a leaf by itself.
    pub(crate) const NONE: Self = Self { index: 1.0, given: Rgb::ZERO };
}

impl Clumps {
    pub(crate) fn new(clumping: Clumping, given: Vec<[f32; 3]>) -> Self {
        Self { clumping, given }
    }

    /// About a place of world space.
    pub(crate) fn at(&self, grid: &Grid, world: DVec3) -> Clump {
        if self.clumping.is_none() {
            return Clump::NONE;
        }
        let share = |(node, share): (usize, f64)| share * Rgb::from_array(self.given[node].map(f64::from));
        let corners = grid.corners(world);
        Clump { index: self.clumping.about(&corners), given: corners.iter().map(share).sum() }
    }

    pub(crate) fn clumping(&self) -> &Clumping {
        &self.clumping
    }

    /// A leaf's own place in one: a leaf that is bent is a clump by itself. Of first light its side scatters
    /// `unmet`, W, of which it meets a share again.
    pub(crate) fn of_leaf(&self, clump: Clump, leaf: &Leaf, unmet: Rgb) -> Clump {
        let index = clump.index * leaf.exposed;
        let out = self.clumping.inside(index, leaf.optics.albedo());
        let met_again = (1.0 - leaf.exposed) / index * out * unmet / leaf.area_m2.max(f64::MIN_POSITIVE);
        Clump { index, given: clump.given + met_again }
    }

    /// Irradiance on a leaf of a clump by that on the leaf alone, and by its albedo.
    pub(crate) fn gathered(&self, clump: Clump, by_itself: Rgb, sent: Rgb) -> Rgb {
        if clump.index < 1.0 {
            self.clumping.inside(clump.index, sent) * by_itself + clump.given
        } else {
            by_itself
        }
    }
}
