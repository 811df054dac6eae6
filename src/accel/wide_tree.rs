//! A tree of boxes with eight children a node. In go boxes of primitives, out come nodes over leaves of up to
//! [`WIDTH`] primitives. Invariant: a child's box contains every box below it, padded by the rounding of
//! coordinates in queries in single precision.

use super::rounding::{UNIT_ROUNDOFF, round_down, round_up};
use super::simd::{Eight, WIDTH};
use crate::math::{GOLDEN, large_list};
use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, leaf_collapser::collapse, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use smallvec::SmallVec;
use std::ops::RangeInclusive;

/// Marks a child that is a leaf; the other bits are its index.
pub(super) const LEAF: u32 = 1 << 31;

/// Children that a query has still to visit. Seven for each of eighteen levels take no memory of the heap.
pub(super) type Stack<Child> = SmallVec<[Child; 128]>;

/// Padding of nodes' boxes, in roundings of their largest coordinate. Queries add as much for their own
/// numbers. For a ray, shearing moves a vertex by at most 6 (two differences, a product, a quotient), and the
/// slab test moves a plane by at most 4. Evaluating an affine function rounds gradient, product and three
/// sums, at the box and again at a vertex, and a cut adds 4: 2 * 5 + 4.
const BOX_PADDING_ROUNDOFFS: f64 = 16.0;

/// The index of a node's plane: `[min x, max x, min y, max y, min z, max z]`.
pub(super) const fn plane(axis: usize, upper: bool) -> usize {
    2 * axis + upper as usize
}

/// The boxes of up to eight children, one child a lane.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Node {
    /// Planes by [`plane`]. Lanes without a child hold an inverted, infinite box that no ray meets.
    pub(super) planes: [Eight; 6],
    /// Index of a node, or [`LEAF`] and index of a leaf.
    pub(super) children: [u32; WIDTH],
}

impl Node {
    const EMPTY: Self = Self {
        planes: [
            Eight([f32::INFINITY; WIDTH]),
            Eight([f32::NEG_INFINITY; WIDTH]),
            Eight([f32::INFINITY; WIDTH]),
            Eight([f32::NEG_INFINITY; WIDTH]),
            Eight([f32::INFINITY; WIDTH]),
            Eight([f32::NEG_INFINITY; WIDTH]),
        ],
        children: [LEAF; WIDTH],
    };

    /// Sets a child with its box, padded by the box's own magnitude and not the tree's: small objects next to
    /// a ground of thousands of kilometres keep small boxes.
    fn set_child(&mut self, lane: usize, bounds: Bounds, child: u32) {
        let padding = padding(bounds.magnitude().max_element().into());
        for axis in 0..3 {
            self.planes[plane(axis, false)].0[lane] = round_down(f64::from(bounds.min[axis]) - padding);
            self.planes[plane(axis, true)].0[lane] = round_up(f64::from(bounds.max[axis]) + padding);
        }
        self.children[lane] = child;
    }
}

/// Padding of a coordinate, or of a sum of terms, of a magnitude.
pub(super) fn padding(magnitude: f64) -> f64 {
    BOX_PADDING_ROUNDOFFS * UNIT_ROUNDOFF * magnitude
}

/// An axis-aligned box; inverted and infinite when empty.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
}

impl Bounds {
    pub(super) const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    pub(super) fn of_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, point| Self {
            min: bounds.min.min(point),
            max: bounds.max.max(point),
        })
    }

    pub(super) fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The largest magnitude of a coordinate on each axis; 0 when empty.
    pub(super) fn magnitude(self) -> Vec3 {
        if self.min.x > self.max.x { Vec3::ZERO } else { self.min.abs().max(self.max.abs()) }
    }

    pub(super) fn is_empty(self) -> bool {
        self.min.x > self.max.x
    }
}

/// The tree. Its owner stores the leaves.
#[derive(Debug)]
pub(super) struct WideTree {
    pub(super) nodes: Vec<Node>,
    /// First child to visit; `None` if there is no primitive.
    pub(super) root: Option<u32>,
    pub(super) bounds: Bounds,
    /// Bounds of the root's children.
    pub(super) top_boxes: Vec<Bounds>,
}

