//! Tree of a mesh's triangles. In go positions and triangles, out come boxes and blocks for queries.
//! Invariant: it does not change after it is built.

use super::{
    block::Block,
    simd::WIDTH,
    wide_tree::{Bounds, WideTree},
};
use glam::{DVec3, Vec3};

/// A mesh's triangles, built once and shared by its instances.
#[derive(Debug)]
pub struct MeshTree {
    pub(super) tree: WideTree,
    pub(super) blocks: Vec<Block>,
    pub(super) centre: DVec3,
}

impl MeshTree {
    /// Builds the tree of `triangles`, each three indices into `positions` (in metres, in the mesh's own
    /// space). Triangles with an index out of range or a vertex that is not finite are left out.
    pub fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let corners_of = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|index| positions.get(index as usize).copied());
            Some([a?, b?, c?]).filter(|corners| corners.iter().all(|corner| corner.is_finite()))
        };
        let usable: Vec<(u32, [Vec3; 3])> = (0_u32..)
            .zip(triangles)
            .filter_map(|(index, triangle)| Some((index, corners_of(triangle)?)))
            .collect();
        let boxes: Vec<Bounds> = usable.iter().map(|(_, corners)| Bounds::of_points(*corners)).collect();
        let mut blocks = Vec::new();
        let tree = WideTree::new(&boxes, WIDTH, |primitives| {
            blocks.push(Block::new(primitives.iter().map(|&primitive| usable[primitive as usize])));
            blocks.len() as u32 - 1
        });
        let centre = (tree.bounds.min.as_dvec3() + tree.bounds.max.as_dvec3()) / 2.0;
        Self { tree, blocks, centre }
    }
}
