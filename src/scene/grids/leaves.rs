//! Leaves of a file's grids. In go trees, out come bricks of voxels. Invariant: inactive voxels have the
//! value `off`.

use crate::description::vdb::{Value, Values};
use crate::math::{BRICK, VectorVoxels};
use glam::{IVec3, Vec3};

/// Leaves with `off` for inactive voxels.
pub(super) fn leaves<V: Value>(values: &Values<V>, off: V) -> impl Iterator<Item = (IVec3, Vec<V>)> + '_ {
    values.tree.leaves().map(move |leaf| {
        let mut values = vec![off; BRICK];
        leaf.places().for_each(|(place, value)| values[place] = value);
        (IVec3::from(leaf.origin), values)
    })
}

pub(super) fn vector_voxels<V: Value>(grid: &Values<V>, of: impl Fn(V) -> Vec3) -> VectorVoxels {
    let mut voxels = VectorVoxels::new(of(grid.tree.background));
    for tile in &grid.tree.tiles {
        voxels.add_even(IVec3::from(tile.origin), tile.edge, of(tile.value));
    }
    for (origin, values) in leaves(grid, grid.tree.background) {
        voxels.add(origin, values.into_iter().map(&of));
    }
    voxels
}