impl WideTree {
    /// Builds a tree over `boxes`, which must be finite. Passes the primitives of each leaf, at most
    /// `leaf_size <= WIDTH`, to `add_leaf`, which returns the leaf's index.
    pub(super) fn new(boxes: &[Bounds], leaf_size: usize, mut add_leaf: impl FnMut(&[u32]) -> u32) -> Self {
        let bounds = boxes.iter().fold(Bounds::EMPTY, |all, one| all.union(*one));
        let mut tree = Self { nodes: Vec::new(), root: None, bounds, top_boxes: vec![bounds] };
        if boxes.is_empty() {
            return tree;
        }
        if boxes.len() <= leaf_size {
            let primitives: Vec<u32> = (0..boxes.len() as u32).collect();
            tree.root = Some(LEAF | add_leaf(&primitives));
            return tree;
        }
        let binary = build_binary(boxes, leaf_size);
        tree.root = Some(0);
        // An open shutter has dozens of trees, and a list that grows takes up to three times as much.
        tree.nodes = large_list(binary.wide_nodes());
        tree.nodes.push(Node::EMPTY);
        let mut unfilled = vec![(0_usize, 0_usize)];
        while let Some((binary_node, wide_node)) = unfilled.pop() {
            let children = binary.open_largest(binary_node);
            if wide_node == 0 {
                tree.top_boxes = children.iter().map(|child| binary.bounds(*child)).collect();
            }
            for (lane, child) in children.into_iter().enumerate() {
                let reference = if binary.is_leaf(child) {
                    LEAF | add_leaf(binary.primitives(child))
                } else {
                    tree.nodes.push(Node::EMPTY);
                    unfilled.push((child, tree.nodes.len() - 1));
                    tree.nodes.len() as u32 - 1
                };
                tree.nodes[wide_node].set_child(lane, binary.bounds(child), reference);
            }
        }
        tree
    }
}

/// Maximum shift of a box before the builder, as a fraction of its extent.
///
/// PLOC merges boxes that are each other's best partner. In a row of equal boxes at equal distances all pairs
/// are equally good, each box chooses its neighbour on the same side, and a whole pass merges one pair:
/// 100,000 slats of a fence took minutes. With slightly different distances a third of them agree.
const LARGEST_SHIFT: f64 = 1.0 / 4096.0;

/// Minimum size of boxes that the builder gets, as a fraction of the largest coordinate: smaller ones are
/// enlarged to it and shifted by up to as much. Otherwise their areas would be rounded to equal values or 0,
/// and all pairs would be equally good.
const SMALLEST_BOX: f32 = 1.0 / (1 << 20) as f32;

/// Memory that the builder takes for each box, at most.
const BUILDER_BYTES: usize = 320;

/// A binary tree by PLOC with reinsertion (Meister and Bittner 2018, 2022), as obvhs builds it with its
/// medium settings. Built in one thread: the same tree every time.
fn build_binary(boxes: &[Bounds], leaf_size: usize) -> BinaryTree {
    // Scaling by a power of two brings coordinates near 1, so no area overflows.
    let largest = boxes.iter().fold(0.0_f32, |m, b| m.max(b.magnitude().max_element()));
    let scale = (-f64::from(largest).log2().ceil()).clamp(-200.0, 200.0).exp2();
    let scaled = |v: Vec3| Vec3A::from((v.as_dvec3() * scale).as_vec3());
    let moved = |(index, b): (usize, &Bounds)| {
        let (min, max) = (scaled(b.min), scaled(b.max));
        // Multiples of the golden ratio are evenly distributed, for any number.
        let fraction = (index as f64 * GOLDEN).fract();
        if (max - min).max_element() < SMALLEST_BOX {
            let min = min + fraction as f32 * SMALLEST_BOX;
            return Aabb::new(min, min + SMALLEST_BOX);
        }
        let shift = (fraction * LARGEST_SHIFT) as f32 * (max - min);
        Aabb::new(min + shift, max + shift)
    };
    let count = boxes.len();
    // Where memory ends the builder panics, and the standard library says so.
    drop(std::hint::black_box(large_list::<u8>(BUILDER_BYTES * count)));
    let mut moved_boxes: Vec<Aabb> = large_list(count);
    moved_boxes.extend(boxes.iter().enumerate().map(moved));
    let (search, sort) = (PlocSearchDistance::Medium, SortPrecision::U64);
    // As `PlocBuilder::with_capacity` and `Bvh2::zeroed`, but their lists give their memory back.
    let mut builder = PlocBuilder::new();
    builder.current_nodes = large_list(count);
    builder.next_nodes = large_list(count);
    builder.mortons = large_list(count.div_ceil(2));
    let mut tree = Bvh2 { nodes: large_list(2 * count), ..Bvh2::default() };
    builder.build_with_bvh(&mut tree, search, &moved_boxes, (0..count as u32).collect(), sort, 3);
    drop((builder, moved_boxes));
    let mut reinsertion = ReinsertionOptimizer::default();
    reinsertion.run(&mut tree, 0.05, None);
    collapse(&mut tree, leaf_size as u32, 3.0);
    // Reinsertion sizes its stack by the depth after PLOC, although it has made the tree deeper, and panics
    // when the stack is full.
    tree.max_depth = tree.max_depth.max(depth(&tree) + 1);
    reinsertion.run(&mut tree, 0.1, None);
    let (bounds, leaves) = summed_up(&tree, boxes);
    BinaryTree { tree, bounds, leaves }
}

