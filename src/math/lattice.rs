//! Trilinear interpolation on a lattice. In go places in the lattice's own space, out come values. Invariant:
//! at a node the value is the node's.

use glam::DVec3;

/// Nodes at integer places from 0 on, with z fastest.
pub(super) struct Lattice {
    /// Number of nodes along each axis.
    pub(super) size: [usize; 3],
}

impl Lattice {
    pub(super) fn count(&self) -> usize {
        self.size.iter().product()
    }

    /// Place of a node by its index.
    pub(super) fn place(&self, number: usize) -> DVec3 {
        let [_, rows, row] = self.size;
        let [x, y, z] = [number / (rows * row), number / row % rows, number % row];
        DVec3::new(x as f64, y as f64, z as f64)
    }

    pub(super) fn last(&self) -> DVec3 {
        DVec3::from_array(self.size.map(|count| (count - 1) as f64))
    }

    /// Whether a place lies between its nodes.
    pub(super) fn holds(&self, at: DVec3) -> bool {
        at.cmpge(DVec3::ZERO).all() && at.cmple(self.last()).all()
    }

    /// Value at a place between the nodes, from the value of each node.
    pub(super) fn at(&self, at: DVec3, of_node: impl Fn(usize) -> f64) -> f64 {
        let node = at.to_array().map(|along| along as usize);
        let share = at - DVec3::from_array(node.map(|index| index as f64));
        let [_, rows, row] = self.size;
        let start = (node[0] * rows + node[1]) * row + node[2];
        // There is no node beyond the last, and its weight is 0.
        let to_next = |axis: usize, step: usize| if node[axis] + 1 < self.size[axis] { step } else { 0 };
        let (right, across, up) = (to_next(0, rows * row), to_next(1, row), to_next(2, 1));
        let value = |start: usize| {
            let (here, next) = (of_node(start), of_node(start + up));
            here + share.z * (next - here)
        };
        let between = |start: usize| {
            let near = value(start);
            near + share.y * (value(start + across) - near)
        };
        let near = between(start);
        near + share.x * (between(start + right) - near)
    }
}
