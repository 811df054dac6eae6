//! Light that reaches leaves: gathered once a leaf and side, asked by every ray that meets one. In go a
//! field and leaves, out comes irradiance. Invariant: a leaf is no longer than a cell, so that its middle
//! stands for all of it.

use super::field::Field;
use super::gathered::Gathered;
use super::leaf_index::LeafIndex;
use super::lobe::Lobe;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::snapshot::Snapshot;
use glam::DVec3;
use rayon::prelude::*;

/// What both sides of leaves get.
pub(super) struct LeafLight {
    index: LeafIndex,
    /// By leaf: its normal, and what comes to its side and to the other.
    sides: Vec<(DVec3, [Gathered; 2])>,
}

impl LeafLight {
    pub(super) fn new(field: &Field, index: LeafIndex) -> Self {
        let gather = |(number, leaf)| field.gather_leaf(number, leaf);
        let leaves = index.kept().par_iter().enumerate();
        let sides = leaves.map(|(number, leaf)| (leaf.normal, gather((number, leaf)))).collect();
        Self { index, sides }
    }

    /// The leaf that a triangle is part of, if it is, with what it has gathered, if it has.
    pub(super) fn of(&self, snapshot: &Snapshot, primitive: PrimitiveId) -> Option<Option<LeafSides<'_>>> {
        Some(self.sides.get(self.index.number(snapshot, primitive)?).map(LeafSides))
    }
}

/// Both sides of a leaf.
pub(super) struct LeafSides<'a>(&'a (DVec3, [Gathered; 2]));

impl LeafSides<'_> {
    /// What a lobe gathers at a place of it that sends a share of all light on; by a cosine that is
    /// irradiance, W/m^2.
    pub(super) fn gathered_by(&self, field: &Field, lobe: &Lobe, sent: Rgb) -> Rgb {
        let (faces, sides) = self.0;
        field.of_gathered(&sides[usize::from(!lobe.is_of_side(*faces))], lobe, sent)
    }
}
