//! Light that reaches leaves: gathered when a leaf is first seen, asked by every ray that meets it. In go a
//! field and leaves, out comes irradiance. Invariant: a leaf is no longer than a cell, so that its middle
//! stands for all of it. What it gathers depends on no other leaf's being seen, nor on who asks first.

use super::field::Field;
use super::gathered::Gathered;
use super::lobe::Lobe;
use crate::accel::PrimitiveId;
use crate::canopy::leaf_index::LeafIndex;
use crate::color::Rgb;
use crate::snapshot::Snapshot;
use glam::DVec3;
use std::sync::OnceLock;

/// Light on both sides of leaves.
pub(super) struct LeafLight {
    index: LeafIndex,
    /// Light by leaf that was seen: on the side that its normal shows, and on the other.
    sides: Vec<OnceLock<Box<[Gathered; 2]>>>,
}

impl LeafLight {
    pub(super) fn new(index: LeafIndex) -> Self {
        let sides = index.all().iter().map(|_| OnceLock::new()).collect();
        Self { index, sides }
    }

    /// The leaf that a triangle is part of, if it is, with what it gathers of a field.
    pub(super) fn of(
        &self,
        field: &Field,
        snapshot: &Snapshot,
        primitive: PrimitiveId,
    ) -> Option<LeafSides<'_>> {
        let number = self.index.number(snapshot, primitive)?;
        let leaf = &self.index.all()[number];
        let sides = self.sides[number].get_or_init(|| Box::new(field.gather_leaf(number, leaf)));
        Some(LeafSides { normal: leaf.normal, sides })
    }
}

/// Both sides of a leaf.
pub(super) struct LeafSides<'a> {
    normal: DVec3,
    sides: &'a [Gathered; 2],
}

impl LeafSides<'_> {
    /// Light that a lobe gathers at a place of it, by the leaf's albedo; by a cosine that is
    /// irradiance, W/m^2.
    pub(super) fn gathered_by(&self, field: &Field, lobe: &Lobe, sent: Rgb) -> Rgb {
        field.of_gathered(&self.sides[usize::from(!lobe.is_of_side(self.normal))], lobe, sent)
    }
}
