//! Tree of a grid: a root, two levels of nodes, leaves of 8 x 8 x 8 voxels. In go bytes, out come leaves and
//! tiles. Invariant: both have active values alone. Source: `readTopology` and `readBuffers` in
//! `openvdb/tree/`.

use super::bytes::{Bytes, Fault, Mask, Number, Read, Value};
use super::compression::Encoding;
use std::ops::Range;

/// Places along an edge of each level's nodes, as base-2 logarithms.
const UPPER: u32 = 5;
const LOWER: u32 = 4;
const LEAF: u32 = 3;
/// Voxels along an edge of a place.
const OF_UPPER_PLACE: i32 = 1 << (LOWER + LEAF);
const OF_LOWER_PLACE: i32 = 1 << LEAF;
const OF_ROOT_PLACE: i32 = OF_UPPER_PLACE << UPPER;

/// Active voxels of a block of 8 x 8 x 8, z fastest.
#[derive(Clone, Copy, Debug)]
pub struct Leaf<'a, V = f32> {
    /// First voxel.
    pub origin: [i32; 3],
    /// Values of active voxels, in order.
    pub values: &'a [V],
    /// Mask of active voxels, a bit each, the first lowest.
    pub active: &'a [u8; 64],
}

/// Place of a leaf, and of its values among all of them.
#[derive(Debug)]
struct Block {
    origin: [i32; 3],
    active: [u8; 64],
    values: Range<usize>,
}

/// Cube of voxels with one value.
#[derive(Debug)]
pub struct Tile<V = f32> {
    /// First voxel.
    pub origin: [i32; 3],
    /// Voxels along an edge.
    pub edge: i32,
    /// Value.
    pub value: V,
}

/// Active values of a tree.
#[derive(Debug)]
pub struct Tree<V = f32> {
    /// Value outside the tree.
    pub background: V,
    blocks: Vec<Block>,
    /// Values of one block after the other: all memory goes back at once.
    values: Vec<V>,
    /// Blocks of one value.
    pub tiles: Vec<Tile<V>>,
}

/// Reads a tree, topology and values, whose numbers are written as said, `many` of them maybe shorter.
pub(super) fn read<V: Value>(bytes: &mut Bytes, flags: u32, [one, many]: [Number; 2]) -> Read<Tree<V>> {
    let buffers = bytes.u32()?;
    if buffers != 1 {
        return Err(bytes.fault(format!("a tree has {buffers} buffers, not one")));
    }
    let background: V = bytes.value(one)?;
    let encoding = Encoding { flags, one, many, background };
    let (mut tree, mut leaves) = (Tree::new(background), Vec::new());
    let (tiles, children) = (bytes.u32()?, bytes.u32()?);
    for _ in 0..tiles {
        let (origin, value, is_active) = (bytes.voxel()?, bytes.value(one)?, bytes.u8()? != 0);
        checked(bytes, value)?;
        if is_active {
            tree.tiles.push(Tile { origin, edge: OF_ROOT_PLACE, value });
        }
    }
    for _ in 0..children {
        let origin = bytes.voxel()?;
        let children = tree.topology(bytes, &encoding, Node { origin, log_edge: UPPER })?;
        for origin in children {
            for origin in tree.topology(bytes, &encoding, Node { origin, log_edge: LOWER })? {
                bytes.mask(512)?;
                leaves.push(origin);
            }
        }
    }
    for origin in leaves {
        let active: [u8; 64] = bytes.array()?;
        let mask = Bytes::new(&active).mask(512)?;
        let values = encoding.values(bytes, mask, 512)?;
        values.iter().try_for_each(|&value| checked(bytes, value))?;
        tree.push(origin, active, mask.places().map(|place| values[place]));
    }
    Ok(tree)
}

/// Node between root and leaves.
struct Node {
    origin: [i32; 3],
    log_edge: u32,
}

impl Node {
    fn first_voxel(&self, place: usize) -> [i32; 3] {
        let voxels = if self.log_edge == UPPER { OF_UPPER_PLACE } else { OF_LOWER_PLACE };
        let place = place as i32;
        let mask = (1 << self.log_edge) - 1;
        let along = [place >> (2 * self.log_edge), place >> self.log_edge & mask, place & mask];
        std::array::from_fn(|axis| self.origin[axis].wrapping_add(along[axis] * voxels))
    }
}

impl<V> Tree<V> {
    /// Tree of nothing but its background.
    pub fn new(background: V) -> Self {
        Self { background, blocks: Vec::new(), values: Vec::new(), tiles: Vec::new() }
    }

    /// Adds a leaf, of which `active` says which voxels `values` are of.
    pub fn push(&mut self, origin: [i32; 3], active: [u8; 64], values: impl IntoIterator<Item = V>) {
        let start = self.values.len();
        self.values.extend(values);
        self.blocks.push(Block { origin, active, values: start..self.values.len() });
    }

    /// Voxels, in the file's order.
    pub fn leaves(&self) -> impl ExactSizeIterator<Item = Leaf<'_, V>> {
        self.blocks.iter().map(|Block { origin, active, values }| Leaf {
            origin: *origin,
            values: &self.values[values.clone()],
            active,
        })
    }

    /// Bytes that its values take.
    pub fn memory(&self) -> usize {
        size_of_val(&*self.values) + size_of_val(&*self.blocks) + size_of_val(&*self.tiles)
    }
}

impl<V: Value> Tree<V> {
    /// Stores a node's tiles; returns the first voxels of its children, in order.
    fn topology(&mut self, bytes: &mut Bytes, encoding: &Encoding<V>, node: Node) -> Read<Vec<[i32; 3]>> {
        let places = 1 << (3 * node.log_edge);
        let (children, active): (Mask, Mask) = (bytes.mask(places)?, bytes.mask(places)?);
        let values = encoding.values(bytes, active, places)?;
        for place in active.places().filter(|&place| !children.is_on(place)) {
            checked(bytes, values[place])?;
            let edge = if node.log_edge == UPPER { OF_UPPER_PLACE } else { OF_LOWER_PLACE };
            self.tiles.push(Tile { origin: node.first_voxel(place), edge, value: values[place] });
        }
        Ok(children.places().map(|place| node.first_voxel(place)).collect())
    }
}

fn checked(bytes: &Bytes, value: impl Value) -> Read<()> {
    if value.is_finite() {
        return Ok(());
    }
    let remedy = Some("set it where it is made; halves hold 65504 at most");
    Err(Fault { remedy, ..bytes.fault("a voxel is infinite or no number") })
}
