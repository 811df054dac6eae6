//! Light that reaches leaves: gathered once a leaf and side, asked by every ray that meets one. In go a
//! field and leaves, out comes irradiance. Invariant: a leaf is no longer than a cell, so that its middle
//! stands for all of it.

use super::field::{Field, Gathered};
use super::lobe::Lobe;
use super::surroundings::Leaf;
use crate::accel::PrimitiveId;
use crate::color::Rgb;
use crate::snapshot::Snapshot;
use glam::DVec3;
use rayon::prelude::*;

/// Of more, each ray gathers by itself: memory. Which parts are leaves is known all the same.
const MOST_LEAVES: usize = 200_000;
const NO_LEAF: u32 = u32::MAX;

/// What both sides of leaves get.
pub(super) struct LeafLight {
    /// Where the parts of each mesh begin in `leaf_of`, by the number that it has at all moments; of the
    /// last they end with it.
    starts: Vec<u32>,
    leaf_of: Vec<u32>,
    /// By leaf: its normal, and what comes to its side and to the other.
    sides: Vec<(DVec3, [Gathered; 2])>,
}

impl LeafLight {
    pub(super) fn new(field: &Field, snapshot: &Snapshot, leaves: &[Leaf]) -> Self {
        let meshes = snapshot.lasting_count();
        let mut starts = vec![0; meshes + 1];
        for leaf in leaves {
            // Up to the last of its parts that is a leaf.
            starts[snapshot.lasting_number(leaf.mesh) + 1] = leaf.part as u32 + 1;
        }
        for mesh in 0..meshes {
            starts[mesh + 1] += starts[mesh];
        }
        let mut leaf_of = vec![NO_LEAF; starts[meshes] as usize];
        for (leaf, number) in leaves.iter().zip(0..) {
            leaf_of[starts[snapshot.lasting_number(leaf.mesh)] as usize + leaf.part] = number;
        }
        let gather = |leaf: &Leaf| {
            let sides = [leaf.normal, -leaf.normal].map(|normal| field.gather(leaf.position, normal));
            (leaf.normal, sides)
        };
        let gathered = if leaves.len() > MOST_LEAVES { &[] } else { leaves };
        Self { starts, leaf_of, sides: gathered.par_iter().map(gather).collect() }
    }

    /// The leaf that a triangle is part of, if it is, with what it has gathered, if it has.
    pub(super) fn of(&self, snapshot: &Snapshot, primitive: PrimitiveId) -> Option<Option<LeafSides<'_>>> {
        let mesh = snapshot.lasting_number(primitive.instance as usize);
        let parts = &self.leaf_of[self.starts[mesh] as usize..self.starts[mesh + 1] as usize];
        if parts.is_empty() {
            return None;
        }
        let leaf = *parts.get(snapshot.part_of(primitive))?;
        (leaf != NO_LEAF).then(|| self.sides.get(leaf as usize).map(LeafSides))
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
