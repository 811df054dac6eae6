//! Index from triangles to leaves. In go the leaves of a snapshot, out come their numbers. Invariant: a leaf
//! has the same number on every grid.

use super::surroundings::Leaf;
use crate::accel::PrimitiveId;
use crate::snapshot::Snapshot;

const NO_LEAF: u32 = u32::MAX;

/// Leaves, with the look-up of their numbers.
pub(crate) struct LeafIndex {
    all: Vec<Leaf>,
    /// Start of each mesh's parts in `leaf_of`, by the mesh's number, which is the same at all moments. The
    /// last mesh's parts end with the list.
    starts: Vec<u32>,
    leaf_of: Vec<u32>,
}

impl LeafIndex {
    /// Numbers leaves in the order of their meshes.
    pub(crate) fn new(snapshot: &Snapshot, all: Vec<Leaf>) -> Self {
        let meshes = snapshot.lasting_count();
        let mut starts = vec![0; meshes + 1];
        for leaf in &all {
            // Up to the last part that is a leaf.
            starts[snapshot.lasting_number(leaf.mesh as usize) + 1] = leaf.part + 1;
        }
        for mesh in 0..meshes {
            starts[mesh + 1] += starts[mesh];
        }
        let mut leaf_of = vec![NO_LEAF; starts[meshes] as usize];
        for (leaf, number) in all.iter().zip(0..) {
            let start = starts[snapshot.lasting_number(leaf.mesh as usize)];
            leaf_of[(start + leaf.part) as usize] = number;
        }
        Self { all, starts, leaf_of }
    }

    /// Number of the leaf that a triangle is part of; `None` if it is part of none.
    pub(crate) fn number(&self, snapshot: &Snapshot, primitive: PrimitiveId) -> Option<usize> {
        let mesh = snapshot.lasting_number(primitive.instance as usize);
        let parts = &self.leaf_of[self.starts[mesh] as usize..self.starts[mesh + 1] as usize];
        if parts.is_empty() {
            return None;
        }
        let leaf = *parts.get(snapshot.part_of(primitive))?;
        (leaf != NO_LEAF).then_some(leaf as usize)
    }

    /// All leaves, by their numbers.
    pub(crate) fn all(&self) -> &[Leaf] {
        &self.all
    }
}
