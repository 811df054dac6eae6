//! Light on leaves: gathered when a ray first meets a leaf, then reused. In go a field and leaves, out comes
//! irradiance. Invariant: a leaf is no longer than a cell, so its centre represents all of it. Its light does
//! not depend on the order of rays.

use super::field::Field;
use super::gathered::BothSides;
use super::lobe::Lobe;
use crate::accel::{PrimitiveId, prefetch};
use crate::canopy::leaf_index::LeafIndex;
use crate::color::Rgb;
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::sync::OnceLock;

/// Light on both sides of leaves.
pub(super) struct LeafLight {
    index: LeafIndex,
    /// Light by leaf, once a ray has met it: on the side of its normal, and on the other.
    sides: Vec<OnceLock<Box<BothSides>>>,
}

impl LeafLight {
    pub(super) fn new(index: LeafIndex) -> Self {
        let sides = index.all().iter().map(|_| OnceLock::new()).collect();
        Self { index, sides }
    }

    /// Asks for what [`Self::of`] will read of a leaf that a ray has met before.
    pub(super) fn prefetch(&self, snapshot: &Snapshot, primitive: PrimitiveId) {
        let Some(number) = self.index.number(snapshot, primitive) else { return };
        prefetch(&self.index.all()[number].normal);
        if let Some(sides) = self.sides[number].get() {
            prefetch(&**sides);
        }
    }

    /// The leaf that a triangle is part of, with its light; `None` if it is part of none.
    pub(super) fn of(
        &self,
        field: &Field,
        snapshot: &Snapshot,
        primitive: PrimitiveId,
    ) -> Option<LeafSides<'_>> {
        let number = self.index.number(snapshot, primitive)?;
        let leaf = &self.index.all()[number];
        let gathered = || Box::new(BothSides::new(field.gather_leaf(number, leaf)));
        let sides = self.sides[number].get_or_init(gathered);
        Some(LeafSides { normal: leaf.normal, sides })
    }
}

/// Both sides of a leaf.
pub(super) struct LeafSides<'a> {
    normal: DVec3,
    sides: &'a BothSides,
}

impl LeafSides<'_> {
    /// Light that a lobe gathers at a place on the leaf, for the albedo `sent`; for a cosine lobe,
    /// irradiance, W/m^2.
    pub(super) fn gathered_by(&self, field: &Field, lobe: &Lobe, sent: Rgb) -> Rgb {
        let (by_itself, clump) = self.sides.by(usize::from(!lobe.is_of_side(self.normal)), lobe);
        field.in_clump(clump, by_itself, sent)
    }
}
