//! Leaves of a file's grids. In go trees, out come bricks of voxels. Invariant: what is not active has the
//! value that is asked for in its place.

use crate::description::vdb::{Value, Values};
use crate::math::{BRICK, VectorVoxels};
use glam::{IVec3, Vec3};

/// Leaves with a value for what is not active.
pub(super) fn leaves<V: Value>(values: &Values<V>, off: V) -> impl Iterator<Item = (IVec3, Vec<V>)> + '_ {
    values.tree.leaves().map(move |leaf| {
        let mut values = vec![off; BRICK];
        leaf.places().for_each(|(place, value)| values[place] = value);
        (IVec3::from(leaf.origin), values)
    })
}

/// Vectors that the values of a grid stand for.
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