/// Number of nodes on the longest path from the root to a leaf.
fn depth(tree: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut unvisited = vec![(0, 1)];
    while let Some((node, depth)) = unvisited.pop() {
        deepest = deepest.max(depth);
        let node = &tree.nodes[node];
        if !node.is_leaf() {
            let first_child = node.first_index as usize;
            unvisited.extend([(first_child, depth + 1), (first_child + 1, depth + 1)]);
        }
    }
    deepest
}

/// Bounds of the `boxes` below each node, and the number of leaves there.
fn summed_up(tree: &Bvh2, boxes: &[Bounds]) -> (Vec<Bounds>, Vec<u32>) {
    let mut parents_first = vec![0];
    let mut next = 0;
    while let Some(&node) = parents_first.get(next) {
        let node = &tree.nodes[node];
        if !node.is_leaf() {
            parents_first.extend([node.first_index as usize, node.first_index as usize + 1]);
        }
        next += 1;
    }
    let (mut bounds, mut leaves) = (large_list(tree.nodes.len()), vec![1; tree.nodes.len()]);
    bounds.resize(tree.nodes.len(), Bounds::EMPTY);
    for index in parents_first.into_iter().rev() {
        let node = &tree.nodes[index];
        let first = node.first_index as usize;
        if node.is_leaf() {
            let primitives = &tree.primitive_indices[first..first + node.prim_count as usize];
            let boxes = primitives.iter().map(|primitive| boxes[*primitive as usize]);
            bounds[index] = boxes.fold(Bounds::EMPTY, Bounds::union);
        } else {
            bounds[index] = bounds[first].union(bounds[first + 1]);
            leaves[index] = leaves[first] + leaves[first + 1];
        }
    }
    (bounds, leaves)
}

/// A tree as the builder returns it, with its nodes' unshifted boxes and the number of leaves below each.
struct BinaryTree {
    tree: Bvh2,
    bounds: Vec<Bounds>,
    leaves: Vec<u32>,
}

impl BinaryTree {
    fn is_leaf(&self, node: usize) -> bool {
        self.tree.nodes[node].is_leaf()
    }

    fn primitives(&self, leaf: usize) -> &[u32] {
        let node = &self.tree.nodes[leaf];
        let first = node.first_index as usize;
        &self.tree.primitive_indices[first..first + node.prim_count as usize]
    }

    fn bounds(&self, node: usize) -> Bounds {
        self.bounds[node]
    }

    /// Number of nodes with eight children each.
    fn wide_nodes(&self) -> usize {
        let (mut count, mut uncounted) = (0, vec![0]);
        while let Some(node) = uncounted.pop() {
            count += 1;
            uncounted.extend(self.open_largest(node).into_iter().filter(|&child| !self.is_leaf(child)));
        }
        count
    }

    /// Up to eight descendants that replace `node`, found by repeatedly opening the largest box. What a node
    /// can hold is opened only if all of it fits: else nodes near the leaves would be half empty.
    fn open_largest(&self, node: usize) -> Vec<usize> {
        let mut opened = vec![node];
        while opened.len() < WIDTH {
            let area = |index: usize| self.tree.nodes[opened[index]].aabb().half_area();
            let largest = |leaves: RangeInclusive<usize>| {
                let may_open = |index: &usize| leaves.contains(&(self.leaves[opened[*index]] as usize));
                (0..opened.len()).filter(may_open).max_by(|a, b| area(*a).total_cmp(&area(*b)))
            };
            let room = WIDTH + 1 - opened.len();
            let Some(largest) = largest(WIDTH + 1..=usize::MAX).or_else(|| largest(2..=room)) else { break };
            let first_child = self.tree.nodes[opened[largest]].first_index as usize;
            opened[largest] = first_child;
            opened.push(first_child + 1);
        }
        opened
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Sampler;

    /// A query reads whole nodes, however few children they have.
    #[test]
    fn nodes_are_well_filled() {
        let mut sampler = Sampler::new(1, 0, 0, 0);
        let mut leaf = || {
            let ((x, y), z) = (sampler.next_2d(), sampler.next_1d());
            let min = Vec3::new(x as f32, y as f32, z as f32);
            Bounds { min, max: min + 0.01 }
        };
        let boxes: Vec<Bounds> = (0..5000).map(|_| leaf()).collect();
        let mut leaves = 0;
        let tree = WideTree::new(&boxes, 1, |_| {
            leaves += 1;
            leaves - 1
        });
        // All but the root are children.
        let children = (leaves as usize + tree.nodes.len() - 1) as f64 / tree.nodes.len() as f64;
        assert!(children > 5.0, "{children}");
    }
}
