//! The tree of a grid: a root, two levels of nodes, leaves of 8 x 8 x 8 voxels. In go bytes, out come
//! leaves and tiles. Source: `readTopology` and `readBuffers` in `openvdb/tree/`.

use super::bytes::{Bytes, Fault, Mask, Read, Value};
use super::compression::Encoding;

/// Places along an edge of each level's nodes, as powers of 2.
const UPPER: u32 = 5;
const LOWER: u32 = 4;
const LEAF: u32 = 3;
/// Voxels along an edge of what a place holds.
const OF_UPPER_PLACE: i32 = 1 << (LOWER + LEAF);
const OF_LOWER_PLACE: i32 = 1 << LEAF;
const OF_ROOT_PLACE: i32 = OF_UPPER_PLACE << UPPER;

/// Active voxels of a block of 8 x 8 x 8, z fastest.
#[derive(Debug)]
pub struct Leaf<V = f32> {
    /// First voxel.
    pub origin: [i32; 3],
    /// Values of those that are active, in order.
    pub values: Vec<V>,
    /// Which are active, a bit each, the first lowest.
    pub active: [u8; 64],
}

/// Voxels of one value.
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
    /// Value of all else.
    pub background: V,
    /// Voxels, in the file's order.
    pub leaves: Vec<Leaf<V>>,
    /// Blocks of one value.
    pub tiles: Vec<Tile<V>>,
}

/// Reads a tree, topology and values.
pub(super) fn read<V: Value>(bytes: &mut Bytes, flags: u32, is_half: bool) -> Read<Tree<V>> {
    let buffers = bytes.u32()?;
    if buffers != 1 {
        return Err(bytes.fault(format!("a tree has {buffers} buffers, not one")));
    }
    let background: V = bytes.value()?;
    let encoding = Encoding { flags, is_half, background };
    let mut tree = Tree { background, leaves: Vec::new(), tiles: Vec::new() };
    let (tiles, children) = (bytes.u32()?, bytes.u32()?);
    for _ in 0..tiles {
        let (origin, value, is_active) = (bytes.voxel()?, bytes.value()?, bytes.u8()? != 0);
        checked(bytes, value)?;
        if is_active {
            tree.tiles.push(Tile { origin, edge: OF_ROOT_PLACE, value });
        }
    }
    for _ in 0..children {
        let origin = bytes.voxel()?;
        let children = tree.topology(bytes, &encoding, Node { origin, log_edge: UPPER })?;
        for origin in children {
            let leaves = tree.topology(bytes, &encoding, Node { origin, log_edge: LOWER })?;
            for origin in leaves {
                bytes.mask(512)?;
                tree.leaves.push(Leaf { origin, values: Vec::new(), active: [0; 64] });
            }
        }
    }
    for leaf in &mut tree.leaves {
        let active = bytes.take(64)?;
        leaf.active.copy_from_slice(active);
        let active = Bytes::new(active).mask(512)?;
        let values = encoding.values(bytes, active, 512)?;
        values.iter().try_for_each(|&value| checked(bytes, value))?;
        leaf.values = Vec::with_capacity(active.count());
        leaf.values.extend(active.places().map(|place| values[place]));
    }
    Ok(tree)
}

/// A node between root and leaves.
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

impl<V: Value> Tree<V> {
    /// Keeps a node's tiles; the first voxels of its children, in order.
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
